//! The tables of a study as Markdown: that of its runs in short, and spreads.

use super::columns::{self, USUAL};
use super::plan::Plan;
use super::table::{Row, Table};
use mics_plot::study::Target;

/// A number to four digits.
pub fn short(value: f64) -> String {
    let order = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if (-3..6).contains(&order) {
        format!("{value:.*}", (3 - order).max(0) as usize)
    } else {
        format!("{value:.3e}")
    }
}

/// An error against a target: in percent, as a part where it is that of another run, or as the
/// difference that it is.
fn show(target: &Target, error: f64) -> String {
    if target.of_runs {
        // Differences between solvers are small parts of a percent.
        format!("{error:+.1e}")
    } else if target.is_relative() {
        format!("{:+.2} %", 100.0 * error)
    } else {
        short(error)
    }
}

/// A column's number as a cell.
pub fn in_table(column: &str, value: f64) -> String {
    match column {
        "peak_memory_bytes" => format!("{:.0}", value / 1e6),
        "peak_memory_bytes_per_cell" => format!("{value:.0}"),
        "repeats"
        | "cells"
        | "steps"
        | "outer_iterations"
        | "krylov_iterations"
        | "preconditioner_setups" => format!("{value}"),
        _ => short(value),
    }
}

/// The table in short: labels, measures, these columns or the usual ones, and how a run ended.
pub fn markdown(plan: &Plan, table: &Table, columns: Option<&[String]>) -> String {
    let rows = &table.rows;
    let columns: Vec<&str> = match columns {
        Some(columns) => columns.iter().map(String::as_str).collect(),
        None => USUAL.to_vec(),
    };
    let several_ranks = rows.iter().any(|row| row.ranks != rows[0].ranks);
    let mut head = plan.names.clone();
    head.extend(several_ranks.then(|| "ranks".to_owned()));
    for name in plan.measures() {
        let compared = plan.compares(&name);
        head.push(name);
        head.extend(compared.then(|| "error".to_owned()));
    }
    head.extend(columns.iter().map(|column| columns::head(column).to_owned()));
    head.push("status".to_owned());
    let mut lines = heading(&head);
    for row in rows {
        let mut cells = row.labels.clone();
        cells.extend(several_ranks.then(|| row.ranks.to_string()));
        for measured in &row.measured {
            cells.push(measured.value.map_or(String::new(), short));
            if let Some(target) = table.target(&measured.name) {
                cells.push(measured.error.map_or(String::new(), |error| show(target, error)));
            }
        }
        let number = |column: &&str| {
            row.number(column).map_or(String::new(), |value| in_table(column, value))
        };
        cells.extend(columns.iter().map(number));
        cells.push(row.ending());
        lines += &line(&cells);
    }
    lines
}

/// A line of a Markdown table.
pub fn line(cells: &[String]) -> String {
    let cells: Vec<_> =
        cells.iter().map(|cell| cell.replace('|', "\\|").replace('\n', " ")).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// The head of a Markdown table.
pub fn heading(head: &[String]) -> String {
    line(head) + &"|---".repeat(head.len()) + "|\n"
}

/// The range and mean of every measure over the runs that differ in the columns `over` only, with
/// the worst and the mean error where there is a reference: a Markdown table.
pub fn spread(plan: &Plan, table: &Table, over: &[String]) -> String {
    let rows = &table.rows;
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
            table.target(name).iter().flat_map(|_| ["worst error".into(), "mean error".into()]),
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
            if let Some(target) = table.target(name) {
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
    fn study_numbers_have_four_digits() {
        assert_eq!(
            [0.0, 12.345678, 0.0123456, 123456.7, 2e7].map(short),
            ["0.000", "12.35", "0.01235", "123457", "2.000e7"]
        );
    }
}
