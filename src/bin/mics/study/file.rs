//! A study file: what it says, and what can be wrong with it before any case is read.

use mics_run::Result;
use mics_run::config::{Check, Fault, Text, suggest};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

use super::columns::COLUMNS;

/// A whole study file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// The study's name; its folder is `runs/NAME` unless `--out` names another.
    pub name: String,
    /// The case file, from the study file's folder.
    pub case: PathBuf,
    /// How often each run is repeated; times are medians.
    #[serde(default = "one")]
    pub repeats: usize,
    /// Numbers of ranks; every run is done on each.
    #[serde(default = "serial")]
    pub ranks: Vec<usize>,
    /// Whether the runs keep their snapshots; default no.
    #[serde(default)]
    pub keep_fields: bool,
    /// Overrides of every run, by dotted key in quotes.
    #[serde(default)]
    pub set: Table,
    /// PETSc options of every run.
    #[serde(default)]
    pub petsc: String,
    /// What is varied: the product of all axes is run.
    #[serde(default)]
    pub axis: Vec<Axis>,
    /// Runs besides the product, one by one.
    #[serde(default)]
    pub row: Vec<Listed>,
    /// What measures are compared with.
    #[serde(default)]
    pub reference: Vec<Reference>,
    /// What is summed up besides, as `spread.md`.
    #[serde(default)]
    pub spread: Option<Spread>,
    /// How the figures group the runs.
    #[serde(default)]
    pub plot: Plot,
    /// What `--quick` changes.
    #[serde(default)]
    pub quick: Quick,
}

/// Something that is varied: the values of one key, or choices of several.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Its column in `study.csv`.
    pub name: String,
    /// The key of the case that takes the `values`.
    #[serde(default)]
    pub key: Option<String>,
    /// Values of `key`.
    #[serde(default)]
    pub values: Vec<Value>,
    /// Or, without `key`: sets of overrides and PETSc options, each with its label.
    #[serde(default)]
    pub choices: Vec<Choice>,
}

/// A labelled set of overrides and PETSc options.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// What its column says.
    pub label: String,
    /// Overrides, by dotted key in quotes.
    #[serde(default)]
    pub set: Table,
    /// PETSc options.
    #[serde(default)]
    pub petsc: String,
}

/// A run besides the product of the axes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// What its columns say, by their names.
    pub labels: Table,
    /// Another case file than the study's.
    #[serde(default)]
    pub case: Option<PathBuf>,
    /// Overrides, by dotted key in quotes.
    #[serde(default)]
    pub set: Table,
    /// PETSc options.
    #[serde(default)]
    pub petsc: String,
}

/// What a measure is compared with: a value, or a number in a CSV file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The measure's name in the case.
    pub measure: String,
    /// The value that it should have.
    #[serde(default)]
    pub value: Option<f64>,
    /// Or the CSV file that has it, from the study file's folder; lines that begin with # are
    /// comments.
    #[serde(default)]
    pub file: Option<PathBuf>,
    /// The column of the file.
    #[serde(default)]
    pub column: Option<String>,
    /// The row of the file: what other columns hold there.
    #[serde(default)]
    pub row: Table,
    /// Or, run by run: the axis (or label) whose label another column holds there; no reference
    /// where no row has it.
    #[serde(default)]
    pub row_of: BTreeMap<String, String>,
}

/// What is summed up over some columns: the range, mean, worst and mean error of every measure in
/// the runs that differ in nothing else.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// The columns.
    pub over: Vec<String>,
}

/// How the figures group the runs.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plot {
    /// The columns that tell one curve from another; default all but the first.
    #[serde(default)]
    pub series: Option<Vec<String>>,
    /// What others paid for their errors.
    #[serde(default)]
    pub others: Vec<Others>,
}

/// Points of other programs in the figure of a measure's error over CPU time.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Others {
    /// The measure.
    pub measure: String,
    /// A CSV file, beside the study.
    pub file: PathBuf,
    /// The column that says whose a point is.
    pub label: String,
    /// That of the CPU time (s).
    pub cpu: String,
    /// That of the error (% where errors are parts of a reference).
    pub error: String,
}

