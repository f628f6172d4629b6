//! The table of a study: a row a run, medians over its repeats, as CSV.

use super::child::Outcome;
use super::columns;
use super::plan::Plan;
use super::reference::Compared;
use mics_plot::study::{self, Measured, Target};

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Labels in its columns.
    pub labels: Vec<String>,
    /// Number of ranks.
    pub ranks: usize,
    /// `done`, or what kept a repeat from it, or `waiting`.
    pub status: &'static str,
    /// The measures.
    pub measured: Vec<Measured>,
    /// CPU seconds of all ranks, start and end included.
    pub cpu: Option<f64>,
    /// Cells of the grid.
    pub cells: Option<f64>,
    /// Wall-clock time of a cell and step (us).
    pub per_cell_step: Option<f64>,
    /// Every column of [`columns::all`], as text.
    pub(super) texts: Vec<String>,
}

/// A number as a cell of `study.csv`: all its digits, and none where there is no number.
fn text(value: Option<f64>) -> String {
    match value {
        Some(value) if value.fract() == 0.0 => format!("{value}"),
        Some(value) => format!("{value:?}"),
        None => String::new(),
    }
}

/// The median; `None` of nothing.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let low = values.get(values.len().checked_sub(1)? / 2)?;
    let high = values.get(values.len() / 2)?;
    Some(0.5 * (low + high))
}

/// Wall-clock time of a cell and step (us): the stages' of the step and of its logs, without
/// snapshots and start.
fn per_cell_step(summary: &serde_json::Value) -> Option<f64> {
    let stages = summary["stages_ns_per_cell_step"].as_object()?;
    Some(
        1e-3 * stages
            .iter()
            .filter(|(name, _)| *name != "fields")
            .filter_map(|(_, ns)| ns.as_f64())
            .sum::<f64>(),
    )
}

/// The rows, and what their measures are compared with.
pub struct Table {
    /// A row a run.
    pub rows: Vec<Row>,
    /// The references.
    pub targets: Vec<Target>,
}

impl Table {
    /// The table of a plan whose runs have come to these outcomes, repeat by repeat.
    pub fn new(plan: &Plan, outcomes: &[Vec<Outcome>]) -> Table {
        let measures = plan.measures();
        let outcomes = outcomes.iter().take(plan.runs.len()).enumerate();
        let mut rows: Vec<Row> =
            outcomes.map(|(index, outcomes)| Row::of(plan, index, outcomes, &measures)).collect();
        let target = |compared: &Compared| {
            let value = |run: usize| rows.get(run)?.measure(&compared.measure)?.value;
            compared.target(value)
        };
        let targets: Vec<Target> = plan.references.iter().map(target).collect();
        for (index, row) in rows.iter_mut().enumerate() {
            for measured in &mut row.measured {
                let target = targets.iter().find(|target| target.measure == measured.name);
                measured.error = target
                    .zip(measured.value)
                    .and_then(|(target, value)| target.error(index, value));
            }
        }
        Table { rows, targets }
    }

    /// Reference of a measure, where it has one.
    pub fn target(&self, measure: &str) -> Option<&Target> {
        self.targets.iter().find(|target| target.measure == measure)
    }

    /// The plan as figures show it, with its measures and these columns.
    pub fn shown<'a>(
        &'a self,
        plan: &'a Plan,
        measures: &'a [String],
        costs: &'a [(String, &'a str)],
    ) -> study::Plan<'a> {
        let names = &plan.names;
        let others = &plan.others;
        study::Plan { names, measures, references: &self.targets, others, costs }
    }
}

/// The repeats of a run that are done.
struct Repeats<'a>(Vec<&'a Outcome>);

impl Repeats<'_> {
    /// Values of a number in the summaries of all.
    fn numbers(&self, name: &str) -> Vec<f64> {
        self.0.iter().filter_map(|o| o.summary[name].as_f64()).collect()
    }

    fn median(&self, name: &str) -> Option<f64> {
        median(self.numbers(name))
    }

    /// The range of the CPU time over its median.
    fn cpu_spread(&self) -> Option<f64> {
        let all = self.numbers("cpu_seconds");
        let low = all.iter().copied().fold(f64::INFINITY, f64::min);
        let high = all.iter().copied().fold(0.0, f64::max);
        Some((high - low) / median(all)?)
    }
}

