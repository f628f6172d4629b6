//! A study file is read, and what can be wrong with it before any case is.

use super::columns;
use super::file::{Axis, Quick, Reference, Study, fault, label};
use mics_run::Result;
use mics_run::config::{Check, Text, suggest};
use std::collections::BTreeSet;
use std::path::Path;
use toml::{Table, Value};

/// Reads and checks a study file, with what `--quick` changes if `quick`.
pub fn read(path: &Path, quick: bool) -> Result<(Study, Text)> {
    let text = Text::read(path, "study")?;
    let mut study: Study = text.to(&["set", "plot", "quick"])?;
    check(&study).map_err(|fault| text.refuse(fault))?;
    if quick {
        study.repeats = study.quick.repeats.unwrap_or(1);
        study.ranks = study.quick.ranks.clone().unwrap_or(study.ranks);
    } else {
        study.quick = Quick::default();
    }
    Ok((study, text))
}

/// Checks what can be wrong with it before any case is read.
fn check(study: &Study) -> Check {
    check_name_and_repeats(study)?;
    overrides("set", &study.set)?;
    overrides("quick.set", &study.quick.set)?;
    for (index, axis) in study.axis.iter().enumerate() {
        check_axis(study, index, axis)?;
    }
    for (index, row) in study.row.iter().enumerate() {
        let key = format!("row.{index}");
        if row.labels.is_empty() {
            let message = "must name the run, as in { grid = \"fine\" }";
            return Err(fault(format!("{key}.labels"), message));
        }
        row.labels.keys().try_for_each(|name| column_name(&format!("{key}.labels"), name))?;
        overrides(&format!("{key}.set"), &row.set)?;
    }
    check_columns(study)?;
    check_shown(study)?;
    check_kept(study)?;
    for (index, reference) in study.reference.iter().enumerate() {
        if study.reference[..index].iter().any(|other| other.measure == reference.measure) {
            let message = format!("`{}` has a reference already", reference.measure);
            return Err(fault(format!("reference.{index}.measure"), message));
        }
        check_reference(reference, index)?;
        for (name, value) in &reference.run {
            check_label(study, format!("reference.{index}.run.{name}"), name, value)?;
        }
    }
    Ok(())
}

/// Columns that are shown must be some of the table's numbers.
fn check_shown(study: &Study) -> Check {
    let numbers = columns::numbers();
    let columns = study.columns.iter().flatten().enumerate();
    let columns = columns.map(|(index, name)| (format!("columns.{index}"), name));
    let costs = study.plot.costs.iter().enumerate();
    let costs = costs.map(|(index, name)| (format!("plot.costs.{index}"), name));
    for (key, name) in columns.chain(costs) {
        if !numbers.contains(&name.as_str()) {
            let message = format!("study.csv has no number `{name}`; {}", suggest(name, &numbers));
            return Err(fault(key, message));
        }
    }
    Ok(())
}

/// A value must be a label of the column `name`.
fn check_label(study: &Study, key: String, name: &str, value: &Value) -> Check {
    let axis = study.axis.iter().filter(|axis| axis.name == name).flat_map(Axis::labels);
    let listed = study.row.iter().filter_map(|row| row.labels.get(name)).map(label);
    let ranks = study.ranks.iter().chain(study.quick.ranks.iter().flatten());
    let ranks = ranks.filter(|_| name == "ranks").map(usize::to_string);
    let mut known: Vec<String> = axis.chain(listed).chain(ranks).collect();
    known.dedup();
    let wanted = label(value);
    if known.contains(&wanted) {
        return Ok(());
    }
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let message = format!("`{name}` has no `{wanted}`; {}", suggest(&wanted, &known));
    Err(fault(key, message))
}

fn check_name_and_repeats(study: &Study) -> Check {
    let plain = study.name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c));
    if !plain || ["", ".", ".."].contains(&study.name.as_str()) {
        let why =
            format!("{:?} cannot name a folder: use letters, digits, `-`, `_` and `.`", study.name);
        return Err(fault("name", why));
    }
    for (key, repeats) in [("repeats", Some(study.repeats)), ("quick.repeats", study.quick.repeats)]
    {
        if repeats == Some(0) {
            return Err(fault(key, "must be 1 or more"));
        }
    }
    if study.limit_seconds.is_some_and(|limit| !(limit > 0.0 && limit.is_finite())) {
        return Err(fault("limit_seconds", "must be a time above zero (s)"));
    }
    for (key, ranks) in [("ranks", Some(&study.ranks)), ("quick.ranks", study.quick.ranks.as_ref())]
    {
        let Some(ranks) = ranks else { continue };
        let different = ranks.iter().collect::<BTreeSet<_>>().len() == ranks.len();
        if ranks.is_empty() || ranks.contains(&0) || !different {
            return Err(fault(
                key,
                "must list different numbers of ranks, each 1 or more, as in [1, 2]",
            ));
        }
    }
    Ok(())
}

