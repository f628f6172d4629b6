//! Columns of tables as lines over another column: a panel a quantity, a line a group of rows.
//!
//! ```text
//!   force along x (N) |  -- run a, stone     groups: the rows of a body, of the bodies of a kind,
//!                     |  -- run b, stone             of a probe, of a run
//!                     +------------------
//!   force along y (N) |  (the same lines)    panels: a column each, or several that are one
//!                     |                              quantity
//!                     +------------------
//!                            time (s)
//! ```

use super::table::{Table, quantile};
use crate::figure::{Axes, Chart, Series, SeriesStyle};
use mics_run::words::rounded;
use std::collections::HashSet;

/// A panel whose largest value is below this part of the largest one of its family is not drawn.
const SHOWN: f64 = 1e-3;
/// A quantity below this part of the largest one of its family is zero within rounding and the
/// limit of the pressure.
const ROUNDING: f64 = 1e-5;
/// Part of the values at either end that a vertical axis leaves out, where they would widen it by
/// [`WIDER`]: the peaks of single steps in which bodies collide.
const PEAKS: f64 = 0.02;
/// Widening of a vertical axis above which its peaks are cut off.
const WIDER: f64 = 3.0;

/// Rows that belong together: those of a body, of the bodies of a kind, of a probe, of a run.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// Its name in the legend; empty for none.
    pub label: String,
    /// Its rows.
    pub table: Table,
    /// Lower and upper edge of a spread of which the rows are the middle.
    pub edges: Option<[Table; 2]>,
}

impl Group {
    /// A group of rows without a spread.
    pub fn new(label: impl Into<String>, table: Table) -> Group {
        Group { label: label.into(), table, edges: None }
    }

    /// A line of its rows and the area of its spread.
    fn series(&self, over: &str, line: &Line) -> Vec<Series> {
        let points = |table: &Table| -> Vec<(f64, f64)> {
            let x = table.column(over).iter().copied();
            x.zip(table.column(&line.column).iter().copied()).collect()
        };
        let label = joined(&[&self.label, &line.label]);
        let mut all = vec![Series { label, points: points(&self.table), style: line.style }];
        if let Some([low, high]) = &self.edges {
            let mut outline = points(high);
            outline.extend(points(low).into_iter().rev());
            let style = SeriesStyle::Spread;
            all.push(Series { label: String::new(), points: outline, style });
        }
        all.retain(|one| !one.points.is_empty());
        all
    }
}

/// Words with commas between them, without the empty ones.
pub fn joined(words: &[&str]) -> String {
    joined_by(", ", words)
}

fn joined_by(between: &str, words: &[&str]) -> String {
    words.iter().filter(|word| !word.is_empty()).copied().collect::<Vec<_>>().join(between)
}

/// A line of a panel: a column of each group.
#[derive(Clone, Debug)]
pub struct Line {
    /// The name of the column.
    pub column: String,
    /// What tells it apart from the other lines of its panel.
    pub label: String,
    /// Its style.
    pub style: SeriesStyle,
}

/// A quantity, with axes of its own.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// The column of the horizontal axis, and its label.
    pub over: String,
    #[allow(missing_docs)]
    pub over_label: String,
    /// The quantity, such as `force along x`, and its unit; empty for none.
    pub quantity: String,
    #[allow(missing_docs)]
    pub unit: String,
    /// The vector or the like of which it is a part: parts that are next to nothing beside the
    /// others are not drawn. Empty: it is drawn in any case.
    pub family: String,
    /// Its lines.
    pub lines: Vec<Line>,
    /// Whether the axis of the values is logarithmic.
    pub log: bool,
    /// Values that dashed lines mark.
    pub limits: Vec<f64>,
}

impl Panel {
    /// A panel of one column over another one.
    pub fn of(column: &str, quantity: &str, unit: &str, over: &str, over_label: &str) -> Panel {
        Panel {
            over: over.to_owned(),
            over_label: over_label.to_owned(),
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            ..Panel::default()
        }
        .with(column, "", SeriesStyle::Line)
    }

    /// The panel with one more line.
    pub fn with(mut self, column: &str, label: &str, style: SeriesStyle) -> Panel {
        self.lines.push(Line { column: column.to_owned(), label: label.to_owned(), style });
        self
    }

    /// The panel as a part of a family.
    pub fn in_family(self, family: &str) -> Panel {
        Panel { family: family.to_owned(), ..self }
    }

    /// The quantity with its unit.
    fn label(&self) -> String {
        match (self.quantity.as_str(), self.unit.as_str()) {
            (quantity, "") => quantity.to_owned(),
            ("", unit) => unit.to_owned(),
            (quantity, unit) => format!("{quantity} ({unit})"),
        }
    }

    fn series(&self, groups: &[Group]) -> Vec<Series> {
        let of_group =
            |group| self.lines.iter().flat_map(move |line| Group::series(group, &self.over, line));
        groups.iter().flat_map(of_group).collect()
    }

