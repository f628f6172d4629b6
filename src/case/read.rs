//! The way from a TOML file and `--set` overrides to a checked [`Case`], and back: places (file, line, key) of errors,
//! unknown keys and their nearest known ones, the JSON Schema, the case written out.
//!
//! Overrides are put into the parsed document under spans beyond the end of the text, so that one walk over the
//! document tells both where a key stands and whether `--set` gave it.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::Case;
use super::validate::{Fault, validate};
use crate::{Error, Result};

/// Keys that exclude each other: overriding the first drops the second from the file.
const REPLACES: [(&str, &str); 4] =
    [("step", "cfl"), ("cfl", "step"), ("every", "every_time"), ("every_time", "every")];

/// The keys of a case that are tables.
const TABLES: [&str; 9] = ["domain", "fluid", "boundary", "initial", "coupling", "time", "pressure", "petsc", "output"];

/// A case as it was read, and from where.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The case, checked, every default filled in.
    pub case: Case,
    /// The case file as the user named it.
    pub file: PathBuf,
    text: String,
    overrides: Vec<String>,
}

impl Loaded {
    /// The refusal of a key, with its line, by what comes after reading: a step over the limit, say.
    pub fn error_at(&self, key: &str, message: impl Into<String>) -> Error {
        let (line, note) = match Document::parse(&self.file, &self.text, &self.overrides) {
            Ok(document) => document.place(key),
            Err(_) => (None, ""),
        };
        Error::Case { file: self.file.clone(), line, key: key.to_owned(), message: message.into() + note }
    }
}

/// Reads, overrides and checks a case; `overrides` are `key.path=value` with TOML syntax for the value.
/// A refusal is one [`Error::Case`] that names the key and its line, or says that `--set` gave it.
pub fn load(path: &Path, overrides: &[String]) -> Result<Loaded> {
    let text = read(path)?;
    let mut end = text.len() + 1;
    let pad = |given: &String| {
        let padded = "\n".repeat(end) + given;
        end = padded.len();
        padded
    };
    let overrides: Vec<String> = overrides.iter().map(pad).collect();
    let document = Document::parse(path, &text, &overrides)?;
    let mut case =
        document.to_case().and_then(|case| validate(&case).map(|()| case)).map_err(|Fault { key, message }| {
            let (line, note) = document.place(&key);
            Error::Case { file: path.to_owned(), line, key, message: message + note }
        })?;
    case.fill_defaults();
    Ok(Loaded { case, file: path.to_owned(), text, overrides })
}

/// The JSON Schema of a case, for editors.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Case).to_value()
}

impl Case {
    /// The case as TOML, every default filled in; it reads back to an equal case.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("numbers, texts, lists and tables with text keys are TOML")
    }
}

/// The refusal of a file as a whole.
fn whole_file(file: &Path, line: Option<usize>, message: impl Into<String>) -> Error {
    Error::Case { file: file.to_owned(), line, key: String::new(), message: message.into() }
}

/// The text of a case file.
fn read(file: &Path) -> Result<String> {
    if file.is_dir() {
        return Err(whole_file(file, None, "this is a directory; name the case file in it (a .toml file)"));
    }
    let bytes = std::fs::read(file).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => {
            whole_file(file, None, "there is no such file; check the path of the case file")
        }
        _ => whole_file(file, None, format!("cannot be read: {e}")),
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let line = line_of(e.as_bytes(), e.utf8_error().valid_up_to());
        whole_file(file, Some(line), "not UTF-8 text; save the case file as UTF-8")
    })
}

/// The one-based line that byte `at` stands in.
fn line_of(text: &[u8], at: usize) -> usize {
    1 + text[..at.min(text.len())].iter().filter(|byte| **byte == b'\n').count()
}

/// A parsed case file with its overrides.
struct Document<'a> {
    text: &'a str,
    root: Spanned<DeValue<'a>>,
}

impl<'a> Document<'a> {
    /// The text with its overrides, each padded with newlines that set its spans apart from all others.
    fn parse(file: &Path, text: &'a str, overrides: &'a [String]) -> Result<Self> {
        let table = DeTable::parse(text).map_err(|e| {
            let at = e.span().map_or(text.len(), |span| span.start);
            whole_file(file, Some(line_of(text.as_bytes(), at)), format!("not valid TOML: {}", e.message()))
        })?;
        let root = Spanned::new(table.span(), DeValue::Table(table.into_inner()));
        let mut document = Document { text, root };
        for given in overrides {
            let why = |why| Error::Usage(format!("bad --set `{}`: {why}", given.trim_start()));
            document.set(given).map_err(why)?;
        }
        Ok(document)
    }