/// Names of columns must be those of axes or labels.
fn check_columns(study: &Study) -> Check {
    let names = study.names();
    let known: Vec<&str> = names.iter().map(String::as_str).chain(["ranks"]).collect();
    let labelled = &known[..names.len()];
    let kept = study.quick.keep.keys().map(|name| (format!("quick.keep.{name}"), name));
    let series = study.plot.series.iter().flatten().enumerate();
    let series = series.map(|(index, name)| (format!("plot.series.{index}"), name));
    let each = study.plot.each.iter().enumerate();
    let each = each.map(|(index, name)| (format!("plot.each.{index}"), name));
    let series = series.chain(each);
    let spread = study.spread.iter().flat_map(|spread| &spread.over).enumerate();
    let spread = spread.map(|(index, name)| (format!("spread.over.{index}"), name));
    let rows = study.reference.iter().enumerate().flat_map(|(index, reference)| {
        reference
            .row_of
            .iter()
            .map(move |(column, name)| (format!("reference.{index}.row_of.{column}"), name))
    });
    let runs = study.reference.iter().enumerate().flat_map(|(index, reference)| {
        reference.run.keys().map(move |name| (format!("reference.{index}.run.{name}"), name))
    });
    let cross = study.cross.iter().enumerate();
    let cross = cross.map(|(index, cross)| (format!("cross.{index}.across"), &cross.across));
    let columns = kept.chain(series).chain(spread).chain(runs).chain(cross);
    let columns = columns.map(|(key, name)| (key, name, &known[..]));
    for (key, name, known) in columns.chain(rows.map(|(key, name)| (key, name, labelled))) {
        if !known.contains(&name.as_str()) {
            let message = format!("there is no axis or label `{name}`; {}", suggest(name, known));
            return Err(fault(key, message));
        }
    }
    Ok(())
}

fn check_axis(study: &Study, index: usize, axis: &Axis) -> Check {
    let key = format!("axis.{index}");
    column_name(&format!("{key}.name"), &axis.name)?;
    if study.axis[..index].iter().any(|other| other.name == axis.name) {
        return Err(fault(
            format!("{key}.name"),
            format!("there is an axis `{}` already", axis.name),
        ));
    }
    let message = match (&axis.key, axis.values.is_empty(), axis.choices.is_empty()) {
        (Some(_), false, true) | (None, true, false) => None,
        (Some(_), _, false) => {
            Some("an axis has either `key` with `values`, or `choices`; drop one")
        }
        (Some(_), true, true) => {
            Some("lacks its `values`: a list of what the key takes, one after another")
        }
        (None, false, _) => Some("lacks the `key` that takes its values, as in key = \"time.cfl\""),
        (None, true, true) => {
            Some("lacks `key` and `values`, or `choices = [ { label = ..., set = ... }, ... ]`")
        }
    };
    if let Some(message) = message {
        return Err(fault(key, message));
    }
    if let Some(name) = &axis.key
        && name == "petsc"
    {
        return Err(fault(
            format!("{key}.key"),
            "PETSc options go into choices: { label = ..., petsc = \"...\" }",
        ));
    }
    let list = if axis.key.is_some() { "values" } else { "choices" };
    let mut seen = BTreeSet::new();
    for (k, label) in axis.labels().into_iter().enumerate() {
        let at = format!("{key}.{list}.{k}");
        if label.is_empty() {
            return Err(fault(at, "its label is empty"));
        }
        if !seen.insert(label.clone()) {
            return Err(fault(at, format!("`{label}` is there twice")));
        }
    }
    axis.choices
        .iter()
        .enumerate()
        .try_for_each(|(k, c)| overrides(&format!("{key}.choices.{k}.set"), &c.set))
}

/// Labels that are kept must be there, so that a typing error does not empty the study.
fn check_kept(study: &Study) -> Check {
    for (name, kept) in &study.quick.keep {
        for (index, value) in kept.iter().enumerate() {
            check_label(study, format!("quick.keep.{name}.{index}"), name, value)?;
        }
    }
    Ok(())
}

/// Checks that it says one thing, and all of it.
fn check_reference(reference: &Reference, index: usize) -> Check {
    let key = format!("reference.{index}");
    let by_row = !reference.row.is_empty() || !reference.row_of.is_empty();
    if !reference.run.is_empty() {
        let other =
            reference.value.is_some() || reference.file.is_some() || reference.column.is_some();
        return match other || by_row {
            true => Err(fault(key, "has both `run` and another reference; drop one")),
            false => Ok(()),
        };
    }
    match (reference.value, &reference.file, &reference.column) {
        (Some(value), None, None) if !by_row && value.is_finite() => Ok(()),
        (Some(value), None, None) if !by_row => {
            Err(fault(format!("{key}.value"), format!("must be a finite number, not {value:?}")))
        }
        (Some(_), ..) => Err(fault(key, "has both `value` and a place in a file; drop one")),
        (None, Some(_), Some(_)) => Ok(()),
        _ => Err(fault(
            key,
            "wants `value`, or `file` and `column` (and `row`, as in row = { re = 100 }), or \
            `run` (as in run = { solver = \"tight\" })",
        )),
    }
}

/// A column's name must be one, and not one of the table's own.
fn column_name(key: &str, name: &str) -> Check {
    if name.is_empty() || name.contains(|c: char| !c.is_alphanumeric() && c != '_' && c != '-') {
        return Err(fault(
            key,
            format!("`{name}` cannot name a column: use letters, digits, `-` and `_`"),
        ));
    }
    if columns::all().contains(&name) {
        return Err(fault(
            key,
            format!("`{name}` is a column that study.csv has anyway; use another name"),
        ));
    }
    Ok(())
}

/// Overrides are one dotted key each.
fn overrides(key: &str, set: &Table) -> Check {
    match set.iter().find(|(name, value)| !name.contains('.') && value.is_table()) {
        Some((name, value)) => {
            let below = value
                .as_table()
                .and_then(|table| table.keys().next())
                .map_or("...", String::as_str);
            let message = format!("write each override's key in quotes: \"{name}.{below}\" = ...");
            Err(fault(key, message))
        }
        None => Ok(()),
    }
}
