//! The table of a study: a row a run, medians over its repeats, as `study.csv` has it.

use super::child::Outcome;
use super::columns::{NUMBERS, TEXTS, error_of, number_columns};
use super::plan::Plan;
use super::reference::Compared;
use mics_plot::study::{Row as Numbers, Target};
use std::collections::BTreeMap;

/// The table of a study.
pub struct Table {
    /// Names of the label columns.
    pub names: Vec<String>,
    /// Names of the measures, in their order.
    pub measures: Vec<String>,
    /// The unit of each measure that has one.
    pub units: BTreeMap<String, String>,
    /// References of measures.
    pub targets: BTreeMap<String, Target>,
    /// A row a run.
    pub rows: Vec<Row>,
}

/// A row of the table.
pub struct Row {
    /// Labels, and numbers by column.
    pub run: Numbers,
    /// `done`, or what kept a repeat from it, or `waiting`.
    pub status: &'static str,
    /// Why it is not done, or what is to be said of one that is.
    pub message: String,
    /// The other texts of [`TEXTS`].
    texts: [String; 3],
}

/// The median; `None` of nothing.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let low = values.get(values.len().checked_sub(1)? / 2)?;
    let high = values.get(values.len() / 2)?;
    Some(0.5 * (low + high))
}

/// Wall-clock time of a cell and step (us): the stages' of the step and of its logs, without
/// snapshots and start.
fn per_cell_step(summary: &serde_json::Value) -> Option<f64> {
    let stages = summary["stages_ns_per_cell_step"].as_object()?.iter();
    let stages = stages.filter(|(name, _)| *name != "fields");
    Some(1e-3 * stages.filter_map(|(_, ns)| ns.as_f64()).sum::<f64>())
}

/// The repeats of a run that are done.
struct Repeats<'a>(Vec<&'a Outcome>);

impl Repeats<'_> {
    fn median(&self, of: impl Fn(&serde_json::Value) -> Option<f64>) -> Option<f64> {
        median(self.0.iter().filter_map(|outcome| of(&outcome.summary)).collect())
    }

    /// A column of numbers.
    fn number(&self, column: &str) -> Option<f64> {
        let of = |name: &str| self.median(|summary| summary[name].as_f64());
        let part = |whole: &str, parts: Option<f64>| {
            let parts = parts.filter(|parts| *parts > 0.0)?;
            Some(of(whole)? / parts)
        };
        let steps = of("steps").map(|steps| steps.max(1.0));
        let cell_steps = || Some(1e-6 * of("cells")? * steps?);
        match column {
            "repeats" => Some(self.0.len() as f64),
            "us_per_cell_step" => self.median(per_cell_step),
            "cpu_us_per_cell_step" => part("cpu_seconds", cell_steps()),
            "pressure_cpu_us_per_cell_step" => part("pressure_cpu_seconds", cell_steps()),
            "krylov_per_step" => part("krylov_iterations", steps),
            // Each iteration of C-HSMAC is a solve; a run at rest has none.
            "krylov_per_solve" => part("krylov_iterations", of("outer_iterations")),
            "divergence_over_limit" => part("divergence_max", of("divergence_limit")),
            column => of(column),
        }
    }
}

impl Row {
    /// The row of the run `index` of a plan, without errors.
    fn of(plan: &Plan, index: usize, outcomes: &[Outcome], measures: &[String]) -> Row {
        let run = &plan.runs[index];
        let done = Repeats(outcomes.iter().filter(|outcome| outcome.status == "done").collect());
        let broken = outcomes.iter().find(|outcome| outcome.status != "done");
        let remarked = outcomes.iter().rfind(|outcome| !outcome.message.is_empty());
        let mut numbers = BTreeMap::new();
        for (column, _) in NUMBERS {
            numbers.extend(done.number(column).map(|number| (column.to_owned(), number)));
        }
        for name in measures {
            let value = done.median(|summary| summary["measures"][name].as_f64());
            numbers.extend(value.map(|value| (name.clone(), value)));
        }
        let commit = outcomes.last().map_or(String::new(), |outcome| outcome.commit.clone());
        let otherwise = if done.0.is_empty() { "waiting" } else { "done" };
        Row {
            run: Numbers { labels: run.labels.clone(), numbers },
            status: broken.map_or(otherwise, |outcome| outcome.status),
            message: remarked.map_or(String::new(), |outcome| outcome.message.clone()),
            texts: [commit, run.set.join("; "), format!("runs/{}", run.id)],
        }
    }
}

impl Table {
    /// The table of a plan whose runs have come to these outcomes, repeat by repeat.
    pub fn new(plan: &Plan, outcomes: &[Vec<Outcome>]) -> Table {
        let measures = plan.measures();
        let rows = outcomes.iter().enumerate();
        let mut rows: Vec<Row> =
            rows.map(|(index, outcomes)| Row::of(plan, index, outcomes, &measures)).collect();
        let mut targets = BTreeMap::new();
        for (measure, compared) in &plan.references {
            let value = |run: &Option<usize>| rows[(*run)?].run.numbers.get(measure).copied();
            let target = match compared {
                Compared::Values(values) => Target { values: values.clone(), of_runs: false },
                Compared::Runs(runs) => {
                    Target { values: runs.iter().map(value).collect(), of_runs: true }
                }
            };
            for (index, row) in rows.iter_mut().enumerate() {
                let value = row.run.numbers.get(measure);
                let error = value.and_then(|value| target.error(index, *value));
                row.run.numbers.extend(error.map(|error| (error_of(measure), error)));
            }
            targets.insert(measure.clone(), target);
        }
        let mut units = BTreeMap::new();
        let summaries = outcomes.iter().flatten().map(|outcome| &outcome.summary["units"]);
        for (name, unit) in summaries.filter_map(serde_json::Value::as_object).flatten() {
            units.extend(unit.as_str().map(|unit| (name.clone(), unit.to_owned())));
        }
        Table { names: plan.names.clone(), measures, units, targets, rows }
    }

    /// `study.csv`: labels, then measures with their errors, then the rest.
    pub fn csv(&self) -> Vec<u8> {
        let measured = self.measures.iter().flat_map(|name| {
            let error = self.targets.contains_key(name).then(|| error_of(name));
            [Some(name.clone()), error].into_iter().flatten()
        });
        let numbers: Vec<String> =
            measured.chain(number_columns().into_iter().map(str::to_owned)).collect();
        let texts = TEXTS.map(str::to_owned);
        let head = [&self.names[..], &numbers, &texts].concat();
        let record = |row: &Row| {
            let cell = |name: &String| match row.run.numbers.get(name) {
                Some(value) if value.fract() == 0.0 => format!("{value}"),
                Some(value) => format!("{value:?}"),
                None => String::new(),
            };
            let numbers: Vec<String> = numbers.iter().map(cell).collect();
            let end = [row.status.to_owned(), row.message.clone()];
            [&row.run.labels[..], &numbers, &end, &row.texts].concat()
        };
        let mut writer = csv::Writer::from_writer(Vec::new());
        // Writing to memory cannot fail, and all records have the head's length.
        for record in [head].into_iter().chain(self.rows.iter().map(record)) {
            let _ = writer.write_record(&record);
        }
        writer.into_inner().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_of_even_count() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 9.0, 2.0]), Some(3.0));
    }
}