    /// Applies one override `key.path=value`, or says what is wrong with it.
    fn set(&mut self, padded: &'a str) -> Result<(), String> {
        const FORM: &str = "the form is key.path=value, as in --set fluid.viscosity=2.0";
        let (key, value) = padded.split_once('=').ok_or_else(|| format!("no `=` in it; {FORM}"))?;
        let (key, value) = (key.trim(), value.trim());
        let keys: Vec<_> = key.split('.').collect();
        if keys.iter().any(|key| key.is_empty() || key.contains(|c: char| !c.is_ascii_alphanumeric() && c != '_')) {
            return Err(format!("`{key}` is not a key; {FORM}"));
        }
        let patch = DeTable::parse(padded).map_err(|e| match value.chars().next() {
            None => format!("no value after the `=`; {FORM}"),
            Some('[' | '{' | '"' | '\'') => format!("`{value}` is not a TOML value: {}", e.message()),
            _ => format!("`{value}` is not a TOML value; text needs quotes: --set '{key}=\"{value}\"'"),
        })?;
        let patch = Spanned::new(patch.span(), DeValue::Table(patch.into_inner()));
        merge(&mut self.root, patch, &keys, 0, self.text.len())
    }

    fn to_case(&self) -> Result<Case, Fault> {
        // Serde would take a list for a table, its values in the order of the keys.
        let is_list = |key: &&&str| self.root.get_ref().get(**key).is_some_and(|value| value.get_ref().is_array());
        if let Some(key) = TABLES.iter().find(is_list) {
            return Err(Fault {
                key: key.to_string(),
                message: format!("found a list, wanted a table: write [{key}]"),
            });
        }
        Case::deserialize(ValueDeserializer::from(self.root.clone())).map_err(|e| {
            let mut path = Vec::new();
            let node = e.span().and_then(|span| find(&self.root, &span, &mut path)).unwrap_or(self.root.get_ref());
            reword(e.message(), path, node)
        })
    }

    /// The line of a key, or of its nearest ancestor in the file, and what to add to a message if `--set` gave it.
    fn place(&self, key: &str) -> (Option<usize>, &'static str) {
        let mut node = &self.root;
        let mut at = None;
        for key in key.split('.') {
            let (start, next) = match node.get_ref() {
                DeValue::Table(table) => match table.get_key_value(key) {
                    Some((key, value)) if value.span().start <= self.text.len() => (key.span().start, value),
                    Some((_, value)) => (value.span().start, value),
                    None => break,
                },
                DeValue::Array(list) => match key.parse::<usize>().ok().and_then(|i| list.get(i)) {
                    Some(value) => (value.span().start, value),
                    None => break,
                },
                _ => break,
            };
            (at, node) = (Some(start), next);
        }
        match at {
            Some(start) if start > self.text.len() => (None, " (given by --set)"),
            start => (start.map(|start| line_of(self.text.as_bytes(), start)), ""),
        }
    }
}

/// Puts what `patch` has at `keys[depth..]` into `node`, which is at `keys[..depth]`. Spans beyond `end` are overrides'.
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
            let why = format!("`{parent}` has no entry {index}: the case has {count}, counted from 0");
            list.get_mut(index).ok_or(why)?
        }
        (DeValue::Array(_), Err(_)) => {
            return Err(format!("`{parent}` is a list; say which entry, as in `{parent}.0.{key}`"));
        }
        (DeValue::Table(table), Err(_)) => {
            for (given, other) in REPLACES {
                if given == *key && table.get(other).is_some_and(|value| value.span().start <= end) {
                    table.remove(other);
                }
            }
            table.entry(name).or_insert_with(|| Spanned::new(below.span(), DeValue::Table(DeTable::new())))
        }
        _ => return Err(format!("there is no `{}`, as that is not a list in this case", keys[..=depth].join("."))),
    };
    merge(next, below, keys, depth + 1, end)
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
        DeValue::Table(table) => table.iter().find_map(|(k, v)| look(k.get_ref().to_string(), k.span(), v)),
        DeValue::Array(list) => list.iter().enumerate().find_map(|(i, v)| look(i.to_string(), v.span(), v)),
        _ => None,
    };
    below.or((node.span() == *span).then_some(node.get_ref()))
}

