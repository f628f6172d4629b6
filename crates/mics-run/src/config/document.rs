//! A parsed case file with its overrides and its preset: where each key stands.
//!
//! Overrides are put into the parsed document under spans beyond the end of the text, and what a
//! preset fills in under the span of `preset`, so that one walk over the document tells both where
//! a key stands and what gave it.

use std::ops::Range;
use std::path::Path;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::fault::Fault;
use super::message::reword;
use super::reference::choices;
use super::{Case, MeasureKind, preset};
use crate::error::Given;
use crate::{Error, Result};

/// Keys that exclude each other: overriding the first drops the second from the file.
const REPLACES: [(&str, &str); 8] = [
    ("step", "cfl"),
    ("cfl", "step"),
    ("every", "every_time"),
    ("every_time", "every"),
    ("every_steps", "every_wall_minutes"),
    ("every_wall_minutes", "every_steps"),
    ("restitution", "damping"),
    ("damping", "restitution"),
];

/// The keys of a case that are tables.
const TABLES: [&str; 12] = [
    "domain",
    "fluid",
    "boundary",
    "initial",
    "drive",
    "coupling",
    "contact",
    "time",
    "pressure",
    "petsc",
    "statistics",
    "output",
];

/// Message about the six former keys of the mixture method.
const AS_PRINTED: &str = "coupling.wall = \"mixing\" is the paper's method as printed, and has no \
    choices: leave this key out";

/// Keys of earlier versions, each with its replacement; in lists every entry is searched for them.
const GONE: [(&str, &str); 9] = [
    ("coupling.fraction", AS_PRINTED),
    ("coupling.force", AS_PRINTED),
    ("coupling.rotation", AS_PRINTED),
    ("coupling.mix_pressure", AS_PRINTED),
    ("coupling.buoyancy", AS_PRINTED),
    ("coupling.gradient", AS_PRINTED),
    (
        "numerics",
        "the numbers of the method are no keys any more, they are constants of src/numerics.rs, \
        which docs/method.md describes: leave this table out",
    ),
    (
        "time.upwinding",
        "advection is upwinded in full, as it was without this key: leave it out, and use more \
        cells where small eddies are damped",
    ),
    (
        "drive.hold_mixture",
        "hold the mean velocity of fluid and particles in its place, as in drive.mean_velocity = \
        { axis = \"y\", value = 0.0 }",
    ),
];

/// A parsed case file with its overrides and what its preset fills in.
pub(super) struct Document<'a> {
    text: &'a str,
    root: Spanned<DeValue<'a>>,
    /// Where the key `preset` stands, if it filled anything in.
    preset: Option<usize>,
}

impl<'a> Document<'a> {
    /// The text with its overrides, each padded with newlines that set its spans apart from all
    /// others.
    pub(super) fn parse(file: &Path, text: &'a str, overrides: &'a [String]) -> Result<Self> {
        let mut document = Document::plain(file, text)?;
        for given in overrides {
            let given_as = given.trim_start().to_owned();
            document.set(given).map_err(|why| Error::Override { given: given_as, why })?;
        }
        document.preset = preset::fill(document.root.get_mut());
        Ok(document)
    }

    /// The text alone, of a case or of any other file of the program.
    pub(super) fn plain(file: &Path, text: &'a str) -> Result<Self> {
        let table = DeTable::parse(text).map_err(|e| {
            let at = e.span().map_or(text.len(), |span| span.start);
            let line = line_of(text.as_bytes(), at);
            whole_file(
                file,
                Some(line),
                format!("not valid TOML: {}", explain(text, line, e.message())),
            )
        })?;
        let root = Spanned::new(table.span(), DeValue::Table(table.into_inner()));
        Ok(Document { text, root, preset: None })
    }

    /// Applies one override `key.path=value`, or says what is wrong with it.
    fn set(&mut self, padded: &'a str) -> Result<(), String> {
        const FORM: &str = "the form is key.path=value, as in --set fluid.viscosity=2.0";
        let (key, value) = padded.split_once('=').ok_or_else(|| format!("no `=` in it; {FORM}"))?;
        let key = key.trim();
        let value = value.trim();
        let keys: Vec<_> = key.split('.').collect();
        if keys.iter().any(|key| {
            key.is_empty() || key.contains(|c: char| !c.is_ascii_alphanumeric() && c != '_')
        }) {
            return Err(format!("`{key}` is not a key; {FORM}"));
        }
        let patch = DeTable::parse(padded).map_err(|e| match value.chars().next() {
            None => format!("no value after the `=`; {FORM}"),
            Some('[' | '{' | '"' | '\'') => {
                format!("`{value}` is not a TOML value: {}", e.message())
            }
            _ => wrong_number(value)
                .map(|(why, right)| format!("`{value}` {why}: --set {key}={right}"))
                .unwrap_or_else(|| {
                    format!(
                        "`{value}` is not a TOML value; text needs quotes: --set \
                        '{key}=\"{value}\"'"
                    )
                }),
        })?;
        let patch = Spanned::new(patch.span(), DeValue::Table(patch.into_inner()));
        merge(&mut self.root, patch, &keys, 0, self.text.len())
    }