impl Row {
    /// The row of the run `index` of a plan.
    fn of(plan: &Plan, index: usize, outcomes: &[Outcome], measures: &[String]) -> Row {
        let run = &plan.runs[index];
        let done = Repeats(outcomes.iter().filter(|outcome| outcome.status == "done").collect());
        let broken = outcomes.iter().find(|outcome| outcome.status != "done");
        let remarked = outcomes.iter().rfind(|outcome| !outcome.message.is_empty());
        let measured = measures.iter().map(|name| {
            let values = done.0.iter().filter_map(|o| o.summary["measures"][name].as_f64());
            let mut units = done.0.iter().filter_map(|o| o.summary["units"][name].as_str());
            let unit = units.next().unwrap_or_default().to_owned();
            Measured { name: name.clone(), unit, value: median(values.collect()), error: None }
        });
        let cpu = done.median("cpu_seconds");
        let cells = done.median("cells");
        let steps = done.median("steps").map(|steps| steps.max(1.0));
        let per_cell_step =
            median(done.0.iter().filter_map(|o| per_cell_step(&o.summary)).collect());
        let otherwise = if done.0.is_empty() { "waiting" } else { "done" };
        let status = broken.map_or(otherwise, |outcome| outcome.status);
        let per_step = |seconds: f64| cells.zip(steps).map(|(c, s)| 1e6 * seconds / (c * s));
        let pressure = done.median("pressure_cpu_seconds");
        let krylov = done.median("krylov_iterations");
        // Each iteration of C-HSMAC is a solve; a run at rest has none.
        let solves = done.median("outer_iterations").filter(|solves| *solves > 0.0);
        let part = |whole: Option<f64>, of: Option<f64>| whole.zip(of).map(|(a, b)| a / b);
        let texts = columns::all().into_iter().map(|column| match column {
            "ranks" => run.ranks.to_string(),
            "status" => status.to_owned(),
            "repeats" => done.0.len().to_string(),
            "cpu_spread" => text(done.cpu_spread()),
            "us_per_cell_step" => text(per_cell_step),
            // CPU time of all ranks, start and end included: a busy machine does not change it.
            "cpu_us_per_cell_step" => text(cpu.and_then(per_step)),
            "pressure_cpu_us_per_cell_step" => text(pressure.and_then(per_step)),
            "krylov_per_step" => text(part(krylov, steps)),
            "krylov_per_solve" => text(part(krylov, solves)),
            "divergence_over_limit" => {
                text(part(done.median("divergence_max"), done.median("divergence_limit")))
            }
            "commit" => outcomes.last().map_or(String::new(), |outcome| outcome.commit.clone()),
            "set" => run.set.join("; "),
            "petsc" => run.petsc.join(" "),
            "folder" => format!("runs/{}", run.id),
            "message" => remarked.map_or(String::new(), |outcome| outcome.message.clone()),
            name => text(done.median(name)),
        });
        Row {
            labels: run.labels.clone(),
            ranks: run.ranks,
            status,
            measured: measured.collect(),
            cpu,
            cells,
            per_cell_step,
            texts: texts.collect(),
        }
    }

    /// The row as figures show it, `costs` of its columns included.
    pub fn shown(&self, costs: &[String]) -> study::Row {
        study::Row {
            labels: self.labels.clone(),
            ranks: self.ranks,
            measured: self.measured.clone(),
            cpu: self.cpu,
            cells: self.cells,
            per_cell_step: self.per_cell_step,
            costs: costs.iter().map(|column| self.number(column)).collect(),
        }
    }

    /// A measure of it, by name.
    fn measure(&self, name: &str) -> Option<&Measured> {
        self.measured.iter().find(|measured| measured.name == name)
    }

    /// A column of [`columns::all`] as text; empty where the run has none.
    fn text(&self, column: &str) -> &str {
        let at = columns::all().into_iter().position(|name| name == column);
        at.map_or("", |at| &self.texts[at])
    }

    /// A column of [`columns::all`], a measure or its error as a number; none where it has none.
    pub fn number(&self, column: &str) -> Option<f64> {
        let error = || self.measure(column.strip_suffix("_error")?)?.error;
        let measured = || self.measure(column).map_or_else(error, |measured| measured.value);
        self.text(column).parse().ok().or_else(measured)
    }

    /// End of the run, in short.
    pub fn ending(&self) -> String {
        let why = self.text("message");
        let brief: String = why.chars().take(80).collect();
        let dots = if brief.len() < why.len() { " ..." } else { "" };
        match why {
            "" => self.status.into(),
            _ => format!("{}: {brief}{dots}", self.status),
        }
    }
}

/// `study.csv`: labels, then measures with their errors, then the rest.
pub fn csv(plan: &Plan, rows: &[Row]) -> Vec<u8> {
    let has_reference = |name: &String| plan.compares(name);
    let heads = plan.measures().into_iter().flat_map(|name| {
        let error = has_reference(&name).then(|| format!("{name}_error"));
        [Some(name), error].into_iter().flatten()
    });
    let head: Vec<String> = plan
        .names
        .iter()
        .cloned()
        .chain(heads)
        .chain(columns::all().into_iter().map(str::to_owned))
        .collect();
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
    let records = rows.iter().map(|row| {
        let measured = row.measured.iter().flat_map(|m| {
            let error = has_reference(&m.name).then(|| number(m.error));
            [Some(number(m.value)), error].into_iter().flatten()
        });
        row.labels
            .iter()
            .cloned()
            .chain(measured)
            .chain(row.texts.iter().cloned())
            .collect::<Vec<_>>()
    });
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail, and all records have the head's length.
    for record in [head].into_iter().chain(records) {
        let _ = writer.write_record(&record);
    }
    writer.into_inner().unwrap_or_default()
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