    /// Dashed lines at its limits, as far as its lines go.
    fn marks(&self, series: &[Series]) -> Vec<Series> {
        let places = || series.iter().flat_map(|one| &one.points).map(|point| point.0);
        let first = places().fold(f64::INFINITY, f64::min);
        let last = places().fold(f64::NEG_INFINITY, f64::max);
        let mark = |limit: &f64| Series {
            label: String::new(),
            points: vec![(first, *limit), (last, *limit)],
            style: SeriesStyle::Dashed,
        };
        self.limits.iter().map(mark).collect()
    }
}

/// Groups of rows, and the panels that show them.
#[derive(Clone, Debug, Default)]
pub struct Plot {
    /// The rows.
    pub groups: Vec<Group>,
    /// The panels.
    pub panels: Vec<Panel>,
    /// Title above the figure.
    pub title: String,
    /// Notes under it.
    pub notes: Vec<String>,
    /// Whether the peaks of single steps are cut off.
    pub cut_peaks: bool,
    /// Whether the panels stand beside each other.
    pub beside: bool,
    /// Whether the values lie along the horizontal axis, as in a profile over the height.
    pub upright: bool,
    /// Whether the horizontal axis counts: its ticks are whole numbers.
    pub counts: bool,
}

impl Plot {
    /// The chart, with notes that say what is left out; none where there is nothing to show.
    pub fn chart(mut self) -> Option<Chart> {
        let drawn: Vec<Vec<Series>> =
            self.panels.iter().map(|panel| panel.series(&self.groups)).collect();
        let sizes: Vec<f64> = drawn.iter().map(|series| largest(series)).collect();
        let mut panels = Vec::new();
        for (k, series) in drawn.into_iter().enumerate() {
            let panel = &self.panels[k];
            let of_family = (0..sizes.len()).filter(|j| self.panels[*j].family == panel.family);
            let most = of_family.map(|j| sizes[j]).fold(0.0, f64::max);
            let matters = sizes[k] > SHOWN * most || most == 0.0 && k == 0;
            if !panel.family.is_empty() && !matters {
                self.notes.extend((most > 0.0).then(|| left_out(panel, sizes[k], most)));
                continue;
            }
            let range = without_peaks(&series).filter(|_| self.cut_peaks);
            if range.is_some() {
                let most = rounded(significant(sizes[k]));
                let unit = &panel.unit;
                let note = format!("peaks of up to {most} {unit} are cut off");
                self.notes.push(joined_by(": ", &[&panel.quantity, &note]));
            }
            panels.push(self.panel(panel, series, range));
        }
        name_once(&mut panels, self.beside);
        if let Some((first, _)) = panels.first_mut() {
            first.title = self.title;
            first.note = self.notes.join("; ");
        }
        Some(Chart { panels, beside: self.beside }).filter(Chart::shows)
    }

    /// Axes and series of a panel with such a range of its values.
    fn panel(
        &self,
        panel: &Panel,
        mut series: Vec<Series>,
        range_y: Option<[f64; 2]>,
    ) -> (Axes, Vec<Series>) {
        series.extend(panel.marks(&series));
        let mut axes = Axes {
            x_label: panel.over_label.clone(),
            y_label: panel.label(),
            log_y: panel.log,
            whole_x: self.counts,
            range_y,
            ..Axes::default()
        };
        if self.upright {
            std::mem::swap(&mut axes.x_label, &mut axes.y_label);
            let points = series.iter_mut().flat_map(|one| &mut one.points);
            points.for_each(|point| *point = (point.1, point.0));
        }
        (axes, series)
    }
}

/// Leaves each label in one legend: that of the first panel or, of panels beside each other, that
/// of the last one, which has room beside it.
fn name_once(panels: &mut [(Axes, Vec<Series>)], beside: bool) {
    let mut named = HashSet::new();
    let count = panels.len();
    for k in 0..count {
        let at = if beside { count - 1 - k } else { k };
        let before = named.clone();
        for one in &mut panels[at].1 {
            named.insert(one.label.clone());
            if before.contains(&one.label) {
                one.label.clear();
            }
        }
    }
}

/// A note on a panel that is not drawn, of a largest value beside the largest of its family.
fn left_out(panel: &Panel, size: f64, most: f64) -> String {
    let Panel { quantity, unit, .. } = panel;
    if size >= ROUNDING * most {
        return format!("{quantity} is below {size:.1e} {unit} and not drawn");
    }
    match size > 0.0 {
        true => format!("{quantity} is zero within rounding (below {size:.0e} {unit})"),
        false => format!("{quantity} is zero"),
    }
}

