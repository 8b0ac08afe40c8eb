//! One axis: its range, its label and its ticks at round values.

/// An axis: its range, label and unit.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Value at the left or lower end.
    pub low: f64,
    /// Value at the right or upper end.
    pub high: f64,
    /// Quantity, with unit.
    pub label: String,
    /// Whether `low`, `high` and the data are decimal logarithms of the ticks' values.
    logarithmic: bool,
}

impl Axis {
    /// An axis over exactly this range.
    pub fn new(low: f64, high: f64, label: &str) -> Self {
        Self {
            low,
            high: if high > low { high } else { low + 1.0 },
            label: label.to_string(),
            logarithmic: false,
        }
    }

    /// A logarithmic axis from `low` to `high`, both positive: places on it are decimal logarithms.
    pub fn logarithmic(low: f64, high: f64, label: &str) -> Self {
        Self {
            logarithmic: true,
            ..Self::new(low.log10(), high.log10(), label)
        }
    }

    /// An axis that holds all values with a margin of `margin` of their span.
    pub fn around(values: impl IntoIterator<Item = f64>, margin: f64, label: &str) -> Self {
        let (low, high) = values
            .into_iter()
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        if low > high {
            return Self::new(0.0, 1.0, label);
        }
        let span = (high - low).max(1e-9);
        Self::new(low - margin * span, high + margin * span, label)
    }

    /// Ticks at round values: (value, text).
    pub fn ticks(&self, about: usize) -> Vec<(f64, String)> {
        if self.logarithmic {
            return self.decades();
        }
        let span = self.high - self.low;
        let rough = span / about.max(1) as f64;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0]
            .iter()
            .map(|factor| factor * power)
            .find(|step| *step >= rough * 0.999)
            .unwrap_or(power * 10.0);
        let digits = (0..8)
            .find(|digits| {
                let scaled = step * 10_f64.powi(*digits);
                (scaled - scaled.round()).abs() < 1e-6 * scaled
            })
            .unwrap_or(8) as usize;
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last)
            .map(|k| {
                let value = k as f64 * step;
                (
                    value,
                    crate::data::table::cell(value, digits).replace('-', "\u{2212}"),
                )
            })
            .collect()
    }

    /// Ticks at 1, 2 and 5 of every decade.
    fn decades(&self) -> Vec<(f64, String)> {
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        decades
            .flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| (digit, decade)))
            .map(|(digit, decade)| {
                let value = digit * 10_f64.powi(decade);
                let digits = usize::try_from(-decade).unwrap_or(0);
                (value.log10(), crate::data::table::cell(value, digits))
            })
            .filter(|(place, _)| (self.low - 1e-9..=self.high + 1e-9).contains(place))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let axis = Axis::new(-0.03, 0.31, "error [m]");
        let texts: Vec<String> = axis.ticks(6).into_iter().map(|(_, text)| text).collect();
        assert_eq!(texts, ["0.0", "0.1", "0.2", "0.3"]);
        let texts: Vec<String> = Axis::new(-15.0, 20.0, "")
            .ticks(7)
            .into_iter()
            .map(|(_, text)| text)
            .collect();
        assert_eq!(texts.first().map(String::as_str), Some("\u{2212}15"));
        assert_eq!(texts.len(), 8);
    }

    #[test]
    fn logarithmic_ticks_are_ones_twos_and_fives() {
        let axis = Axis::logarithmic(0.2, 20.0, "");
        let (places, texts): (Vec<f64>, Vec<String>) = axis.ticks(6).into_iter().unzip();
        assert_eq!(texts, ["0.2", "0.5", "1", "2", "5", "10", "20"]);
        assert!((places[5] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn an_axis_around_nothing_is_still_an_axis() {
        let axis = Axis::around([f64::NAN], 0.1, "");
        assert!(axis.high > axis.low);
        let axis = Axis::around([2.0, 2.0], 0.1, "");
        assert!(axis.high > axis.low);
    }
}
