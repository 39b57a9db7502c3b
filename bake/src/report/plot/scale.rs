//! A logarithmic axis: from values to points on the sheet, and where its ticks are.

use super::super::numbers::power_of_ten;

/// Beyond the outermost values, in decades.
const MARGIN: f64 = 0.12;
/// At least, in decades: a single value is not all of the axis.
const LEAST: f64 = 0.9;
/// The most decades with a label each, and with lines between.
const MOST_LABELS: i32 = 8;
const MOST_FINE: f64 = 4.0;

/// Decades `low` to `high` along points `from` to `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

/// A line of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub at: f64,
    pub value: f64,
    /// Empty between decades.
    pub label: String,
    pub is_decade: bool,
}

impl Scale {
    /// Holds all values that have a logarithm.
    pub fn of(values: impl IntoIterator<Item = f64>, [from, to]: [f64; 2]) -> Self {
        let logs = values.into_iter().filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| (low.min(log), high.max(log)));
        let (low, high) = if low <= high { (low, high) } else { (-1.0, 1.0) };
        let lacks = (LEAST - (high - low) - 2.0 * MARGIN).max(0.0) / 2.0;
        Self { low: low - MARGIN - lacks, high: high + MARGIN + lacks, from, to }
    }

    /// None where the value has no logarithm.
    pub fn at(&self, value: f64) -> Option<f64> {
        let share = (value.log10() - self.low) / (self.high - self.low);
        (value > 0.0 && value.is_finite()).then_some(self.from + share * (self.to - self.from))
    }

    pub fn ticks(&self, label: impl Fn(f64) -> String) -> Vec<Tick> {
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let decades = (self.low.ceil() as i32..=self.high.floor() as i32).count() as i32;
        let every = (decades + MOST_LABELS - 1).div_euclid(MOST_LABELS).max(1);
        let is_fine = self.high - self.low <= MOST_FINE;
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for digit in 1..=if is_fine { 9 } else { 1 } {
                let value = f64::from(digit) * 10f64.powi(exponent);
                let told =
                    if digit == 1 { exponent.rem_euclid(every) == 0 } else { self.tells(digit, decades) };
                let inside = (self.low..=self.high).contains(&value.log10());
                let Some(at) = self.at(value).filter(|_| inside) else { continue };
                let label = if told { label(value) } else { String::new() };
                ticks.push(Tick { at, value, label, is_decade: digit == 1 });
            }
        }
        ticks
    }

    /// Where there are few decades, 2 and 5 have labels too, and where there is none, more have.
    fn tells(&self, digit: u32, decades: i32) -> bool {
        match decades {
            ..=1 => digit == 2 || digit == 5 || (self.high - self.low < 1.0 && digit == 3),
            _ => false,
        }
    }
}

/// 0.001, 20, 10⁵
pub fn number(value: f64) -> String {
    let exponent = value.log10().round();
    if (value / 10f64.powf(exponent) - 1.0).abs() < 1e-9 {
        return power_of_ten(exponent as i32);
    }
    super::super::numbers::one_digit(value)
}

/// 100 %, 0.1 %, 10⁻⁵
pub fn share(value: f64) -> String {
    if value < 0.9e-4 { number(value) } else { format!("{} %", number(100.0 * value)) }
}

/// 5 MB
pub fn bytes(value: f64) -> String {
    let (unit, name) = match value {
        ..0.9e3 => (1.0, "B"),
        ..0.9e6 => (1e3, "kB"),
        ..0.9e9 => (1e6, "MB"),
        _ => (1e9, "GB"),
    };
    format!("{} {name}", number(value / unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_lie_in_their_order_and_inside() {
        let scale = Scale::of([1e-3, 2.0, 30.0], [100.0, 700.0]);
        let at: Vec<f64> = [1e-3, 2.0, 30.0].iter().map(|value| scale.at(*value).unwrap()).collect();
        assert!(at.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(at[0] > 100.0 && at[2] < 700.0);
        assert!([0.0, -1.0, f64::NAN, f64::INFINITY].iter().all(|value| scale.at(*value).is_none()));
    }

    #[test]
    fn every_axis_has_labels_however_long_or_short() {
        let axes: [&[f64]; 6] = [&[], &[3.0], &[0.0, f64::NAN], &[2.0, 2.1], &[1e-12, 1e9], &[0.4, 700.0]];
        for values in axes {
            let ticks = Scale::of(values.iter().copied(), [0.0, 600.0]).ticks(number);
            let labels: Vec<_> = ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
            assert!((2..=9).contains(&labels.len()), "{values:?}: {labels:?}");
            assert!(ticks.iter().all(|tick| (0.0..=600.0).contains(&tick.at)), "{values:?}: {ticks:?}");
        }
    }

    #[test]
    fn ticks_are_told_as_they_are_read() {
        assert_eq!([0.01, 1.0, 20.0, 0.5, 1e6].map(number), ["0.01", "1", "20", "0.5", "10⁶"]);
        assert_eq!([1.0, 0.02, 1e-4, 1e-6].map(share), ["100 %", "2 %", "0.01 %", "10⁻⁶"]);
    }
}