/// What `--quick` changes.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quick {
    /// How often each run is repeated.
    #[serde(default)]
    pub repeats: Option<usize>,
    /// Numbers of ranks.
    #[serde(default)]
    pub ranks: Option<Vec<usize>>,
    /// Overrides that win over all others.
    #[serde(default)]
    pub set: Table,
    /// The labels that are kept, by column; all where a column is not named.
    #[serde(default)]
    pub keep: BTreeMap<String, Vec<Value>>,
}

fn one() -> usize {
    1
}

fn serial() -> Vec<usize> {
    vec![1]
}

/// A value as a label: a text without its quotes.
pub fn label(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// The refusal of a key.
pub fn fault(key: impl Into<String>, message: impl Into<String>) -> Fault {
    Fault { key: key.into(), message: message.into() }
}

/// Reads and checks a study file, with what `--quick` changes if `quick`.
pub fn read(path: &Path, quick: bool) -> Result<(Study, Text)> {
    let text = Text::read(path, "study")?;
    let mut study: Study = text.to(&["set", "plot", "quick"])?;
    study.check().map_err(|fault| text.refuse(fault))?;
    if quick {
        study.repeats = study.quick.repeats.unwrap_or(1);
        study.ranks = study.quick.ranks.clone().unwrap_or(study.ranks);
    } else {
        study.quick = Quick::default();
    }
    Ok((study, text))
}

impl Study {
    /// The names of the columns that tell runs apart, in the order in which the file has them.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.axis.iter().map(|axis| axis.name.clone()).collect();
        for name in self.row.iter().flat_map(|row| row.labels.keys()) {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
        names
    }

    fn check(&self) -> Check {
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
        self.check_kept()?;
        for (index, reference) in self.reference.iter().enumerate() {
            if self.reference[..index].iter().any(|other| other.measure == reference.measure) {
                let message = format!("`{}` has a reference already", reference.measure);
                return Err(fault(format!("reference.{index}.measure"), message));
            }
            reference.check(index)?;
        }
        Ok(())
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
        let spread = self.spread.iter().flat_map(|spread| &spread.over).enumerate();
        let spread = spread.map(|(index, name)| (format!("spread.over.{index}"), name));
        let rows = self.reference.iter().enumerate().flat_map(|(index, reference)| {
            reference
                .row_of
                .iter()
                .map(move |(column, name)| (format!("reference.{index}.row_of.{column}"), name))
        });
        let columns = kept.chain(series).chain(spread).map(|(key, name)| (key, name, &known[..]));
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
            let axis = self.axis.iter().filter(|axis| axis.name == *name).flat_map(Axis::labels);
            let listed = self.row.iter().filter_map(|row| row.labels.get(name)).map(label);
            let mut known: Vec<String> = axis.chain(listed).collect();
            known.dedup();
            for (index, value) in kept.iter().enumerate() {
                let wanted = label(value);
                if !known.contains(&wanted) {
                    let known: Vec<&str> = known.iter().map(String::as_str).collect();
                    let message =
                        format!("`{name}` has no `{wanted}`; {}", suggest(&wanted, &known));
                    return Err(fault(format!("quick.keep.{name}.{index}"), message));
                }
            }
        }
        Ok(())
    }
}

impl Axis {
    /// What its column says, choice by choice.
    pub fn labels(&self) -> Vec<String> {
        let choices = self.choices.iter().map(|choice| choice.label.clone());
        self.values.iter().map(label).chain(choices).collect()
    }
}

impl Reference {
    fn check(&self, index: usize) -> Check {
        let key = format!("reference.{index}");
        let by_row = !self.row.is_empty() || !self.row_of.is_empty();
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
                "wants `value`, or `file` and `column` (and `row`, as in row = { re = 100 })",
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
