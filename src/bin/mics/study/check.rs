//! What can be wrong with a study file before any case is read.

use super::columns::{COLUMNS, NUMBERS};
use super::file::{Axis, Reference, Study, fault, label};
use mics_run::config::{Check, suggest};
use std::collections::BTreeSet;
use toml::{Table, Value};

impl Study {
    /// Checks what can be wrong with it before any case is read.
    pub fn check(&self) -> Check {
        self.check_name_and_repeats()?;
        overrides("set", &self.set)?;
        overrides("quick.set", &self.quick.set)?;
        for (index, axis) in self.axis.iter().enumerate() {
            self.check_axis(index, axis)?;
        }
        for (index, row) in self.row.iter().enumerate() {
            let key = format!("row.{index}");
            if row.labels.is_empty() {
                let message = "must name the run, as in { grid = \"fine\" }";
                return Err(fault(format!("{key}.labels"), message));
            }
            row.labels.keys().try_for_each(|name| column_name(&format!("{key}.labels"), name))?;
            overrides(&format!("{key}.set"), &row.set)?;
        }
        self.check_columns()?;
        self.check_shown()?;
        self.check_kept()?;
        for (index, reference) in self.reference.iter().enumerate() {
            if self.reference[..index].iter().any(|other| other.measure == reference.measure) {
                let message = format!("`{}` has a reference already", reference.measure);
                return Err(fault(format!("reference.{index}.measure"), message));
            }
            reference.check(index)?;
            for (name, value) in &reference.run {
                self.check_label(format!("reference.{index}.run.{name}"), name, value)?;
            }
        }
        Ok(())
    }

    /// Columns that are shown must be some of the table's numbers.
    fn check_shown(&self) -> Check {
        let columns = self.columns.iter().flatten().enumerate();
        let columns = columns.map(|(index, name)| (format!("columns.{index}"), name));
        let costs = self.plot.costs.iter().enumerate();
        let costs = costs.map(|(index, name)| (format!("plot.costs.{index}"), name));
        for (key, name) in columns.chain(costs) {
            if !NUMBERS.contains(&name.as_str()) {
                let message =
                    format!("study.csv has no number `{name}`; {}", suggest(name, &NUMBERS));
                return Err(fault(key, message));
            }
        }
        Ok(())
    }

    /// A value must be a label of the column `name`.
    fn check_label(&self, key: String, name: &str, value: &Value) -> Check {
        let axis = self.axis.iter().filter(|axis| axis.name == name).flat_map(Axis::labels);
        let listed = self.row.iter().filter_map(|row| row.labels.get(name)).map(label);
        let ranks = self.ranks.iter().chain(self.quick.ranks.iter().flatten());
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

    fn check_name_and_repeats(&self) -> Check {
        let plain = self.name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c));
        if !plain || ["", ".", ".."].contains(&self.name.as_str()) {
            let why = format!(
                "{:?} cannot name a folder: use letters, digits, `-`, `_` and `.`",
                self.name
            );
            return Err(fault("name", why));
        }
        for (key, repeats) in
            [("repeats", Some(self.repeats)), ("quick.repeats", self.quick.repeats)]
        {
            if repeats == Some(0) {
                return Err(fault(key, "must be 1 or more"));
            }
        }
        if self.limit_seconds.is_some_and(|limit| !(limit > 0.0 && limit.is_finite())) {
            return Err(fault("limit_seconds", "must be a time above zero (s)"));
        }
        for (key, ranks) in
            [("ranks", Some(&self.ranks)), ("quick.ranks", self.quick.ranks.as_ref())]
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
    fn check_columns(&self) -> Check {
        let names = self.names();
        let known: Vec<&str> = names.iter().map(String::as_str).chain(["ranks"]).collect();
        let labelled = &known[..names.len()];
        let kept = self.quick.keep.keys().map(|name| (format!("quick.keep.{name}"), name));
        let series = self.plot.series.iter().flatten().enumerate();
        let series = series.map(|(index, name)| (format!("plot.series.{index}"), name));
        let each = self.plot.each.iter().enumerate();
        let each = each.map(|(index, name)| (format!("plot.each.{index}"), name));
        let series = series.chain(each);
        let spread = self.spread.iter().flat_map(|spread| &spread.over).enumerate();
        let spread = spread.map(|(index, name)| (format!("spread.over.{index}"), name));
        let rows = self.reference.iter().enumerate().flat_map(|(index, reference)| {
            reference
                .row_of
                .iter()
                .map(move |(column, name)| (format!("reference.{index}.row_of.{column}"), name))
        });
        let runs = self.reference.iter().enumerate().flat_map(|(index, reference)| {
            reference.run.keys().map(move |name| (format!("reference.{index}.run.{name}"), name))
        });
        let cross = self.cross.iter().enumerate();
        let cross = cross.map(|(index, cross)| (format!("cross.{index}.across"), &cross.across));
        let columns = kept.chain(series).chain(spread).chain(runs).chain(cross);
        let columns = columns.map(|(key, name)| (key, name, &known[..]));
        for (key, name, known) in columns.chain(rows.map(|(key, name)| (key, name, labelled))) {
            if !known.contains(&name.as_str()) {
                let message =
                    format!("there is no axis or label `{name}`; {}", suggest(name, known));
                return Err(fault(key, message));
            }
        }
        Ok(())
    }

    fn check_axis(&self, index: usize, axis: &Axis) -> Check {
        let key = format!("axis.{index}");
        column_name(&format!("{key}.name"), &axis.name)?;
        if self.axis[..index].iter().any(|other| other.name == axis.name) {
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
            (None, false, _) => {
                Some("lacks the `key` that takes its values, as in key = \"time.cfl\"")
            }
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

    /// What is kept must be there, so that a typing error does not empty the study.
    fn check_kept(&self) -> Check {
        for (name, kept) in &self.quick.keep {
            for (index, value) in kept.iter().enumerate() {
                self.check_label(format!("quick.keep.{name}.{index}"), name, value)?;
            }
        }
        Ok(())
    }
}

impl Reference {
    /// Checks that it says one thing, and all of it.
    pub fn check(&self, index: usize) -> Check {
        let key = format!("reference.{index}");
        let by_row = !self.row.is_empty() || !self.row_of.is_empty();
        if !self.run.is_empty() {
            let other = self.value.is_some() || self.file.is_some() || self.column.is_some();
            return match other || by_row {
                true => Err(fault(key, "has both `run` and another reference; drop one")),
                false => Ok(()),
            };
        }
        match (self.value, &self.file, &self.column) {
            (Some(value), None, None) if !by_row && value.is_finite() => Ok(()),
            (Some(value), None, None) if !by_row => Err(fault(
                format!("{key}.value"),
                format!("must be a finite number, not {value:?}"),
            )),
            (Some(_), ..) => Err(fault(key, "has both `value` and a place in a file; drop one")),
            (None, Some(_), Some(_)) => Ok(()),
            _ => Err(fault(
                key,
                "wants `value`, or `file` and `column` (and `row`, as in row = { re = 100 }), or \
                `run` (as in run = { solver = \"tight\" })",
            )),
        }
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
    if COLUMNS.contains(&name) {
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
