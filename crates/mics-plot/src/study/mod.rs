//! The figures of a study: each quantity over what is varied, and the error of each measure over
//! CPU seconds.

mod groups;

use crate::figure::{Axes, Series, SeriesStyle, curves};
use groups::Group;
use mics_run::Result;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Ratio of the greatest to the least value from which on an axis is logarithmic.
const WIDE: f64 = 20.0;

/// A study as its figures show it.
#[derive(Clone, Debug)]
pub struct Study {
    /// Title of the figures.
    pub title: String,
    /// The names of the columns that tell runs apart.
    pub names: Vec<String>,
    /// What is shown.
    pub quantities: Vec<Quantity>,
    /// The column that tells curves apart, if one is named.
    pub across: Option<String>,
    /// The columns that are summed up: runs that differ in them alone are one point.
    pub over: Vec<String>,
    /// The runs.
    pub rows: Vec<Row>,
}

/// A number that runs have: a measure, or a cost.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// Its name on axes, with its unit.
    pub label: String,
    /// References that it is compared with.
    pub target: Option<Target>,
}

/// A run, of several repeats their medians.
#[derive(Clone, Debug)]
pub struct Row {
    /// Labels in the columns that tell runs apart.
    pub labels: Vec<String>,
    /// Numbers by their names: quantities, their errors as `NAME_error`, `cpu_seconds`.
    pub numbers: BTreeMap<String, f64>,
}

/// References of a measure.
#[derive(Clone, Debug)]
pub struct Target {
    /// For each run, its reference, where there is one.
    pub values: Vec<Option<f64>>,
    /// Whether these are of other runs of the study.
    pub of_runs: bool,
}

impl Target {
    /// Whether errors are parts of the reference: where it is 0 in every run, they are differences.
    pub fn is_relative(&self) -> bool {
        self.values.iter().flatten().any(|exact| *exact != 0.0)
    }

    /// The error of a run's value; `None` where it has no reference, or one of 0 beside others that
    /// are not.
    pub fn error(&self, run: usize, value: f64) -> Option<f64> {
        match self.values[run]? {
            0.0 if self.is_relative() => None,
            0.0 => Some(value),
            exact => Some(value / exact - 1.0),
        }
    }
}

impl Study {
    /// Whether a column has different numbers, and nothing else but empty labels.
    fn is_numeric(&self, column: usize) -> bool {
        let labels = self.rows.iter().map(|row| row.labels[column].as_str());
        let mut numbers = labels.filter(|label| !label.is_empty()).map(str::parse::<f64>);
        let first = numbers.next();
        matches!(first, Some(Ok(_))) && numbers.all(|number| number.is_ok())
    }
}

/// Draws what there is to draw, each as `STEM.png` and `STEM.svg` in a folder: `value_NAME` of
/// every quantity, over a column of numbers, and `work_precision_NAME` of every measure with a
/// reference, of runs that are summed up the worst error.
///
/// # Errors
/// When a figure cannot be written.
pub fn draw(study: &Study, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    for group in Group::all(study) {
        let title = [std::slice::from_ref(&study.title), &group.title].concat().join(", ");
        let ending: String =
            group.title.iter().map(|label| format!("_{}", file_name(label))).collect();
        for quantity in &study.quantities {
            let figures = [value(study, &group, quantity), error(study, &group, quantity)];
            for (kind, axes, series) in figures.into_iter().flatten() {
                let stem = folder.join(format!("{kind}_{}{ending}", quantity.name));
                written.extend(curves(&Axes { title: title.clone(), ..axes }, &series, &stem)?);
            }
        }
    }
    Ok(written)
}

/// A label as a part of a file's name: letters and digits, and a `-` for what stands between.
fn file_name(label: &str) -> String {
    let words = label.split(|c: char| !c.is_ascii_alphanumeric() && c != '.');
    words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
}

