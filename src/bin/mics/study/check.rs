//! A study file is read, and what can be wrong with it before any case is.

use super::columns::own_columns;
use super::file::{Axis, Choice, Label, Quick, Reference, Study, fault};
use mics_run::Result;
use mics_run::config::{Check, Text, suggest};
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Message about PETSc options.
const OPTIONS: &str = "PETSc options are a key of the case: set = { \"petsc.options\" = \"...\" }";

/// Keys of earlier versions, each with its replacement.
const GONE: [(&str, &str); 13] = [
    ("ranks", "ranks are varied as all else: [[axis]] with key = \"ranks\" and its values"),
    ("petsc", OPTIONS),
    ("failures", "a run that is not done is a row, and the status is then 1: leave this key out"),
    (
        "keep_fields",
        "a study keeps no snapshots: leave this key out, and `mics run` a case for them",
    ),
    ("axis.choices.petsc", OPTIONS),
    ("row.case", "the case is an override as others: set = { case = \"...\" }"),
    ("row.petsc", OPTIONS),
    ("reference.measure", "write [reference.MEASURE], or MEASURE = 1.5 in [reference]"),
    ("cross", "write across = \"...\" at the top, and the columns into `columns`"),
    ("spread", "write over = [...] at the top"),
    ("plot", "curves are told apart by all that is varied: leave this table out"),
    ("quick.repeats", "with --quick every run is done once: leave this key out"),
    ("quick.ranks", "write keep = { ranks = [...] }"),
];

/// Reads and checks a study file, with what `--quick` changes if `quick`.
pub fn read(text: &Text, quick: bool) -> Result<Study> {
    let mut study: Study = text.to(&["set", "reference", "quick"], &GONE)?;
    check(&study).map_err(|fault| text.refuse(fault))?;
    if quick {
        study.repeats = 1;
    } else {
        study.quick = Quick::default();
    }
    Ok(study)
}

fn check(study: &Study) -> Check {
    check_top(study)?;
    for (index, axis) in study.axis.iter().enumerate() {
        let key = format!("axis.{index}");
        if study.axis[..index].iter().any(|other| other.name == axis.name) {
            let message = format!("there is an axis `{}` already", axis.name);
            return Err(fault(format!("{key}.name"), message));
        }
        check_axis(&key, axis)?;
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
    for (name, kept) in &study.quick.keep {
        for (index, label) in kept.iter().enumerate() {
            check_label(study, format!("quick.keep.{name}.{index}"), name, label)?;
        }
    }
    for (measure, reference) in &study.reference {
        let Reference::Place(place) = reference else { continue };
        for (name, label) in &place.run {
            check_label(study, format!("reference.{measure}.run.{name}"), name, label)?;
        }
    }
    Ok(())
}

/// Checks the keys at the top.
fn check_top(study: &Study) -> Check {
    let plain = study.name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c));
    if !plain || ["", ".", ".."].contains(&study.name.as_str()) {
        let name = &study.name;
        let why = format!("{name:?} cannot name a folder: use letters, digits, `-`, `_` and `.`");
        return Err(fault("name", why));
    }
    if study.repeats == 0 {
        return Err(fault("repeats", "must be 1 or more"));
    }
    if study.limit_seconds.is_some_and(|limit| !(limit > 0.0 && limit.is_finite())) {
        return Err(fault("limit_seconds", "must be a time above zero (s)"));
    }
    overrides("set", &study.set)?;
    overrides("quick.set", &study.quick.set)?;
    study.across.iter().try_for_each(|name| known_column(study, "across".into(), name))?;
    let mut over = study.over.iter().enumerate();
    over.try_for_each(|(index, name)| known_column(study, format!("over.{index}"), name))
}

fn check_axis(key: &str, axis: &Axis) -> Check {
    column_name(&format!("{key}.name"), &axis.name)?;
    let message = match (&axis.key, axis.values.is_empty(), axis.choices.is_empty()) {
        (Some(_), false, true) | (None, true, false) => None,
        (None, false, _) => Some("lacks the `key` that takes its values, as in key = \"time.cfl\""),
        (Some(_), true, true) => Some("lacks its `values`, as in values = [0.2, 0.4]"),
        _ => Some("wants `key` and `values`, or choices = [{ label = ..., set = ... }, ...]"),
    };
    if let Some(message) = message {
        return Err(fault(key, message));
    }
    let mut seen = BTreeSet::new();
    for (index, Choice { label, set }) in axis.all().into_iter().enumerate() {
        let at = format!("{key}.{}.{index}", axis.list());
        if label.0.is_empty() {
            return Err(fault(at, "its label is empty"));
        }
        if seen.contains(&label.0) {
            return Err(fault(at, format!("`{}` is there twice", label.0)));
        }
        overrides(&at, &set)?;
        seen.insert(label.0);
    }
    Ok(())
}

/// A name must be that of a label column.
fn known_column(study: &Study, key: String, name: &String) -> Check {
    let names = study.names();
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    match names.contains(name) {
        true => Ok(()),
        false => {
            let message = format!("there is no axis or label `{name}`; {}", suggest(name, &known));
            Err(fault(key, message))
        }
    }
}

/// A label must be one of the column `name`, so that a typing error does not empty the study.
fn check_label(study: &Study, key: String, name: &String, wanted: &Label) -> Check {
    known_column(study, key.clone(), name)?;
    let axis = study.axis.iter().find(|axis| axis.name == *name);
    let of_axis = axis.into_iter().flat_map(|axis| axis.all()).map(|choice| choice.label.0);
    let of_rows = study.row.iter().filter_map(|row| row.labels.get(name)).map(|l| l.0.clone());
    let known: BTreeSet<String> = of_axis.chain(of_rows).collect();
    if known.contains(&wanted.0) {
        return Ok(());
    }
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let message = format!("`{name}` has no `{}`; {}", wanted.0, suggest(&wanted.0, &known));
    Err(fault(key, message))
}

/// A label column's name must be one, and not one of the table's own.
fn column_name(key: &str, name: &str) -> Check {
    if name.is_empty() || name.contains(|c: char| !c.is_alphanumeric() && c != '_' && c != '-') {
        let message = format!("`{name}` cannot name a column: use letters, digits, `-` and `_`");
        return Err(fault(key, message));
    }
    if own_columns().contains(&name) {
        let message = format!("`{name}` is a column that study.csv has anyway; use another name");
        return Err(fault(key, message));
    }
    Ok(())
}

/// Overrides are one dotted key each; `case` and `ranks` are those of the run itself.
fn overrides(key: &str, set: &Table) -> Check {
    for (name, value) in set {
        let message = match (name.as_str(), value) {
            ("case", value) if !value.is_str() => "case must be a file's name in quotes".into(),
            ("ranks", value) if value.as_integer().is_none_or(|ranks| ranks < 1) => {
                "ranks must be a whole number, 1 or more".into()
            }
            (name, Value::Table(table)) if !name.contains('.') => {
                let below = table.keys().next().map_or("...", String::as_str);
                format!("write each override's key in quotes: \"{name}.{below}\" = ...")
            }
            _ => continue,
        };
        return Err(fault(key, message));
    }
    Ok(())
}
