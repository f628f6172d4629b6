//! The tables that people read: of all runs, or of a quantity across the labels of a column.

use super::columns::{error_of, head};
use super::file::Study;
use super::table::{Row, Table};
use mics_plot::study::Target;

/// The columns besides measures that a table has where the study file does not say.
const USUAL: [&str; 4] = ["cpu_seconds", "us_per_cell_step", "krylov_per_step", "steps"];

/// Runs that differ in nothing but the columns that are summed up, and what else they are known by.
struct Line<'a> {
    labels: Vec<&'a str>,
    runs: Vec<&'a Row>,
}

/// A number to four digits.
pub fn short(value: f64) -> String {
    let order = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    match order {
        _ if value.fract() == 0.0 && order < 9 => format!("{value}"),
        -3..6 => format!("{value:.*}", (3 - order).max(0) as usize),
        _ => format!("{value:.3e}"),
    }
}

/// An error against a target: in percent, as a part where it is that of another run, or as the
/// difference that it is.
fn error(target: &Target, error: f64) -> String {
    if target.of_runs {
        // Differences between solvers are small parts of a percent.
        format!("{error:+.1e}")
    } else if target.is_relative() {
        format!("{:+.2} %", 100.0 * error)
    } else {
        short(error)
    }
}

/// The lines of a table by the labels in these columns, in the order of the runs.
fn lines<'a>(table: &'a Table, columns: &[usize]) -> Vec<Line<'a>> {
    let mut lines: Vec<Line> = Vec::new();
    for row in &table.rows {
        let labels: Vec<&str> = columns.iter().map(|at| row.run.labels[*at].as_str()).collect();
        match lines.iter_mut().find(|line| line.labels == labels) {
            Some(line) => line.runs.push(row),
            None => lines.push(Line { labels, runs: vec![row] }),
        }
    }
    lines
}

/// A column of some runs: its number or its range, with the error or the worst one in brackets.
fn cell(table: &Table, column: &str, runs: &[&Row]) -> String {
    let numbers = |column: &str| -> Vec<f64> {
        runs.iter().filter_map(|row| row.run.numbers.get(column).copied()).collect()
    };
    let mut values = numbers(column);
    values.sort_by(f64::total_cmp);
    let range = match &values[..] {
        [] => return String::new(),
        [value] => short(*value),
        [low, .., high] => format!("{} ... {}", short(*low), short(*high)),
    };
    let errors = numbers(&error_of(column)).into_iter();
    match (table.targets.get(column), errors.max_by(|a, b| a.abs().total_cmp(&b.abs()))) {
        (Some(target), Some(worst)) => format!("{range} ({})", error(target, worst)),
        _ => range,
    }
}

/// How runs ended, in short.
fn ending(runs: &[&Row]) -> String {
    let worst = runs.iter().find(|row| row.status != "done");
    let said = worst.or_else(|| runs.iter().find(|row| !row.message.is_empty())).or(runs.first());
    let Some(row) = said else { return String::new() };
    let brief: String = row.message.chars().take(80).collect();
    let dots = if brief.len() < row.message.len() { " ..." } else { "" };
    match brief.as_str() {
        "" => row.status.into(),
        _ => format!("{}: {brief}{dots}", row.status),
    }
}