/// Kind of a figure, its axes and its curves.
type Figure = (&'static str, Axes, Vec<Series>);

/// A quantity over the numbers that change along its curves, of runs that are summed up the mean,
/// beside its references.
fn value(study: &Study, group: &Group, quantity: &Quantity) -> Option<Figure> {
    let column = group.along.filter(|_| group.is_over_numbers(study))?;
    let x = |row: &Row| row.labels[column].parse::<f64>().ok();
    let place = |rows: &[&Row]| {
        let values = rows.iter().filter_map(|row| row.numbers.get(&quantity.name).copied());
        Some((x(rows.first()?)?, mean(values)?))
    };
    let mut series = group.series(study, &place);
    if series.is_empty() {
        return None;
    }
    let reference = |row: usize| {
        let exact = quantity.target.as_ref()?.values[row]?;
        Some((x(&study.rows[row])?, exact))
    };
    let mut exact: Vec<(f64, f64)> = group.rows().filter_map(reference).collect();
    exact.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    exact.dedup();
    let of_runs = quantity.target.as_ref().is_some_and(|target| target.of_runs);
    if exact.len() > 1 && !of_runs {
        let style = SeriesStyle::Dashed;
        series.push(Series { label: "reference".into(), points: exact, style });
    }
    let is_wide = |of: fn(&(f64, f64)) -> f64| {
        let numbers = || series.iter().flat_map(|one| &one.points).map(of);
        let least = numbers().fold(f64::INFINITY, f64::min);
        least > 0.0 && numbers().fold(0.0, f64::max) > WIDE * least
    };
    let axes = Axes {
        x_label: study.names[column].clone(),
        y_label: quantity.label.clone(),
        log_x: is_wide(|point| point.0),
        log_y: is_wide(|point| point.1),
        ..Axes::default()
    };
    Some(("value", axes, series))
}

/// The error of a measure that has a reference over CPU time; of runs that are summed up the worst.
fn error(study: &Study, group: &Group, quantity: &Quantity) -> Option<Figure> {
    let target = quantity.target.as_ref()?;
    let name = &quantity.name;
    let column = format!("{name}_error");
    let part = if target.is_relative() { 100.0 } else { 1.0 };
    let place = |rows: &[&Row]| {
        let compared = rows.iter().filter(|row| row.numbers.contains_key(&column));
        let cpu = mean(compared.clone().filter_map(|row| row.numbers.get("cpu_seconds").copied()))?;
        let worst = compared.map(|row| row.numbers[&column].abs()).fold(0.0, f64::max);
        // An error of nothing has no place on a logarithmic axis.
        (worst > 0.0).then_some((cpu, part * worst))
    };
    let series = group.series(study, &place);
    let kind = if study.over.is_empty() { "error" } else { "worst error" };
    let axes = Axes {
        x_label: "CPU time (s)".into(),
        y_label: match target.is_relative() {
            true => format!("{kind} of {name} (%)"),
            false => format!("{kind} of {}", quantity.label),
        },
        log_x: true,
        log_y: true,
        ..Axes::default()
    };
    (!series.is_empty()).then_some(("work_precision", axes, series))
}

/// The mean; none of nothing.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn study_error_relative_or_absolute_at_zero_reference() {
        let target = |values: &[Option<f64>]| Target { values: values.to_vec(), of_runs: false };
        let mixed = target(&[Some(2.0), None, Some(0.0), Some(-4.0)]);
        let errors = [0, 1, 2, 3].map(|run| mixed.error(run, 3.0));
        assert_eq!(errors, [Some(0.5), None, None, Some(-1.75)]);
        let nothing = target(&[Some(0.0), None]);
        assert!(!nothing.is_relative());
        assert_eq!([0, 1].map(|run| nothing.error(run, 3.0)), [Some(3.0), None]);
    }

    /// A study of grids, schemes and places whose CPU time is that of its grid times 1 or 2.
    fn places(over: &[String], schemes: &[&str]) -> Study {
        let mut rows = Vec::new();
        for scheme in schemes {
            for n in [8.0, 16.0] {
                for (place, error) in [("a", 0.01), ("b", -0.03)] {
                    let labels = vec![n.to_string(), scheme.to_string(), place.to_owned()];
                    let numbers =
                        [("cpu_seconds", n), ("drag", 1.0 + error), ("drag_error", error)];
                    let numbers = numbers.map(|(name, number)| (name.to_owned(), number)).into();
                    rows.push(Row { labels, numbers });
                }
            }
        }
        let target = Target { values: vec![Some(1.0); rows.len()], of_runs: false };
        let quantity = Quantity { name: "drag".into(), label: "drag".into(), target: Some(target) };
        Study {
            title: "places".into(),
            names: ["N", "scheme", "place"].map(str::to_owned).to_vec(),
            quantities: vec![quantity],
            across: None,
            over: over.to_vec(),
            rows,
        }
    }

    #[test]
    fn runs_summed_up_are_one_point_of_the_worst_error() {
        let study = places(&["place".into()], &["rk2", "rk3"]);
        let groups = Group::all(&study);
        assert_eq!((groups.len(), groups[0].along), (1, Some(0)));
        let (_, axes, series) = error(&study, &groups[0], &study.quantities[0]).unwrap();
        assert_eq!(axes.y_label, "worst error of drag (%)");
        let labels: Vec<&str> = series.iter().map(|one| one.label.as_str()).collect();
        assert_eq!(labels, ["rk2", "rk3"]);
        assert_eq!(series[0].points, [(8.0, 3.0), (16.0, 3.0)]);
        let (_, _, series) = value(&study, &groups[0], &study.quantities[0]).unwrap();
        assert!((series[0].points[0].1 - 0.99).abs() < 1e-12, "the mean of both places");
        assert_eq!(series[2].label, "reference");
    }

    #[test]
    fn too_many_curves_are_divided_among_figures() {
        let schemes: Vec<String> = (0..9).map(|k| format!("rk{k}")).collect();
        let schemes: Vec<&str> = schemes.iter().map(String::as_str).collect();
        let groups = Group::all(&places(&[], &schemes));
        assert_eq!(groups.len(), 9, "one for each scheme, with a curve for each place");
        assert_eq!(groups[1].title, ["rk1"]);
    }
}
