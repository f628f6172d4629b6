//! A study file: what it says.

use mics_run::config::Fault;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use toml::{Table, Value};

/// A whole study file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// The study's name; its folder is `runs/NAME` unless `--out` names another.
    pub name: String,
    /// The case file, from the study file's folder.
    pub case: PathBuf,
    /// Number of times that each run is done; times are medians.
    #[serde(default = "one")]
    pub repeats: usize,
    /// Numbers of ranks; every run is done on each.
    #[serde(default = "serial")]
    pub ranks: Vec<usize>,
    /// Wall-clock time that a run may take (s): one that takes longer is ended, and `too slow`.
    pub limit_seconds: Option<f64>,
    /// Status with which a study ends that has runs which are not done.
    #[serde(default)]
    pub failures: Failures,
    /// The columns of `study.csv` that `study.md` has besides labels, measures and status.
    pub columns: Option<Vec<String>>,
    /// Whether the runs keep their snapshots; default no.
    #[serde(default)]
    pub keep_fields: bool,
    /// Overrides of every run, by dotted key in quotes.
    #[serde(default)]
    pub set: Table,
    /// PETSc options of every run.
    #[serde(default)]
    pub petsc: String,
    /// Axes that are varied: the product of all is run.
    #[serde(default)]
    pub axis: Vec<Axis>,
    /// Runs besides the product, one by one.
    #[serde(default)]
    pub row: Vec<Listed>,
    /// References that measures are compared with.
    #[serde(default)]
    pub reference: Vec<Reference>,
    /// Columns over which all is summed up besides, as `spread.md`.
    pub spread: Option<Spread>,
    /// Columns laid out over two labels, as `cross.md`.
    #[serde(default)]
    pub cross: Vec<Cross>,
    /// Groups of the runs in the figures.
    #[serde(default)]
    pub plot: Plot,
    /// Changes by `--quick`.
    #[serde(default)]
    pub quick: Quick,
}

/// Status with which a study ends that has runs which are refused, fail or are too slow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Failures {
    /// Status 1, the default.
    #[default]
    Error,
    /// Status 0: a failure is a result.
    Rows,
}

/// Something that is varied: the values of one key, or choices of several.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Its column in `study.csv`.
    pub name: String,
    /// The key of the case that takes the `values`.
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
    /// Label in the axis's column.
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
    /// Labels in its columns, by their names.
    pub labels: Table,
    /// Another case file than the study's.
    pub case: Option<PathBuf>,
    /// Overrides, by dotted key in quotes.
    #[serde(default)]
    pub set: Table,
    /// PETSc options.
    #[serde(default)]
    pub petsc: String,
}

/// Reference that a measure is compared with.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The measure's name in the case.
    pub measure: String,
    /// The value that it should have.
    pub value: Option<f64>,
    /// Or the CSV file that has it, from the study file's folder; lines that begin with # are
    /// comments.
    pub file: Option<PathBuf>,
    /// The column of the file.
    pub column: Option<String>,
    /// The row of the file: what other columns hold there.
    #[serde(default)]
    pub row: Table,
    /// Or, run by run: the axis (or label) whose label another column holds there; no reference
    /// where no row has it.
    #[serde(default)]
    pub row_of: BTreeMap<String, String>,
    /// Or the run that has it: the labels in which it differs from the one that is compared. A run
    /// to which there is no such other one has no reference.
    #[serde(default)]
    pub run: Table,
}

/// A column of `study.csv`, and the label that its values are laid out across.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cross {
    /// The column.
    pub column: String,
    /// The axis, label or `ranks` whose labels are the heads.
    pub across: String,
}

/// Summary over some columns: the range, mean, worst and mean error of every measure in the runs
/// that differ in nothing else.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// The columns.
    pub over: Vec<String>,
}

/// Groups of the runs in the figures.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plot {
    /// The columns that tell one curve from another; default all but the first.
    pub series: Option<Vec<String>>,
    /// The columns that have a figure for each of their labels.
    pub each: Vec<String>,
    /// The columns of `study.csv` that have a figure, over cells or what is varied.
    pub costs: Vec<String>,
    /// Errors of other programs, and their costs.
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
    /// The column of the CPU time (s).
    pub cpu: String,
    /// The column of the error (% where errors are parts of a reference).
    pub error: String,
}

/// Changes by `--quick`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Quick {
    /// Number of times that each run is done.
    pub repeats: Option<usize>,
    /// Numbers of ranks.
    pub ranks: Option<Vec<usize>>,
    /// Overrides that win over all others.
    pub set: Table,
    /// The labels that are kept, by column; all where a column is not named.
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
}

impl Axis {
    /// Labels in its column, value by value and choice by choice.
    pub fn labels(&self) -> Vec<String> {
        let choices = self.choices.iter().map(|choice| choice.label.clone());
        self.values.iter().map(label).chain(choices).collect()
    }
}
