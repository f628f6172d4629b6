//! An axis of a plot: its range, and ticks at round values.

use super::canvas::{GAP, MEDIUM, SMALL, TICK, width};
use std::ops::Range;

/// One axis of a plot: its range (of log10 where logarithmic) and its ticks.
pub struct Axis {
    /// Values at the ends of the axis, log10 of them where it is logarithmic.
    pub range: Range<f64>,
    pub(super) label: String,
    /// Places and their texts; a minor tick has none.
    pub(super) ticks: Vec<(f64, String)>,
    /// Whether the places are entries of a legend.
    pub(super) names: bool,
}

impl Axis {
    /// An axis from 0 to 1 without ticks or label.
    pub fn blank() -> Axis {
        Axis::new(0.0..1.0, "", Vec::new())
    }

    /// A linear axis over exactly `range` with about `count` ticks.
    pub fn linear(range: Range<f64>, label: &str, count: i32) -> Axis {
        let (values, step) = round_ticks(&range, count);
        let largest = range.start.abs().max(range.end.abs());
        let tick = |value: f64| (value, number(value, step, largest));
        Axis::new(range, label, values.into_iter().map(tick).collect())
    }

    /// A logarithmic axis over exactly `range`, which is of log10, with up to about `count` labels.
    pub fn logarithmic(range: Range<f64>, label: &str, count: i32) -> Axis {
        let decades = range.start.floor() as i32..=range.end.ceil() as i32;
        let stride = decades.clone().count() / count.max(1) as usize + 1;
        let multiples = |factors: &[i32]| -> Vec<f64> {
            let every = decades.clone().step_by(stride);
            let values =
                every.flat_map(|k| factors.iter().map(move |f| f64::from(*f) * 10f64.powi(k)));
            values.filter(|value| range.contains(&value.log10())).collect()
        };
        let enough = |all: &Vec<f64>| all.len() > 2 || (stride > 1 && all.len() > 1);
        let sparse = [multiples(&[1]), multiples(&[1, 2, 5])].into_iter().find(enough);
        // Each with the step that its digits have to show: its own size, or that of ticks within
        // one decade.
        let linear = || {
            let (values, step) =
                round_ticks(&(10f64.powf(range.start)..10f64.powf(range.end)), count);
            values.into_iter().map(|value| (value, step)).collect::<Vec<_>>()
        };
        let minor = if stride == 1 { multiples(&[2, 3, 4, 5, 6, 7, 8, 9]) } else { Vec::new() };
        let minor = minor.into_iter().map(|value| (value.log10(), String::new()));
        let sparse = sparse.map(|values| values.into_iter().map(|value| (value, value)).collect());
        let named = sparse.unwrap_or_else(linear).into_iter();
        let ticks =
            named.map(|(value, step)| (value.log10(), number(value, step, value))).chain(minor);
        let ticks = ticks.collect();
        Axis::new(range, label, ticks)
    }

    /// An axis with these places and their texts as ticks.
    fn new(range: Range<f64>, label: &str, ticks: Vec<(f64, String)>) -> Axis {
        Axis { range, label: label.to_owned(), ticks, names: false }
    }

    /// The entries of a legend, one a unit from 0 on.
    pub fn of_names(label: &str, names: impl Iterator<Item = String>) -> Axis {
        let places: Vec<_> = names.enumerate().map(|(k, name)| (k as f64 + 0.5, name)).collect();
        Axis { names: true, ..Axis::new(0.0..places.len().max(1) as f64, label, places) }
    }

    /// Whether it is the entries of a legend.
    pub fn is_of_names(&self) -> bool {
        self.names
    }

    /// Shifts the axis to places that are less by `by`; its texts stay as they are.
    pub fn from(self, by: f64) -> Axis {
        let ticks = self.ticks.iter().map(|(value, text)| (value - by, text.clone())).collect();
        Axis { range: self.range.start - by..self.range.end - by, ticks, ..self }
    }

    /// Takes all text from the axis and keeps its ticks.
    pub fn unnamed(self) -> Axis {
        let ticks = self.ticks.into_iter().map(|(value, _)| (value, String::new()));
        Axis::new(self.range, "", ticks.collect())
    }

    /// Takes all text from the axis and keeps the grid lines of its ticks.
    pub fn hushed(self) -> Axis {
        let hush = |text: String| if text.is_empty() { text } else { " ".to_owned() };
        let ticks = self.ticks.into_iter().map(|(value, text)| (value, hush(text)));
        Axis::new(self.range, "", ticks.collect())
    }

    /// Reverses the axis: it runs from its high end to its low end.
    pub fn reversed(self) -> Axis {
        Axis { range: self.range.end..self.range.start, ..self }
    }

    /// The ticks that have text.
    pub(super) fn named(&self) -> impl Iterator<Item = &(f64, String)> {
        self.ticks.iter().filter(|tick| !tick.1.is_empty())
    }

    /// Room that the tick labels and the label need beside a vertical axis.
    pub fn room(&self) -> i32 {
        let widest = self.ticks.iter().map(|(_, text)| width(text, SMALL)).max().unwrap_or(0);
        if self.names {
            return TICK + GAP + widest.max(width(&self.label, SMALL));
        }
        TICK + GAP + widest + if self.label.is_empty() { 0 } else { GAP + MEDIUM }
    }

    /// Where a value lies, from 0 at the start to 1 at the end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        (value - self.range.start) / (self.range.end - self.range.start)
    }
}

/// Round values inside a range, and the step between them: about `count`, and two at least.
fn round_ticks(range: &Range<f64>, count: i32) -> (Vec<f64>, f64) {
    let least = (range.end - range.start) / f64::from(count.max(1));
    let magnitude = 10f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * magnitude);
    let coarse = (1..3).find(|k| steps[*k] >= least).unwrap_or(3);
    let ticks = |step: f64| -> Vec<f64> {
        let first = (range.start / step - 1e-6).ceil();
        let values = (0..100).map(|k| (first + f64::from(k)) * step);
        values.take_while(|value| *value <= range.end + 1e-6 * step).collect()
    };
    match ticks(steps[coarse]) {
        few if few.len() < 2 => (ticks(steps[coarse - 1]), steps[coarse - 1]),
        enough => (enough, steps[coarse]),
    }
}

/// A tick's value to the digits that its step needs, in powers of ten only where plain digits would
/// be long.
fn number(value: f64, step: f64, largest: f64) -> String {
    let order = |value: f64| (value.abs().log10() + 1e-9).floor() as i32;
    let text = if value.abs() < 1e-6 * step {
        "0".to_owned()
    } else if largest >= 1e6 || step < 1e-4 {
        format!("{:.*e}", (order(value) - order(step)).max(0) as usize, value)
    } else {
        format!("{:.*}", (-order(step)).max(0) as usize, value)
    };
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    #[test]
    fn axis_has_two_ticks_at_least() {
        assert_eq!(
            super::round_ticks(&(-44.0..44.0), 4),
            (vec![-40.0, -20.0, 0.0, 20.0, 40.0], 20.0)
        );
        assert_eq!(super::round_ticks(&(0.0..160.0), 4).0, [0.0, 50.0, 100.0, 150.0]);
    }
}
