//! Numbers as people type them: `1.5`, `2*3+1`, `(4-1)/2`, `30cm`, `90deg`. What has a unit is converted to the field's.

/// What a field counts in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    #[default]
    None,
    Metres,
    Degrees,
    Kelvin,
    Stops,
    Seconds,
    /// Radiant intensity, W/sr.
    Intensity,
    /// Irradiance, W/m2.
    Irradiance,
}

impl Unit {
    pub fn suffix(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Metres => " m",
            Self::Degrees => "\u{b0}",
            Self::Kelvin => " K",
            Self::Stops => " EV",
            Self::Seconds => " s",
            Self::Intensity => " W/sr",
            Self::Irradiance => " W/m\u{b2}",
        }
    }

    /// How many of the field's units one of these is.
    fn named(self, name: &str) -> Option<f64> {
        let found = match (self, name) {
            (_, "") => 1.0,
            (Self::Metres, "m") | (Self::Degrees, "\u{b0}" | "deg") | (Self::Kelvin, "K" | "k") => 1.0,
            (Self::Stops, "EV" | "ev") | (Self::Seconds, "s") => 1.0,
            (Self::Metres, "mm") => 1e-3,
            (Self::Metres, "cm") => 1e-2,
            (Self::Metres, "km") => 1e3,
            (Self::Metres, "in") => 0.0254,
            (Self::Metres, "ft") => 0.3048,
            (Self::Degrees, "rad") => 180.0 / std::f64::consts::PI,
            (Self::Degrees, "turn") => 360.0,
            (Self::Seconds, "ms") => 1e-3,
            (Self::Seconds, "min") => 60.0,
            _ => return None,
        };
        Some(found)
    }
}

/// `None`: it is no number.
pub fn number(text: &str, unit: Unit) -> Option<f64> {
    let text = text.trim();
    let whole = match unit {
        // With a stroke in it: no part of a sum.
        Unit::Intensity | Unit::Irradiance => text.strip_suffix(unit.suffix().trim()).unwrap_or(text),
        _ => text,
    };
    let mut rest = Rest { text: whole, unit, depth: 0 };
    let value = rest.sum()?;
    (rest.text.trim().is_empty() && value.is_finite()).then_some(value)
}

struct Rest<'a> {
    text: &'a str,
    unit: Unit,
    /// Brackets and signs that are open: a text of a million of them is no number.
    depth: u32,
}

impl Rest<'_> {
    fn take(&mut self, sign: char) -> bool {
        self.text = self.text.trim_start();
        let rest = self.text.strip_prefix(sign);
        self.text = rest.unwrap_or(self.text);
        rest.is_some()
    }

    fn sum(&mut self) -> Option<f64> {
        let mut value = self.product()?;
        loop {
            if self.take('+') {
                value += self.product()?;
            } else if self.take('-') || self.take('\u{2212}') {
                value -= self.product()?;
            } else {
                return Some(value);
            }
        }
    }

    fn product(&mut self) -> Option<f64> {
        let mut value = self.factor()?;
        loop {
            if self.take('*') {
                value *= self.factor()?;
            } else if self.take('/') {
                value /= self.factor()?;
            } else {
                return Some(value);
            }
        }
    }

    fn factor(&mut self) -> Option<f64> {
        self.depth += 1;
        if self.depth > 64 {
            return None;
        }
        let value = self.bare_factor();
        self.depth -= 1;
        value
    }

    fn bare_factor(&mut self) -> Option<f64> {
        if self.take('-') || self.take('\u{2212}') {
            return Some(-self.factor()?);
        }
        if self.take('+') {
            return self.factor();
        }
        let value = if self.take('(') {
            let value = self.sum()?;
            self.take(')').then_some(value)?
        } else {
            self.plain()?
        };
        Some(value * self.unit_name()?)
    }

    fn plain(&mut self) -> Option<f64> {
        let digits =
            self.text.find(|c: char| !c.is_ascii_digit() && c != '.' && c != ',').unwrap_or(self.text.len());
        let mut end = digits;
        let exponent = self.text[digits..].strip_prefix(['e', 'E']);
        if let Some(exponent) =
            exponent.filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
        {
            let signed = usize::from(exponent.starts_with('-'));
            let length = exponent[signed..].find(|c: char| !c.is_ascii_digit());
            end += 1 + signed + length.unwrap_or(exponent.len() - signed);
        }
        let (number, rest) = self.text.split_at(end);
        self.text = rest;
        number.replace(',', ".").parse().ok()
    }

    fn unit_name(&mut self) -> Option<f64> {
        self.text = self.text.trim_start();
        let end = self.text.find(|c: char| !c.is_alphabetic() && c != '\u{b0}').unwrap_or(self.text.len());
        let (name, rest) = self.text.split_at(end);
        self.text = rest;
        self.unit.named(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_products_brackets_and_signs_are_worked_out() {
        for (text, expected) in [
            ("1.5", 1.5),
            (" 2 * 3 + 1 ", 7.0),
            ("(4-1)/2", 1.5),
            ("-2*-3", 6.0),
            ("1e-3*2", 2e-3),
            ("0,25", 0.25),
            ("\u{2212}3", -3.0),
            ("2-3-4", -5.0),
        ] {
            assert_eq!(number(text, Unit::None), Some(expected), "{text}");
        }
    }

    #[test]
    fn units_are_converted_to_those_of_the_field() {
        let metres = |text| number(text, Unit::Metres).unwrap();
        assert!((metres("30cm + 1m") - 1.3).abs() < 1e-12);
        assert!((metres("2 ft") - 0.6096).abs() < 1e-12);
        assert!((number("0.5 turn", Unit::Degrees).unwrap() - 180.0).abs() < 1e-12);
        assert_eq!(number("90\u{b0}", Unit::Degrees), Some(90.0));
        assert_eq!(number("3 m", Unit::Degrees), None);
    }

    #[test]
    fn what_is_no_number_is_none() {
        for text in
            ["", "x", "1+", "1 2", "(1", "1/0", ".", "1..2", &"(".repeat(1_000_000), &"-".repeat(100_000)]
        {
            assert_eq!(number(text, Unit::None), None, "{:.20}", text);
        }
    }
}