/// What the deserialiser says, in the user's words: the key and what would be right.
fn reword(raw: &str, mut path: Vec<String>, node: &DeValue) -> Fault {
    let mut quoted = raw.split('`').skip(1).step_by(2);
    let last = path.last().cloned().unwrap_or_default();
    let message = if raw.starts_with("unknown ") {
        let what = if raw.starts_with("unknown field") { "key" } else { "value" };
        let unknown = quoted.next().unwrap_or_default();
        format!("unknown {what} `{unknown}`; {}", suggest(unknown, &quoted.collect::<Vec<_>>()))
    } else if raw.starts_with("missing field") {
        let missing = quoted.next().unwrap_or_default();
        let table = path.join(".");
        path.push(missing.to_owned());
        match table.as_str() {
            "" => format!("missing key `{missing}` at the top level of the case"),
            table => format!("missing key `{missing}` in [{table}]"),
        }
    } else if let (true, DeValue::String(name)) = (raw.contains("expected newtype variant"), node) {
        format!("`{name}` needs its value: write {{ {name} = ... }} instead of \"{name}\"")
    } else if raw.starts_with("expected empty") || raw.starts_with("expected table, found") {
        format!("`{last}` takes no value: write \"{last}\" instead of {{ {last} = ... }}")
    } else if raw.starts_with("wanted string or table") {
        format!("found {}, wanted a name in quotes or {{ name = ... }}", describe(node))
    } else if let (true, DeValue::Table(table)) = (raw.starts_with("wanted exactly 1 element"), node) {
        let keys: Vec<_> = table.keys().map(|key| format!("`{}`", key.get_ref())).collect();
        let found = if keys.is_empty() { "none".into() } else { keys.join(" and ") };
        format!("found {found}, wanted exactly one, as in {{ name = ... }}")
    } else if let Some((_, wanted)) = raw.split_once(", expected ") {
        let wanted = match wanted {
            "f64" => "a number",
            "usize" | "u64" => "a whole number, 0 or more",
            "a string" => "text in quotes",
            "a boolean" => "true or false",
            "a sequence" if matches!(node, DeValue::Table(_)) => &format!("a list: begin each entry with [[{last}]]"),
            "a sequence" => "a list in [ ]",
            other if other.starts_with("struct") => "a table of keys",
            other => other,
        };
        format!("found {}, wanted {wanted}", describe(node))
    } else {
        raw.to_owned()
    };
    Fault { key: path.join("."), message }
}

/// The known name that was probably meant, or all of them.
fn suggest(unknown: &str, known: &[&str]) -> String {
    let likeness = |name: &str| strsim::jaro_winkler(&unknown.to_lowercase(), name);
    match known.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b))) {
        Some(name) if likeness(name) > 0.8 => format!("did you mean `{name}`?"),
        _ => format!("known here: {}", known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")),
    }
}

/// A value as an error message names it.
fn describe(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("the text \"{text}\""),
        DeValue::Integer(number) => format!("the number {number}"),
        DeValue::Float(number) => format!("the number {number}"),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(_) => "a list".into(),
        DeValue::Table(_) => "a table".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Motion, Side, Spin};

    const CHANNEL: &str = r#"name = "channel"
[domain]
size = [2, 1.0]
cells = [32, 16]
[fluid]
density = 1000
viscosity = 2.0
[boundary]
west = { inflow_profile = { at = [0.0, 0.4, 1.0], velocity = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.0]] } }
east = "outflow"
south = { moving_wall = [1.0, 0.0] }
north = "wall"
[[particle]]
shape.disc.diameter = 0.2
position = [0.5,
            0.5]