    /// The case that it describes, not yet checked.
    pub(super) fn to_case(&self) -> Result<Case, Fault> {
        self.refuse_gone(&GONE)?;
        self.to(&TABLES)
    }

    /// Refuses keys of earlier versions, each with its replacement.
    pub(super) fn refuse_gone(&self, gone: &[(&str, &str)]) -> Result<(), Fault> {
        for (path, instead) in gone {
            let keys: Vec<_> = path.split('.').collect();
            if let Some(key) = given(self.root.get_ref(), &keys) {
                return Err(Fault { key, message: (*instead).to_owned() });
            }
        }
        Ok(())
    }

    /// The value that it describes, not yet checked; `tables` are the keys that are tables.
    pub(super) fn to<T: DeserializeOwned>(&self, tables: &[&str]) -> Result<T, Fault> {
        // Serde would take a list for a table, its values in the order of the keys.
        let is_list = |key: &&&str| {
            self.root.get_ref().get(**key).is_some_and(|value| value.get_ref().is_array())
        };
        if let Some(key) = tables.iter().find(is_list) {
            return Err(Fault {
                key: key.to_string(),
                message: format!("found a list, wanted a table: write [{key}]"),
            });
        }
        T::deserialize(ValueDeserializer::from(self.root.clone())).map_err(|e| {
            let mut path = Vec::new();
            let node = e
                .span()
                .and_then(|span| find(&self.root, &span, &mut path))
                .unwrap_or(self.root.get_ref());
            reword(e.message(), path, node, choices)
        })
    }

    /// Notes on names that have changed since the file was written, a line each.
    pub(super) fn renamed(&self) -> Vec<String> {
        let Some(DeValue::Array(measures)) =
            self.root.get_ref().get("measure").map(Spanned::get_ref)
        else {
            return Vec::new();
        };
        let old = |(index, measure): (usize, &Spanned<DeValue>)| {
            let kind = measure.get_ref().get("kind")?.get_ref().as_str()?.to_owned();
            let (old, new) = MeasureKind::RENAMED.into_iter().find(|(old, _)| *old == kind)?;
            let line = self.place(&format!("measure.{index}.kind")).0;
            let line = line.map_or(String::new(), |line| format!("line {line}: "));
            Some(format!(
                "note         {line}measure.{index}.kind: \"{old}\" is called \"{new}\" now; the \
                old name goes with the next version"
            ))
        };
        measures.iter().enumerate().filter_map(old).collect()
    }

    /// The line of a key, or of its nearest ancestor in the file, and what gave it.
    pub(super) fn place(&self, key: &str) -> (Option<usize>, Given) {
        let mut node = &self.root;
        let mut at = None;
        for key in key.split('.') {
            let (start, next) = match node.get_ref() {
                DeValue::Table(table) => match table.get_key_value(key) {
                    Some((key, value)) if value.span().start <= self.text.len() => {
                        (key.span().start, value)
                    }
                    Some((_, value)) => (value.span().start, value),
                    None => break,
                },
                DeValue::Array(list) => match key.parse::<usize>().ok().and_then(|i| list.get(i)) {
                    Some(value) => (value.span().start, value),
                    None => break,
                },
                _ => break,
            };
            at = Some(start);
            node = next;
        }
        match at {
            Some(start) if start > self.text.len() => (None, Given::Set),
            Some(start) if Some(start) == self.preset && key != "preset" => {
                (Some(line_of(self.text.as_bytes(), start)), Given::Preset)
            }
            start => (start.map(|start| line_of(self.text.as_bytes(), start)), Given::File),
        }
    }
}

/// Puts the value that `patch` has at `keys[depth..]` into `node`, which is at `keys[..depth]`.
/// Spans beyond `end` are those of overrides.
fn merge<'a>(
    node: &mut Spanned<DeValue<'a>>,
    patch: Spanned<DeValue<'a>>,
    keys: &[&str],
    depth: usize,
    end: usize,
) -> Result<(), String> {
    let Some(key) = keys.get(depth) else {
        *node = patch;
        return Ok(());
    };
    let span = patch.span();
    let mut entries = match patch.into_inner() {
        DeValue::Table(table) => table.into_iter(),
        _ => DeTable::new().into_iter(),
    };
    let (Some((name, below)), None) = (entries.next(), entries.next()) else {
        return Err("it is not one override; give each its own --set".into());
    };
    if !matches!(node.get_ref(), DeValue::Array(_) | DeValue::Table(_)) {
        *node = Spanned::new(span, DeValue::Table(DeTable::new()));
    }
    let parent = keys[..depth].join(".");
    let next = match (node.get_mut(), key.parse::<usize>()) {
        (DeValue::Array(list), Ok(index)) => {
            let count = list.len();
            let why =
                format!("`{parent}` has no entry {index}: the case has {count}, counted from 0");
            list.get_mut(index).ok_or(why)?
        }
        (DeValue::Array(_), Err(_)) => {
            return Err(format!("`{parent}` is a list; say which entry, as in `{parent}.0.{key}`"));
        }
        (DeValue::Table(table), Err(_)) => {
            for (given, other) in REPLACES {
                if given == *key && table.get(other).is_some_and(|value| value.span().start <= end)
                {
                    table.remove(other);
                }
            }
            table
                .entry(name)
                .or_insert_with(|| Spanned::new(below.span(), DeValue::Table(DeTable::new())))
        }
        _ => {
            return Err(format!(
                "there is no `{}`, as that is not a list in this case",
                keys[..=depth].join(".")
            ));
        }
    };
    merge(next, below, keys, depth + 1, end)
}

