//! A column of the table laid out over two labels: rows of what is varied, a column for each label
//! of one of them, and words where a run is not done. Runs without that label are left out.

use super::columns::head;
use super::file::Cross;
use super::markdown::{self, in_table};
use super::plan::Plan;
use super::table::Row;

/// The layouts, each below a line that says what it has.
pub fn cross(plan: &Plan, rows: &[Row], layouts: &[Cross]) -> String {
    let all: Vec<String> = layouts.iter().map(|layout| one(plan, rows, layout)).collect();
    all.join("\n")
}

/// One layout.
fn one(plan: &Plan, rows: &[Row], layout: &Cross) -> String {
    let label = |row: &Row, name: &str| match plan.names.iter().position(|other| other == name) {
        Some(at) => row.labels[at].clone(),
        None => row.ranks.to_string(),
    };
    let varies = |name: &&String| rows.iter().any(|row| label(row, name) != label(&rows[0], name));
    let ranks = "ranks".to_owned();
    let others: Vec<&String> = plan
        .names
        .iter()
        .chain([&ranks])
        .filter(|name| **name != layout.across && varies(name))
        .collect();
    let mut heads: Vec<String> = Vec::new();
    let mut lines: Vec<(Vec<String>, Vec<&Row>)> = Vec::new();
    for row in rows {
        let across = label(row, &layout.across);
        if across.is_empty() {
            continue;
        }
        if !heads.contains(&across) {
            heads.push(across);
        }
        let key: Vec<String> = others.iter().map(|name| label(row, name)).collect();
        match lines.iter_mut().find(|(other, _)| *other == key) {
            Some((_, of_key)) => of_key.push(row),
            None => lines.push((key, vec![row])),
        }
    }
    let named = |value: &String| format!("{} = {value}", layout.across);
    let titles = others.iter().map(|name| (*name).clone()).chain(heads.iter().map(named));
    let title = format!("{} over {}:\n\n", head(&layout.column), layout.across);
    let mut text = title + &markdown::heading(&titles.collect::<Vec<_>>());
    for (key, of_key) in lines {
        let cell = |value: &String| {
            let row = of_key.iter().find(|row| label(row, &layout.across) == *value);
            row.map_or(String::new(), |row| match row.number(&layout.column) {
                Some(number) => in_table(&layout.column, number),
                None if row.status == "done" => String::new(),
                None => row.status.to_owned(),
            })
        };
        let cells: Vec<String> = key.iter().cloned().chain(heads.iter().map(cell)).collect();
        text += &markdown::line(&cells);
    }
    text
}
