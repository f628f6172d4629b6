//! A study file: what it says.

use mics_run::config::Fault;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, de};
use std::collections::BTreeMap;
use std::fmt;
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
    /// Wall-clock time that a run may take (s): one that takes longer is ended, and `too slow`.
    pub limit_seconds: Option<f64>,
    /// Columns of `study.csv` that tables and figures show.
    pub columns: Option<Vec<String>>,
    /// The label column whose labels are the heads of the tables.
    pub across: Option<String>,
    /// The label columns over which tables and figures sum up: ranges, and worst errors.
    #[serde(default)]
    pub over: Vec<String>,
    /// Overrides of every run.
    #[serde(default)]
    pub set: Table,
    /// Axes that are varied: the product of all is run.
    #[serde(default)]
    pub axis: Vec<Axis>,
    /// Runs besides the product.
    #[serde(default)]
    pub row: Vec<Listed>,
    /// References that measures are compared with, by the measure.
    #[serde(default)]
    pub reference: BTreeMap<String, Reference>,
    /// Changes by `--quick`.
    #[serde(default)]
    pub quick: Quick,
}

/// Something that is varied: the values of one key, or choices of several.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Its column in `study.csv`.
    pub name: String,
    /// The key that takes the `values`.
    pub key: Option<String>,
    /// Values of `key`, which are their own labels.
    #[serde(default)]
    pub values: Vec<Value>,
    /// Or, without `key`: sets of overrides, each with its label.
    #[serde(default)]
    pub choices: Vec<Choice>,
}

/// A labelled set of overrides.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// Label in the axis's column.
    pub label: Label,
    /// Overrides.
    #[serde(default)]
    pub set: Table,
}

/// A run besides the product of the axes, done with each choice of the axes that it does not label.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// Labels in its columns, by their names.
    pub labels: BTreeMap<String, Label>,
    /// Overrides.
    #[serde(default)]
    pub set: Table,
}

/// Text of a label; numbers and lists are some too.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(from = "Value")]
pub struct Label(pub String);

impl From<Value> for Label {
    /// A value as a label: a text without its quotes.
    fn from(value: Value) -> Label {
        Label(value.as_str().map_or_else(|| value.to_string(), str::to_owned))
    }
}

/// Reference that a measure is compared with.
#[derive(Clone, Debug)]
pub enum Reference {
    /// The value that it should have.
    Value(f64),
    /// Where its values are.
    Place(Place),
}

/// Place of references: a column of a CSV file, or another run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// The CSV file, from the study file's folder; lines that begin with # are comments.
    pub file: Option<PathBuf>,
    /// The column of the file.
    pub column: Option<String>,
    /// The row of the file: what its other columns hold there, or the label column whose label
    /// they hold.
    #[serde(default)]
    pub row: BTreeMap<String, Label>,
    /// Or the run that has it: the labels in which it differs from the one that is compared. A run
    /// to which there is no such other one has no reference.
    #[serde(default)]
    pub run: BTreeMap<String, Label>,
}

impl<'de> Deserialize<'de> for Reference {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Reference, D::Error> {
        deserializer.deserialize_any(ValueOrPlace)
    }
}

/// Reads a reference, a number or a table.
struct ValueOrPlace;

impl<'de> Visitor<'de> for ValueOrPlace {
    type Value = Reference;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a number, or the place of one as {{ file = ..., column = ... }}")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Reference, E> {
        Ok(Reference::Value(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Reference, E> {
        Ok(Reference::Value(value as f64))
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Reference, M::Error> {
        de::Deserialize::deserialize(MapAccessDeserializer::new(map)).map(Reference::Place)
    }
}

/// Changes by `--quick`, which does every run once.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Quick {
    /// Overrides that win over all others.
    pub set: Table,
    /// The labels that are kept, by column; all where a column is not named.
    pub keep: BTreeMap<String, Vec<Label>>,
}

fn one() -> usize {
    1
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
    /// What is chosen from, its values too.
    pub fn all(&self) -> Vec<Choice> {
        let of_key = |value: &Value| Choice {
            label: Label::from(value.clone()),
            set: self.key.iter().map(|key| (key.clone(), value.clone())).collect(),
        };
        self.values.iter().map(of_key).chain(self.choices.iter().cloned()).collect()
    }

    /// The key that has the choices.
    pub fn list(&self) -> &'static str {
        if self.key.is_some() { "values" } else { "choices" }
    }
}