/// Dotted path of a node's value at these keys; of a list, in its first entry that has one.
fn given(node: &DeValue, keys: &[&str]) -> Option<String> {
    let below = |own: &str, value: &Spanned<DeValue>, rest: &[&str]| {
        if rest.is_empty() {
            return Some(own.to_owned());
        }
        given(value.get_ref(), rest).map(|key| format!("{own}.{key}"))
    };
    match node {
        DeValue::Table(table) => {
            let (own, rest) = keys.split_first()?;
            below(own, table.get(*own)?, rest)
        }
        DeValue::Array(list) => {
            list.iter().enumerate().find_map(|(i, value)| below(&i.to_string(), value, keys))
        }
        _ => None,
    }
}

/// The deepest value that has this span, or whose key has, and the way to it.
fn find<'n, 'a>(
    node: &'n Spanned<DeValue<'a>>,
    span: &Range<usize>,
    path: &mut Vec<String>,
) -> Option<&'n DeValue<'a>> {
    let mut look = |key: String, key_span: Range<usize>, value: &'n Spanned<DeValue<'a>>| {
        path.push(key);
        let found = find(value, span, path).or((key_span == *span).then_some(value.get_ref()));
        if found.is_none() {
            path.pop();
        }
        found
    };
    let below = match node.get_ref() {
        DeValue::Table(table) => {
            table.iter().find_map(|(k, v)| look(k.get_ref().to_string(), k.span(), v))
        }
        DeValue::Array(list) => {
            list.iter().enumerate().find_map(|(i, v)| look(i.to_string(), v.span(), v))
        }
        _ => None,
    };
    below.or((node.span() == *span).then_some(node.get_ref()))
}

/// Fault of a value that was to be a number, and the number that was meant, if that is clear.
fn wrong_number(value: &str) -> Option<(&'static str, String)> {
    let number = |text: &str| text.parse::<f64>().is_ok();
    let point = value.replacen(',', ".", 1);
    if value.contains(',') && number(&point) {
        return Some(("has a comma where a number has a point", point));
    }
    let (first, unit) = value.split_once(char::is_whitespace).unwrap_or((value, ""));
    if number(first) && !unit.is_empty() {
        return Some(("has words behind the number, and units are fixed", first.to_owned()));
    }
    let bare = value.starts_with('.') || value.ends_with('.');
    (bare && number(value)).then(|| {
        (
            "needs a digit on both sides of its point",
            format!("{:?}", value.parse::<f64>().unwrap_or_default()),
        )
    })
}

/// Message of the parser on a line (from 1), with the key and the cure where these are plain from
/// the line.
fn explain(text: &str, line: usize, said: &str) -> String {
    let whole = text.lines().nth(line - 1).unwrap_or_default().trim();
    let (key, value) =
        whole.split_once('=').map_or((whole, ""), |(key, value)| (key.trim(), value.trim()));
    let value = value.split('#').next().unwrap_or_default().trim();
    if said.starts_with("duplicate key") {
        let bare = key.trim_matches(['[', ']']);
        let cure = if key.starts_with('[') {
            "the table is there before"
        } else {
            "the table has it before"
        };
        return format!("duplicate key `{bare}`: {cure}; keep one of them");
    }
    if let Some((why, right)) = wrong_number(value) {
        return format!("{key}: `{value}` {why}: {key} = {right}");
    }
    if whole.ends_with('=') {
        return format!("`{key}` has no value");
    }
    if !whole.contains('=') && !whole.starts_with('[') && said.contains("no value") {
        return format!("`{whole}` has no `=`: a line is key = value");
    }
    let bare = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if !value.is_empty()
        && value.chars().all(bare)
        && value.starts_with(|c: char| c.is_ascii_alphabetic())
    {
        return format!("{key}: text needs quotes: {key} = \"{value}\"");
    }
    if key.is_empty() || !whole.contains('=') { said.to_owned() } else { format!("{key}: {said}") }
}

/// The refusal of a file as a whole.
pub(super) fn whole_file(file: &Path, line: Option<usize>, message: impl Into<String>) -> Error {
    Error::Case {
        file: file.to_owned(),
        line,
        key: String::new(),
        message: message.into(),
        given: Given::File,
    }
}

/// The one-based line that byte `at` stands in.
pub(super) fn line_of(text: &[u8], at: usize) -> usize {
    1 + text[..at.min(text.len())].iter().filter(|byte| **byte == b'\n').count()
}
