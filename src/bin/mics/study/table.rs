//! The table of a study: a row a run, medians over its repeats, as CSV and as Markdown.

use super::child::Outcome;
use super::columns::COLUMNS;
use super::plan::Plan;
use mics_plot::study::{self, Measured, Target};

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// What its columns say.
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
    /// Every column of [`COLUMNS`], as text.
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
    let (low, high) =
        (values.get(values.len().checked_sub(1)? / 2)?, values.get(values.len() / 2)?);
    Some(0.5 * (low + high))
}

/// A number to four digits.
pub fn short(value: f64) -> String {
    let order = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if (-3..6).contains(&order) {
        format!("{value:.*}", (3 - order).max(0) as usize)
    } else {
        format!("{value:.3e}")
    }
}

/// An error against a target: in percent, or as the difference that it is.
fn show(target: &Target, error: f64) -> String {
    if target.is_relative() { format!("{:+.2} %", 100.0 * error) } else { short(error) }
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

/// The rows of a plan whose runs have come to these outcomes, repeat by repeat.
pub fn rows(plan: &Plan, outcomes: &[Vec<Outcome>]) -> Vec<Row> {
    let measures = plan.measures();
    let outcomes = outcomes.iter().take(plan.runs.len()).enumerate();
    outcomes.map(|(index, outcomes)| Row::of(plan, index, outcomes, &measures)).collect()
}

/// The repeats of a run that are done.
struct Repeats<'a>(Vec<&'a Outcome>);

impl Repeats<'_> {
    /// What the summaries of all have of a number.
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
    /// That of the run `index` of a plan.
    fn of(plan: &Plan, index: usize, outcomes: &[Outcome], measures: &[String]) -> Row {
        let run = &plan.runs[index];
        let done = Repeats(outcomes.iter().filter(|outcome| outcome.status == "done").collect());
        let broken = outcomes.iter().find(|outcome| outcome.status != "done");
        let measured = measures.iter().map(|name| {
            let values = done.0.iter().filter_map(|o| o.summary["measures"][name].as_f64());
            let value = median(values.collect());
            let error = plan.target(name).and_then(|target| target.error(index, value?));
            Measured { name: name.clone(), value, error }
        });
        let (cpu, cells) = (done.median("cpu_seconds"), done.median("cells"));
        let steps = done.median("steps").map(|steps| steps.max(1.0));
        let per_cell_step =
            median(done.0.iter().filter_map(|o| per_cell_step(&o.summary)).collect());
        let otherwise = if done.0.is_empty() { "waiting" } else { "done" };
        let status = broken.map_or(otherwise, |outcome| outcome.status);
        // Of all ranks, start and end included: what a busy machine does not change.
        let cpu_per_cell_step =
            cpu.zip(cells.zip(steps)).map(|(cpu, (cells, steps))| 1e6 * cpu / (cells * steps));
        let krylov = done.median("krylov_iterations").zip(steps);
        let texts = COLUMNS.map(|column| match column {
            "ranks" => run.ranks.to_string(),
            "status" => status.to_owned(),
            "repeats" => done.0.len().to_string(),
            "cpu_spread" => text(done.cpu_spread()),
            "us_per_cell_step" => text(per_cell_step),
            "cpu_us_per_cell_step" => text(cpu_per_cell_step),
            "krylov_per_step" => text(krylov.map(|(krylov, steps)| krylov / steps)),
            "commit" => outcomes.last().map_or(String::new(), |outcome| outcome.commit.clone()),
            "set" => run.set.join("; "),
            "petsc" => run.petsc.join(" "),
            "folder" => format!("runs/{}", run.id),
            "message" => broken.map_or(String::new(), |outcome| outcome.message.clone()),
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
            texts: texts.to_vec(),
        }
    }

    /// What figures show of it.
    pub fn shown(&self) -> study::Row {
        study::Row {
            labels: self.labels.clone(),
            ranks: self.ranks,
            measured: self.measured.clone(),
            cpu: self.cpu,
            cells: self.cells,
            per_cell_step: self.per_cell_step,
        }
    }

    /// A column of [`COLUMNS`] as text; empty where the run has none.
    fn text(&self, column: &str) -> &str {
        COLUMNS.iter().position(|name| *name == column).map_or("", |at| &self.texts[at])
    }

    fn number(&self, column: &str) -> Option<f64> {
        self.text(column).parse().ok()
    }

    /// What the run cost and how it ended, in short.
    fn costs(&self) -> Vec<String> {
        let times = [
            "cpu_seconds",
            "wall_seconds",
            "us_per_cell_step",
            "cpu_us_per_cell_step",
            "krylov_per_step",
        ];
        let mut cells: Vec<String> =
            times.map(|column| self.number(column).map_or(String::new(), short)).to_vec();
        cells.push(self.text("steps").to_owned());
        let bytes = self.number("peak_memory_bytes");
        cells.push(bytes.map_or(String::new(), |bytes| format!("{:.0}", bytes / 1e6)));
        let why = self.text("message");
        let brief: String = why.chars().take(80).collect();
        let dots = if brief.len() < why.len() { " ..." } else { "" };
        cells.push(match why {
            "" => self.status.into(),
            _ => format!("{}: {brief}{dots}", self.status),
        });
        cells
    }
}