[particle.motion.prescribed]
velocity = [0.0, 1.0]
[time]
end = 1
cfl = 0.3
[[measure]]
name = "drag"
kind = "drag_coefficient"
"#;

    fn load_text(text: &str, overrides: &[&str]) -> Result<Case> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("case.toml");
        std::fs::write(&file, text).unwrap();
        let overrides: Vec<String> = overrides.iter().map(|given| given.to_string()).collect();
        load(&file, &overrides).map(|loaded| loaded.case)
    }

    /// Line, key and message of the refusal of the channel with these overrides.
    fn refusal(text: &str, overrides: &[&str]) -> (Option<usize>, String, String) {
        match load_text(text, overrides) {
            Err(Error::Case { line, key, message, .. }) => (line, key, message),
            other => panic!("expected a refusal of the case, got {other:?}"),
        }
    }

    fn usage(overrides: &[&str]) -> String {
        match load_text(CHANNEL, overrides) {
            Err(Error::Usage(message)) => message,
            other => panic!("expected a refusal of the override, got {other:?}"),
        }
    }

    #[test]
    fn a_case_written_out_reads_back_equal_and_says_every_default() {
        let case = load_text(CHANNEL, &[]).unwrap();
        assert_eq!(load_text(&case.to_toml(), &[]).unwrap(), case);
        assert_eq!(case.fluid.gravity, Some(vec![0.0, 0.0]));
        assert_eq!(case.particle[0].density, Some(1000.0));
        assert_eq!(case.initial.velocity, Some(vec![2.0, 0.0]), "the inflow's, at the middle of its face");
        assert_eq!(case.measure[0].speed, Some(2.0));
        let Motion::Prescribed(motion) = &case.particle[0].motion else { panic!("{:?}", case.particle[0].motion) };
        assert_eq!(motion.spin, Some(Spin::Plane(0.0)));
    }

    #[test]
    fn overrides_replace_make_and_reach_into_lists() {
        let overrides = [
            "particle.0.density=1200",
            "domain.cells=[64, 32]",
            " domain.size.0 = 4 ",
            "petsc.options=\"-ksp_type cg\"",
            "boundary.north.moving_wall=[3, 0]",
            "particle.0.motion='fixed'",
        ];
        let case = load_text(CHANNEL, &overrides).unwrap();
        assert_eq!(case.particle[0].density, Some(1200.0));
        assert_eq!((case.domain.size, case.domain.cells), (vec![4.0, 1.0], vec![64, 32]));
        assert_eq!(case.petsc.options, "-ksp_type cg");
        assert_eq!(case.boundary.north, Side::MovingWall(vec![3.0, 0.0]));
        assert_eq!(case.particle[0].motion, Motion::Fixed);
    }

    #[test]
    fn an_override_drops_the_alternative_that_the_file_has_but_not_one_given_with_it() {
        let case = load_text(CHANNEL, &["time.step=0.01"]).unwrap();
        assert_eq!((case.time.step, case.time.cfl), (Some(0.01), None));
        let (line, key, message) = refusal(CHANNEL, &["time.cfl=0.2", "time.step=0.01"]);
        assert_eq!((line, key.as_str()), (None, "time.step"));
        assert!(message.contains("exclude each other"), "{message}");
    }

    #[test]
    fn a_value_given_by_set_has_no_line_and_says_so() {
        for (given, key) in [
            ("fluid.viscosity=-1", "fluid.viscosity"),
            ("fluid.viscosity=\"high\"", "fluid.viscosity"),
            ("fluid.viscosty=1", "fluid.viscosty"),
            ("domain.cells=[32, 1.5]", "domain.cells.1"),
            ("particle.0.position.1=nan", "particle.0.position.1"),
            ("particle.0.shape={ disc = {} }", "particle.0.shape.disc.diameter"),
        ] {
            let (line, found, message) = refusal(CHANNEL, &["fluid.density=2", given]);
            assert_eq!((line, found.as_str()), (None, key), "{message}");
            assert!(message.ends_with(" (given by --set)"), "{message}");
        }
    }

    #[test]
    fn the_line_is_that_of_the_key_or_of_its_nearest_ancestor() {
        for (from, to, expected_line, expected_key) in [
            ("            0.5]", "nan]", 16, "particle.0.position.1"),
            ("[particle.motion.prescribed]\nvelocity = [0.0, 1.0]\n", "", 13, "particle.0.motion"),
            ("position = [0.5,\n            0.5]", "", 13, "particle.0.position"),
            ("shape.disc.diameter", "shape.disc.diametr", 14, "particle.0.shape.disc.diametr"),
            ("velocity = [0.0, 1.0]", "velocity = [0.0]", 18, "particle.0.motion.prescribed.velocity"),
            ("end = 1", "", 19, "time.end"),
        ] {
            assert!(CHANNEL.contains(from), "{from}");
            let (line, key, message) = refusal(&CHANNEL.replacen(from, to, 1), &[]);
            assert_eq!((line, key.as_str()), (Some(expected_line), expected_key), "{message}");
        }
    }

    #[test]
    fn a_bad_override_is_a_usage_error_with_the_right_form() {
        for (given, cure) in [
            ("fluid.viscosity", "key.path=value"),
            ("=2", "key.path=value"),
            ("fluid..viscosity=2", "key.path=value"),
            ("fluid.viscosity=", "no value"),
            ("time.scheme=euler", r#"--set 'time.scheme="euler"'"#),
            ("domain.cells=[3", "unclosed array"),
            ("particle.7.density=1", "`particle` has no entry 7: the case has 1"),
            ("particle.density=1", "`particle.0.density`"),
            ("swarm.0.count=1", "there is no `swarm.0`"),
            ("time.end=1\ntime.step=2", "each its own --set"),
        ] {
            let message = usage(&[given]);
            assert!(message.contains(given) && message.contains(cure), "{message}");
        }
    }

    #[test]
    fn what_is_found_wrong_later_is_refused_at_its_line_too() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("case.toml");
        std::fs::write(&file, CHANNEL).unwrap();
        let loaded = load(&file, &["time.end=2".into()]).unwrap();
        let message = |key| loaded.error_at(key, "no").to_string();
        assert!(message("time.cfl").ends_with("case.toml:21: time.cfl: no"), "{}", message("time.cfl"));
        assert!(message("time.end").ends_with("case.toml: time.end: no (given by --set)"), "{}", message("time.end"));
    }

    #[test]
    fn the_schema_knows_every_table_of_a_case() {
        let schema = schema();
        for table in ["domain", "fluid", "boundary", "particle", "time", "measure", "output"] {
            assert!(schema["properties"][table].is_object(), "{table}");
        }
    }
}