/// The largest size of some values.
fn largest(series: &[Series]) -> f64 {
    let points = series.iter().flat_map(|one| &one.points);
    points.map(|p| p.1.abs()).filter(|value| value.is_finite()).fold(0.0, f64::max)
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

/// The mean of the groups of each label, as of several runs, at the places of the first over which
/// all go, with the least and the largest of them as its spread.
pub fn averaged(groups: &[Group], over: &str) -> Vec<Group> {
    let mut labels: Vec<&str> = Vec::new();
    let lines = || groups.iter().filter(|group| group.table.column(over).len() > 1);
    for group in lines() {
        if !labels.contains(&group.label.as_str()) {
            labels.push(&group.label);
        }
    }
    let of = |label: &str| {
        let same: Vec<&Table> =
            lines().filter(|group| group.label == label).map(|group| &group.table).collect();
        let names: Vec<&str> = same[0].names().iter().map(String::as_str).collect();
        let mut mean = Table::new(&names);
        let mut low = mean.clone();
        let mut high = mean.clone();
        for x in same[0].column(over) {
            let values = |name: &&str| -> Option<Vec<f64>> {
                same.iter().map(|table| value_at(table, over, name, *x)).collect()
            };
            let Some(row) = names.iter().map(values).collect::<Option<Vec<_>>>() else { continue };
            let of = |sum: &dyn Fn(&[f64]) -> f64| -> Vec<f64> {
                row.iter().map(|values| sum(values)).collect()
            };
            mean.push(&of(&|all| all.iter().sum::<f64>() / all.len() as f64));
            low.push(&of(&|all| all.iter().copied().fold(f64::INFINITY, f64::min)));
            high.push(&of(&|all| all.iter().copied().fold(f64::NEG_INFINITY, f64::max)));
        }
        let label = joined(&[label, &format!("mean of {} runs", same.len())]);
        Group { label, table: mean, edges: Some([low, high]) }
    };
    labels.into_iter().map(of).collect()
}

/// The value of a column where another one has a value, linear between rows; none beyond its ends.
fn value_at(table: &Table, over: &str, name: &str, x: f64) -> Option<f64> {
    let places = table.column(over);
    let values = table.column(name);
    let after = places.partition_point(|place| *place < x);
    let last = *places.get(after)?;
    if last == x {
        return values.get(after).copied();
    }
    let before = after.checked_sub(1)?;
    let first = places[before];
    let y = values.get(before)?;
    Some(y + (x - first) / (last - first) * (values.get(after)? - y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_of_runs_is_over_the_times_of_all_with_their_spread() {
        let group = |points: &[(f64, f64)]| {
            let mut table = Table::new(&["time", "v"]);
            points.iter().for_each(|(x, y)| table.push(&[*x, *y]));
            Group::new("a", table)
        };
        let runs = [
            group(&[(0.0, 0.0), (1.0, 2.0), (2.0, 4.0), (3.0, 6.0)]),
            group(&[(0.0, 4.0), (4.0, 4.0)]),
            group(&[(0.0, 8.0), (2.0, 4.0)]),
        ];
        let [mean] = &averaged(&runs, "time")[..] else { panic!() };
        assert_eq!(mean.label, "a, mean of 3 runs");
        assert_eq!(mean.table.column("time"), [0.0, 1.0, 2.0]);
        assert_eq!(mean.table.column("v"), [4.0, 4.0, 4.0]);
        let [low, high] = mean.edges.as_ref().unwrap();
        assert_eq!(
            (low.column("v"), high.column("v")),
            (&[0.0, 2.0, 4.0][..], &[8.0, 6.0, 4.0][..])
        );
    }

    #[test]
    fn plot_omits_rounding_and_clips_peaks() {
        let chart = |x: [f64; 2], y: f64, peak: f64| {
            let mut table = Table::new(&["time", "x", "y"]);
            for k in 0..1000 {
                let wave = f64::from(k % 10);
                let peak = if k == 500 { peak } else { 0.0 };
                table.push(&[f64::from(k), x[0] * wave + x[1] + peak, y * wave]);
            }
            let panel = |name: &str| {
                let quantity = format!("force along {name}");
                Panel::of(name, &quantity, "N/m", "time", "time (s)").in_family("force")
            };
            let plot = Plot {
                groups: vec![Group::new("a", table)],
                panels: vec![panel("x"), panel("y")],
                title: "t".into(),
                cut_peaks: true,
                ..Plot::default()
            };
            plot.chart().unwrap()
        };
        let two = chart([1e-10, 0.0], 2.0, 0.0);
        assert_eq!(two.panels.len(), 1);
        let (axes, _) = &two.panels[0];
        assert_eq!(axes.y_label, "force along y (N/m)");
        assert_eq!(axes.note, "force along x is zero within rounding (below 9e-10 N/m)");
        assert_eq!(axes.range_y, None);
        let peaked = chart([1.0, 0.0], 2.0, 1e3);
        let [low, high] = peaked.panels[0].0.range_y.unwrap();
        assert!(low < 0.0 && (9.0..12.0).contains(&high), "{low} to {high}");
        assert_eq!(peaked.panels[0].0.note, "force along x: peaks of up to 1000 N/m are cut off");
        assert_eq!((peaked.panels.len(), peaked.panels[1].1[0].label.as_str()), (2, ""));
    }
}