/// A Markdown table whose columns are as wide as their widest cells.
pub fn markdown(head: &[&str], rows: Vec<Vec<String>>) -> String {
    let plain = |cell: &String| cell.replace('|', "\\|").replace('\n', " ");
    let head = head.iter().map(|name| name.to_string()).collect();
    let lines: Vec<Vec<String>> =
        [head].iter().chain(&rows).map(|row| row.iter().map(plain).collect()).collect();
    let width = |at: usize| lines.iter().map(|cells| cells[at].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
    let line = |cells: &Vec<String>| {
        let cells = cells.iter().zip(&widths).map(|(cell, width)| format!(" {cell:<width$} |"));
        format!("|{}\n", cells.collect::<String>())
    };
    let rule: String = widths.iter().map(|width| "-".repeat(width + 2) + "|").collect();
    let below: String = lines[1..].iter().map(line).collect();
    format!("{}|{rule}\n{below}", line(&lines[0]))
}

/// The columns that tables and figures show: those that the study names, or the measures and, in a
/// table, the usual costs.
pub fn shown<'a>(study: &'a Study, table: &'a Table, costs: bool) -> Vec<&'a str> {
    let measures = table.measures.iter().map(String::as_str);
    match &study.columns {
        Some(columns) => columns.iter().map(String::as_str).collect(),
        None if costs => measures.chain(USUAL).collect(),
        None => measures.collect(),
    }
}

/// The tables of a study: one of all runs, or one of each quantity across the labels of a column.
pub fn tables(study: &Study, table: &Table) -> String {
    let names = table.names.iter().enumerate();
    let kept = names.filter(|(_, name)| !study.over.contains(name)).map(|(at, _)| at);
    let kept: Vec<usize> = kept.collect();
    match &study.across {
        Some(across) => all_across(study, table, &kept, across),
        None => of_all(study, table, &kept),
    }
}

/// A line for all runs that differ in columns that are summed up only.
fn of_all(study: &Study, table: &Table, kept: &[usize]) -> String {
    let columns = shown(study, table, true);
    let summed = !study.over.is_empty();
    let mut top: Vec<&str> = kept.iter().map(|at| table.names[*at].as_str()).collect();
    top.extend(summed.then_some("runs"));
    top.extend(columns.iter().map(|column| head(column)));
    top.push("status");
    let of_line = |line: Line| {
        let mut cells: Vec<String> = line.labels.iter().map(|label| label.to_string()).collect();
        cells.extend(summed.then(|| line.runs.len().to_string()));
        cells.extend(columns.iter().map(|column| cell(table, column, &line.runs)));
        cells.push(ending(&line.runs));
        cells
    };
    markdown(&top, lines(table, kept).into_iter().map(of_line).collect())
}

/// Each quantity in a table of its own: a line for what else is varied, a column for each label of
/// `across`, and the status where a run is not done. Runs without that label are left out.
fn all_across(study: &Study, table: &Table, kept: &[usize], across: &str) -> String {
    let Some(at) = table.names.iter().position(|name| name == across) else {
        return String::new();
    };
    let mut labels: Vec<&str> = Vec::new();
    for label in table.rows.iter().map(|row| row.run.labels[at].as_str()) {
        if !label.is_empty() && !labels.contains(&label) {
            labels.push(label);
        }
    }
    let others: Vec<usize> = kept.iter().copied().filter(|other| *other != at).collect();
    let heads: Vec<String> = labels.iter().map(|label| format!("{across} = {label}")).collect();
    let names = others.iter().map(|other| &table.names[*other]);
    let top: Vec<&str> = names.chain(&heads).map(String::as_str).collect();
    let one = |column: &str| {
        let of_label = |line: &Line, label: &str| {
            let runs = line.runs.iter().filter(|row| row.run.labels[at] == label);
            let runs: Vec<&Row> = runs.copied().collect();
            match runs.iter().find(|row| row.status != "done") {
                Some(row) => row.status.to_owned(),
                None => cell(table, column, &runs),
            }
        };
        let of_line = |line: Line| {
            let names = line.labels.iter().map(|label| label.to_string());
            names.chain(labels.iter().map(|label| of_label(&line, label))).collect()
        };
        let mut lines = lines(table, &others);
        lines.retain(|line| line.runs.iter().any(|row| !row.run.labels[at].is_empty()));
        let rows = lines.into_iter().map(of_line).collect();
        format!("{}:\n\n{}", head(column), markdown(&top, rows))
    };
    shown(study, table, false).into_iter().map(one).collect::<Vec<_>>().join("\n")
}

/// A column as axes of figures have it, with its unit.
pub fn with_unit(table: &Table, column: &str) -> String {
    match table.units.get(column).filter(|unit| !unit.is_empty()) {
        Some(unit) => format!("{column} ({unit})"),
        None => head(column).to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn study_numbers_have_four_digits() {
        assert_eq!(
            [0.0, 12.345678, 0.0123456, 123456.7, 2.5e-7, 1441.0].map(short),
            ["0", "12.35", "0.01235", "123457", "2.500e-7", "1441"]
        );
    }

    #[test]
    fn tables_are_as_wide_as_their_cells() {
        let row = ["100", "a|b"].map(str::to_owned).to_vec();
        let lines = "| Re  | drag |\n|-----|------|\n| 100 | a\\|b |\n";
        assert_eq!(markdown(&["Re", "drag"], vec![row]), lines);
    }
}
