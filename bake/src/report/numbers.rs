//! Numbers as people read them: the digits that mean something, and units.

/// Three digits that count: 0.00123, 1.23, 123, 12300. Beyond what reads well: 1.23·10⁻⁷.
pub fn plain(value: f64) -> String {
    digits(value, 3)
}

/// A share in percent, two digits that count, signed where asked for: 1.4 %, +0.021 %, 12 %.
pub fn share(value: f64) -> String {
    match value.abs() {
        size if size == 0.0 || (1e-5..1e4).contains(&size) => format!("{} %", digits(100.0 * value, 2)),
        _ => digits(value, 2),
    }
}

pub fn signed_share(value: f64) -> String {
    let sign = if value > 0.0 { "+" } else { "" };
    format!("{sign}{}", share(value))
}

/// Seconds: 0.35 ms, 12 s, 4.5 min.
pub fn seconds(value: f64) -> String {
    match value {
        _ if !value.is_finite() => digits(value, 2),
        ..1.0 => format!("{} ms", digits(1e3 * value, 2)),
        ..100.0 => format!("{} s", digits(value, 2)),
        _ => format!("{} min", digits(value / 60.0, 2)),
    }
}

pub fn milliseconds(value: f64) -> String {
    format!("{} ms", digits(value, 2))
}

/// A quantity on an axis with this unit.
pub fn quantity(value: f64, unit: &str) -> String {
    match unit {
        "s" => seconds(value),
        "bytes" => bytes(value),
        "" => plain(value),
        unit => format!("{} {unit}", plain(value)),
    }
}

pub fn bytes(bytes: f64) -> String {
    let (scale, unit) = match bytes {
        ..1e3 => (1.0, "B"),
        ..1e6 => (1e-3, "kB"),
        ..1e9 => (1e-6, "MB"),
        _ => (1e-9, "GB"),
    };
    format!("{} {unit}", digits(bytes * scale, 3))
}

/// Times so much: 0.5, 1.15, 3.4.
pub fn factor(value: f64) -> String {
    let places = if value < 10.0 { 2 } else { 0 };
    if (0.01..1e4).contains(&value) { format!("{value:.places$}") } else { digits(value, 2) }
}

/// A power of ten: 0.01, 1, 1000, 10⁻⁵, 10⁶.
pub fn power_of_ten(exponent: i32) -> String {
    match exponent {
        -3..=4 => digits(10f64.powi(exponent), 1),
        _ => format!("10{}", superscript(exponent)),
    }
}

/// 20, 0.5, 3·10⁷
pub fn one_digit(value: f64) -> String {
    digits(value, 1)
}

fn digits(value: f64, count: i32) -> String {
    if !value.is_finite() {
        return if value.is_nan() { "no number".to_owned() } else { "∞".to_owned() };
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let mut exponent = value.abs().log10().floor() as i32;
    // 9.99 to two digits is 10.
    if rounded(value.abs() / 10f64.powi(exponent), count) >= 10.0 {
        exponent += 1;
    }
    let minus = |text: String| text.replace('-', "\u{2212}");
    match exponent {
        -3..=6 => {
            let step = 10f64.powi(exponent - count + 1);
            let places = (count - 1 - exponent).max(0) as usize;
            minus(format!("{:.places$}", (value / step).round() * step))
        }
        _ => {
            let places = (count - 1) as usize;
            minus(format!("{:.places$}", value / 10f64.powi(exponent))) + "·10" + &superscript(exponent)
        }
    }
}

fn rounded(value: f64, count: i32) -> f64 {
    let scale = 10f64.powi(count - 1);
    (value * scale).round() / scale
}

fn superscript(exponent: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    exponent.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_count() {
        let wanted = ["0.00123", "1.23", "123", "12300", "−0.5", "0", "1.23·10⁻⁷", "1.2·10¹²"];
        let values = [0.001234, 1.234, 123.4, 12345.0, -0.5, 0.0, 1.234e-7, 1.2e12];
        for (value, wanted) in values.into_iter().zip(wanted) {
            let digits = match wanted {
                "−0.5" => digits(value, 1),
                "1.2·10¹²" => digits(value, 2),
                _ => plain(value),
            };
            assert_eq!(digits, wanted);
        }
        assert_eq!([9.996, 0.9996, 99.96].map(plain), ["10.0", "1.00", "100"]);
    }

    #[test]
    fn shares_times_and_bytes_have_units_that_fit() {
        assert_eq!(
            [0.0142, 0.12, 2.1e-4, 3e-9, 0.0].map(share),
            ["1.4 %", "12 %", "0.021 %", "3.0·10⁻⁹", "0 %"]
        );
        assert_eq!([0.002, -0.002].map(signed_share), ["+0.20 %", "−0.20 %"]);
        assert_eq!([0.00035, 2.0, 270.0].map(seconds), ["0.35 ms", "2.0 s", "4.5 min"]);
        assert_eq!([12.0, 2.5e6].map(bytes), ["12.0 B", "2.50 MB"]);
        assert_eq!([-5, -2, 0, 4, 6].map(power_of_ten), ["10⁻⁵", "0.01", "1", "10000", "10⁶"]);
    }

    #[test]
    fn what_is_no_number_is_said_to_be_none() {
        for text in [plain(f64::NAN), share(f64::NAN), seconds(f64::NAN), factor(f64::NAN)] {
            assert_eq!(text, "no number");
        }
        assert_eq!(plain(f64::INFINITY), "∞");
    }
}