/// `study.csv`: labels, then measures with their errors, then the rest.
pub fn csv(plan: &Plan, rows: &[Row]) -> Vec<u8> {
    let has_reference = |name: &String| plan.target(name).is_some();
    let heads = plan.measures().into_iter().flat_map(|name| {
        let error = has_reference(&name).then(|| format!("{name}_error"));
        [Some(name), error].into_iter().flatten()
    });
    let head: Vec<String> =
        plan.names.iter().cloned().chain(heads).chain(COLUMNS.map(str::to_owned)).collect();
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

/// The same in short, as a Markdown table.
pub fn markdown(plan: &Plan, rows: &[Row]) -> String {
    let several_ranks = rows.iter().any(|row| row.ranks != rows[0].ranks);
    let mut head = plan.names.clone();
    head.extend(several_ranks.then(|| "ranks".to_owned()));
    for name in plan.measures() {
        let compared = plan.target(&name).is_some();
        head.push(name);
        head.extend(compared.then(|| "error".to_owned()));
    }
    head.extend(
        [
            "CPU s",
            "wall s",
            "us per cell and step",
            "CPU us",
            "Krylov a step",
            "steps",
            "MB",
            "status",
        ]
        .map(str::to_owned),
    );
    let mut lines = heading(&head);
    for row in rows {
        let mut cells = row.labels.clone();
        cells.extend(several_ranks.then(|| row.ranks.to_string()));
        for measured in &row.measured {
            cells.push(measured.value.map_or(String::new(), short));
            if let Some(target) = plan.target(&measured.name) {
                cells.push(measured.error.map_or(String::new(), |error| show(target, error)));
            }
        }
        cells.extend(row.costs());
        lines += &line(&cells);
    }
    lines
}

/// A line of a Markdown table.
fn line(cells: &[String]) -> String {
    let cells: Vec<_> =
        cells.iter().map(|cell| cell.replace('|', "\\|").replace('\n', " ")).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// The head of a Markdown table.
fn heading(head: &[String]) -> String {
    line(head) + &"|---".repeat(head.len()) + "|\n"
}

/// The range and mean of every measure over the runs that differ in the columns `over` only, with
/// the worst and the mean error where there is a reference: a Markdown table.
pub fn spread(plan: &Plan, rows: &[Row], over: &[String]) -> String {
    let several_ranks = rows.iter().any(|row| row.ranks != rows[0].ranks)
        && !over.iter().any(|name| name == "ranks");
    let kept: Vec<usize> =
        (0..plan.names.len()).filter(|k| !over.contains(&plan.names[*k])).collect();
    let measures = plan.measures();
    let mut head: Vec<String> = kept.iter().map(|k| plan.names[*k].clone()).collect();
    head.extend(several_ranks.then(|| "ranks".to_owned()));
    head.push("runs".into());
    for name in &measures {
        head.extend([name.clone(), "mean".into()]);
        head.extend(
            plan.target(name).iter().flat_map(|_| ["worst error".into(), "mean error".into()]),
        );
    }
    let mut text = heading(&head);
    let mut groups: Vec<(Vec<String>, Vec<&Row>)> = Vec::new();
    for row in rows {
        let ranks = several_ranks.then(|| row.ranks.to_string());
        let key: Vec<String> = kept.iter().map(|k| row.labels[*k].clone()).chain(ranks).collect();
        match groups.iter_mut().find(|(other, _)| *other == key) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((key, vec![row])),
        }
    }
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    for (mut cells, rows) in groups {
        cells.push(rows.len().to_string());
        for (k, name) in measures.iter().enumerate() {
            let values: Vec<f64> = rows.iter().filter_map(|row| row.measured[k].value).collect();
            let errors: Vec<f64> = rows.iter().filter_map(|row| row.measured[k].error).collect();
            let (low, high) = values
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
            let shown = |text: String, any: bool| if any { text } else { String::new() };
            cells.push(shown(format!("{} ... {}", short(low), short(high)), !values.is_empty()));
            cells.push(shown(short(mean(&values)), !values.is_empty()));
            if let Some(target) = plan.target(name) {
                let worst = errors
                    .iter()
                    .copied()
                    .fold(0.0f64, |w, e| if e.abs() > w.abs() { e } else { w });
                cells.extend(
                    [worst, mean(&errors)]
                        .map(|error| shown(show(target, error), !errors.is_empty())),
                );
            }
        }
        text += &line(&cells);
    }
    text
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

    #[test]
    fn study_numbers_have_four_digits() {
        assert_eq!(
            [0.0, 12.345678, 0.0123456, 123456.7, 2e7].map(short),
            ["0.000", "12.35", "0.01235", "123457", "2.000e7"]
        );
    }
}
