//! A vector over time, a panel for each component that matters: one that is zero within rounding is
//! named, and peaks of single steps do not flatten the rest.

use super::kinds::quantile;
use crate::figure::{Axes, Chart, Series};
use mics_run::words::rounded;

pub(super) const NAMES: [&str; 3] = ["x", "y", "z"];

/// A component whose largest value is below this part of the largest one's is not drawn.
pub const SHOWN: f64 = 1e-3;
/// A component below this part of the largest one's is zero within rounding and the limit of the
/// pressure.
const ROUNDING: f64 = 1e-5;
/// Part of the values at either end that a vertical axis of forces leaves out, where they would
/// widen it by [`WIDER`]: the peaks of single steps in which bodies collide.
const PEAKS: f64 = 0.02;
/// Widening of a vertical axis above which its peaks are cut off.
const WIDER: f64 = 3.0;

/// A chart of a vector: what it is, its unit, a title and notes, and whether the peaks of single
/// steps are cut off.
pub(super) struct Vector<'a> {
    pub what: &'a str,
    pub unit: &'a str,
    pub title: String,
    pub notes: Vec<String>,
    pub cut_peaks: bool,
}

impl Vector<'_> {
    /// The plots of the components that matter, with the notes that say what is left out; none
    /// where there is nothing to show.
    pub fn chart(mut self, plots: Vec<Vec<Series>>) -> Option<Chart> {
        let sizes: Vec<f64> = plots.iter().map(|series| largest(series)).collect();
        let most = sizes.iter().copied().fold(0.0, f64::max);
        let matters = |axis: usize| sizes[axis] > SHOWN * most || most == 0.0 && axis == 0;
        let (shown, left_out): (Vec<usize>, Vec<usize>) =
            (0..plots.len()).partition(|axis| matters(*axis));
        self.name_left_out(&left_out, &sizes, most);
        let range = |axis: usize| without_peaks(&plots[axis]).filter(|_| self.cut_peaks);
        let ranges: Vec<Option<[f64; 2]>> = (0..plots.len()).map(range).collect();
        let peaked: Vec<usize> =
            shown.iter().copied().filter(|axis| ranges[*axis].is_some()).collect();
        if !peaked.is_empty() {
            let most = rounded(significant(most_of(&peaked, &sizes)));
            let unit = self.unit;
            self.notes
                .push(format!("along {} peaks of up to {most} {unit} are cut off", along(&peaked)));
        }
        let mut panels = Vec::new();
        for (axis, mut series) in plots.into_iter().enumerate().filter(|(axis, _)| matters(*axis)) {
            // One legend for all.
            if !panels.is_empty() {
                series.iter_mut().for_each(|one| one.label.clear());
            }
            let axes = Axes {
                x_label: "time (s)".into(),
                y_label: format!("{} along {} ({})", self.what, NAMES[axis], self.unit),
                range_y: ranges[axis],
                ..Axes::default()
            };
            panels.push((axes, series));
        }
        if let Some((first, _)) = panels.first_mut() {
            first.title = self.title;
            first.note = self.notes.join("; ");
        }
        Some(Chart { panels, beside: false }).filter(Chart::shows)
    }

    /// Notes on the components that are not drawn, of these largest values, where the largest of
    /// all is `most`.
    fn name_left_out(&mut self, left_out: &[usize], sizes: &[f64], most: f64) {
        let (zero, small): (Vec<usize>, Vec<usize>) =
            left_out.iter().partition(|axis| sizes[**axis] < ROUNDING * most);
        let unit = self.unit;
        if !zero.is_empty() {
            let size = most_of(&zero, sizes);
            let rounding = match size > 0.0 {
                true => format!(" within rounding (below {size:.0e} {unit})"),
                false => String::new(),
            };
            self.notes.push(format!("along {} it is zero{rounding}", along(&zero)));
        }
        if !small.is_empty() {
            let axes = along(&small);
            let size = most_of(&small, sizes);
            self.notes.push(format!("along {axes} it is below {size:.1e} {unit} and not drawn"));
        }
    }
}

/// The largest size of some values.
fn largest(series: &[Series]) -> f64 {
    let points = series.iter().flat_map(|one| &one.points);
    points.map(|p| p.1.abs()).filter(|value| value.is_finite()).fold(0.0, f64::max)
}

fn most_of(axes: &[usize], sizes: &[f64]) -> f64 {
    axes.iter().map(|axis| sizes[*axis]).fold(0.0, f64::max)
}

fn along(axes: &[usize]) -> String {
    axes.iter().map(|axis| NAMES[*axis]).collect::<Vec<_>>().join(" and ")
}

/// To two digits.
fn significant(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// The range of a vertical axis that the peaks of single steps would widen to many times what it is
/// without them.
fn without_peaks(series: &[Series]) -> Option<[f64; 2]> {
    let mut values: Vec<f64> =
        series.iter().flat_map(|one| &one.points).map(|p| p.1).filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let low = quantile(&values, PEAKS);
    let high = quantile(&values, 1.0 - PEAKS);
    let first = values.first()?;
    let last = values.last()?;
    let pad = 0.1 * (high - low);
    (pad > 0.0 && last - first > WIDER * (high - low)).then_some([low - pad, high + pad])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::SeriesStyle;

    #[test]
    fn force_figure_omits_rounding_and_clips_peaks() {
        let line = |size: f64| Series {
            label: "a".into(),
            points: (0..1000).map(|k| (f64::from(k), size * f64::from(k % 10))).collect(),
            style: SeriesStyle::Line,
        };
        let chart = |plots: Vec<Vec<Series>>| {
            let vector = Vector {
                what: "force",
                unit: "N/m",
                title: "t".into(),
                notes: Vec::new(),
                cut_peaks: true,
            };
            vector.chart(plots).unwrap()
        };
        let two = chart(vec![vec![line(1e-10)], vec![line(2.0)]]);
        assert_eq!(two.panels.len(), 1);
        assert_eq!(two.panels[0].0.y_label, "force along y (N/m)");
        assert_eq!(two.panels[0].0.note, "along x it is zero within rounding (below 9e-10 N/m)");
        assert_eq!(two.panels[0].0.range_y, None);
        let mut peaked = line(1.0);
        peaked.points[500].1 = 1e3;
        let one = chart(vec![vec![peaked], vec![line(2.0)]]);
        let [low, high] = one.panels[0].0.range_y.unwrap();
        assert!(low < 0.0 && (9.0..12.0).contains(&high), "{low} to {high}");
        assert_eq!(one.panels[0].0.note, "along x peaks of up to 1000 N/m are cut off");
        assert_eq!((one.panels.len(), one.panels[1].1[0].label.as_str()), (2, ""));
    }
}
