//! The way from a TOML file and `--set` overrides to a checked [`Case`], and back; the JSON Schema
//! of a case.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::de::DeserializeOwned;

use super::begin::begin;
use super::contact::pairs;
use super::document::{Document, line_of, whole_file};
use super::fault::Fault;
use super::fill::fill;
use super::obstacle::off_walls;
use super::swarm::expand;
use super::validate::{measures, name_particles, validate};
use super::{Case, Particle, obstacle, over_time, shape};
use crate::error::Given;
use crate::{Error, Result};

/// A case as it was read, and from where.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The case, checked, every default filled in.
    pub case: Case,
    /// The case file as the user named it.
    pub file: PathBuf,
    /// Notes on the file and those that it names, a line each.
    pub notes: Vec<String>,
    text: String,
    overrides: Vec<String>,
}

impl Loaded {
    /// The refusal of a key, with its line, by a check that comes after reading: a step over the
    /// limit, say.
    pub fn error_at(&self, key: &str, message: impl Into<String>) -> Error {
        let document = Document::parse(&self.file, &self.text, &self.overrides);
        let (line, given) = document.map_or((None, Given::File), |document| document.place(key));
        Error::Case {
            file: self.file.clone(),
            line,
            key: key.to_owned(),
            message: message.into(),
            given,
        }
    }
}

/// Keys that define the flow: with overrides of these a reference of the file no longer holds.
const FLOW: [&str; 9] = [
    "domain.size",
    "fluid",
    "boundary",
    "particle",
    "swarm",
    "obstacle",
    "initial",
    "drive",
    "contact",
];

/// Drops the references of the file where overrides change its flow, unless they give others.
fn drop_references(case: &mut Case, overrides: &[String]) {
    let keys = || overrides.iter().map(|given| given.split('=').next().unwrap_or_default().trim());
    let within = |key: &str, table: &str| {
        key.strip_prefix(table).is_some_and(|r| r.is_empty() || r.starts_with('.'))
    };
    if !keys().any(|key| FLOW.iter().any(|table| within(key, table) || within(table, key)))
        || keys().any(|key| key == "measure")
    {
        return;
    }
    for (index, measure) in case.measure.iter_mut().enumerate() {
        if !keys().any(|key| {
            key == format!("measure.{index}") || key == format!("measure.{index}.reference")
        }) {
            measure.reference = None;
            measure.tolerance = None;
            measure.source = None;
        }
    }
}

/// Reads, overrides and checks a case, and turns its swarms into particles; `overrides` are
/// `key.path=value` with TOML syntax for the value. A refusal is one [`Error::Case`] that names the
/// key and its line, or says what else gave it.
pub fn load(path: &Path, overrides: &[String]) -> Result<Loaded> {
    let text = read(path, "case")?;
    let mut end = text.len() + 1;
    let pad = |given: &String| {
        let padded = "\n".repeat(end) + given;
        end = padded.len();
        padded
    };
    let overrides: Vec<String> = overrides.iter().map(pad).collect();
    let document = Document::parse(path, &text, &overrides)?;
    let (case, said) = checked(&document, path, &overrides).map_err(|Fault { key, message }| {
        let (line, given) = document.place(&key);
        Error::Case { file: path.to_owned(), line, key, message, given }
    })?;
    let notes = [document.renamed(), said].concat();
    Ok(Loaded { case, file: path.to_owned(), notes, text, overrides })
}

/// The case that a document of the file `path` describes, its swarms turned into particles, checked
/// and filled in, and notes on the files that it names.
fn checked(
    document: &Document,
    path: &Path,
    overrides: &[String],
) -> Result<(Case, Vec<String>), Fault> {
    let mut case = document.to_case()?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut said = shape::build(&mut case, folder)?;
    over_time::build(&mut case, folder)?;
    validate(&case)?;
    said.extend(obstacle::build(&mut case, folder)?);
    begin(&mut case, folder, read_bodies)?;
    expand(&mut case, folder, read_bodies)?;
    off_walls(&case)?;
    name_particles(&mut case)?;
    pairs(&case)?;
    measures(&case)?;
    drop_references(&mut case, overrides);
    fill(&mut case)?;
    Ok((case, said))
}

/// The case that a run wrote out, from its text.
///
/// # Errors
/// With the key, and what is wrong with it.
pub fn written(text: &str) -> Result<Case, String> {
    let document = Document::plain(Path::new("case.toml"), text).map_err(|e| e.to_string())?;
    checked(&document, Path::new(""), &[])
        .map(|(case, _)| case)
        .map_err(|Fault { key, message }| format!("{key}: {message}"))
}

/// A case from the text of a case file. Files that it names are found from the present folder.
impl FromStr for Case {
    type Err = Error;

    fn from_str(text: &str) -> Result<Case> {
        written(text).map_err(Error::Usage)
    }
}

/// The dimension and the bodies of the case that a run wrote out, from its text.
fn read_bodies(text: &str) -> Result<(usize, Vec<Particle>), String> {
    let case = written(text)?;
    Ok((case.dimension(), case.particle))
}

/// The text of another TOML file of the program's, read and refused with the manners of a case.
#[derive(Clone, Debug)]
pub struct Text {
    /// The file as the user named it.
    pub file: PathBuf,
    text: String,
}

impl Text {
    /// Reads a file that a message calls a `kind` file.
    pub fn read(file: &Path, kind: &str) -> Result<Text> {
        Ok(Text { file: file.to_owned(), text: read(file, kind)? })
    }

    /// A file whose text is known.
    pub fn new(file: &Path, text: &str) -> Text {
        Text { file: file.to_owned(), text: text.to_owned() }
    }

    /// The value that it describes; `tables` are the keys at its top that are tables, `gone` keys
    /// of earlier versions, each with its replacement.
    pub fn to<T: DeserializeOwned>(&self, tables: &[&str], gone: &[(&str, &str)]) -> Result<T> {
        let document = Document::plain(&self.file, &self.text)?;
        let value = document.refuse_gone(gone).and_then(|()| document.to(tables));
        value.map_err(|fault| self.refuse(fault))
    }

    /// The refusal of a key, with its line.
    pub fn refuse(&self, Fault { key, message }: Fault) -> Error {
        let document = Document::plain(&self.file, &self.text);
        let line = document.ok().and_then(|document| document.place(&key).0);
        Error::Case { file: self.file.clone(), line, key, message, given: Given::File }
    }

    /// The text as it was read.
    pub fn as_str(&self) -> &str {
        &self.text
    }
}

/// The text of a file that a message calls a `kind` file.
fn read(file: &Path, kind: &str) -> Result<String> {
    if file.is_dir() {
        return Err(whole_file(
            file,
            None,
            format!("this is a directory; name the {kind} file in it (a .toml file)"),
        ));
    }
    let bytes = std::fs::read(file).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => whole_file(
            file,
            None,
            format!("there is no such file; check the path of the {kind} file"),
        ),
        _ => whole_file(file, None, format!("cannot be read: {e}")),
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let line = line_of(e.as_bytes(), e.utf8_error().valid_up_to());
        whole_file(file, Some(line), format!("not UTF-8 text; save the {kind} file as UTF-8"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Motion, Oscillation, Prescribed, Reference, Side, Spin, Step, schema};

    const CHANNEL: &str = r#"name = "channel"
[domain]
size = [2, 1.0]
cells = [32, 16]
[fluid]
density = 1000
viscosity = 2.0
[boundary]
west = { inflow_profile = { at = [0.0, 0.4, 1.0], velocity = [[0, 0], [2, 0], [1, 0]] } }
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

    /// Origin of the key that is refused.
    fn given_by(text: &str, overrides: &[&str]) -> Given {
        match load_text(text, overrides) {
            Err(Error::Case { given, .. }) => given,
            other => panic!("expected a refusal of the case, got {other:?}"),
        }
    }

    fn usage(overrides: &[&str]) -> String {
        match load_text(CHANNEL, overrides) {
            Err(e @ Error::Override { .. }) => e.to_string(),
            other => panic!("expected a refusal of the override, got {other:?}"),
        }
    }

    #[test]
    fn written_case_round_trip_with_defaults() {
        let case = load_text(CHANNEL, &[]).unwrap();
        assert_eq!(load_text(&case.to_toml(), &[]).unwrap(), case);
        assert_eq!(case.fluid.gravity, [0.0, 0.0]);
        assert_eq!(case.particle[0].density(), 1000.0);
        let middle = case.initial.velocity[0];
        assert!((middle - 11.0 / 6.0).abs() < 1e-12, "the inflow's at the middle: {middle}");
        assert_eq!(case.measure[0].speed, Some(2.0));
        let spin = Some(Spin::Plane(0.0));
        let told = Prescribed { velocity: vec![0.0, 1.0], spin, oscillation: None };
        assert_eq!(case.particle[0].motion, Motion::Prescribed(told));
    }

    #[test]
    fn oscillation_round_trip_and_schema() {
        let swing =
            "particle.0.motion.prescribed.oscillation={ amplitude = [0.1, 0], frequency = 2 }";
        let case = load_text(CHANNEL, &[swing]).unwrap();
        assert_eq!(load_text(&case.to_toml(), &[]).unwrap(), case);
        let oscillation = Some(Oscillation { amplitude: vec![0.1, 0.0], frequency: 2.0 });
        let Motion::Prescribed(told) = &case.particle[0].motion else { panic!() };
        assert_eq!(told.oscillation, oscillation);
        let schema = schema();
        for (table, key) in [
            ("Prescribed", "oscillation"),
            ("Oscillation", "amplitude"),
            ("Oscillation", "frequency"),
        ] {
            assert!(schema["$defs"][table]["properties"][key].is_object(), "{table}.{key}");
        }
    }

    #[test]
    fn overrides_replace_create_and_index_lists() {
        let overrides = [
            "particle.0.density=1200",
            "domain.cells=[64, 32]",
            " domain.size.0 = 4 ",
            "petsc.options=\"-ksp_type cg\"",
            "boundary.north.moving_wall=[3, 0]",
            "particle.0.motion='fixed'",
        ];
        let case = load_text(CHANNEL, &overrides).unwrap();
        assert_eq!(case.particle[0].density(), 1200.0);
        assert_eq!((case.domain.size, case.domain.cells), (vec![4.0, 1.0], vec![64, 32]));
        assert_eq!(case.petsc.options, "-ksp_type cg");
        assert_eq!(case.boundary.north, Side::MovingWall(vec![3.0, 0.0]));
        assert_eq!(case.particle[0].motion, Motion::Fixed);
    }

    #[test]
    fn override_drops_alternative_key_of_file() {
        let case = load_text(CHANNEL, &["time.step=0.01"]).unwrap();
        assert_eq!(case.time.length(), Step::Fixed(0.01));
        let (line, key, message) = refusal(CHANNEL, &["time.cfl=0.2", "time.step=0.01"]);
        assert_eq!((line, key.as_str()), (None, "time.step"));
        assert!(message.contains("exclude each other"), "{message}");
    }

    #[test]
    fn override_of_flow_drops_reference() {
        let text = CHANNEL.to_owned() + "reference = 2.0\ntolerance = 0.1\nsource = \"a book\"\n";
        let left = |overrides: &[&str]| load_text(&text, overrides).unwrap().measure[0].reference;
        let kept = Some(Reference::Value(2.0));
        for same in [&[][..], &["domain.cells=[64, 32]"], &["time.cfl=0.2", "measure.0.particle=0"]]
        {
            assert_eq!(left(same), kept, "{same:?}");
        }
        for other in ["fluid.viscosity=1.0", "domain.size=[2.0, 2.0]", "particle.0.density=2.0"] {
            assert_eq!(left(&[other]), None, "{other}");
            assert_eq!(
                left(&[other, "measure.0.reference=[3.0, 4.0]"]),
                Some(Reference::Band([3.0, 4.0]))
            );
        }
    }

    #[test]
    fn message_of_set_value_has_no_line() {
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
            assert_eq!(given_by(CHANNEL, &["fluid.density=2", given]), Given::Set, "{message}");
        }
    }

    #[test]
    fn message_line_of_key_or_nearest_ancestor() {
        for (from, to, expected_line, expected_key) in [
            ("            0.5]", "nan]", 16, "particle.0.position.1"),
            ("position = [0.5,\n            0.5]", "", 13, "particle.0.position"),
            ("shape.disc.diameter", "shape.disc.diametr", 14, "particle.0.shape.disc.diametr"),
            (
                "velocity = [0.0, 1.0]",
                "velocity = [0.0]",
                18,
                "particle.0.motion.prescribed.velocity",
            ),
            ("end = 1", "", 19, "time.end"),
        ] {
            assert!(CHANNEL.contains(from), "{from}");
            let (line, key, message) = refusal(&CHANNEL.replacen(from, to, 1), &[]);
            assert_eq!((line, key.as_str()), (Some(expected_line), expected_key), "{message}");
        }
    }

    #[test]
    fn bad_override_is_usage_error() {
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
    fn late_validation_error_has_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("case.toml");
        std::fs::write(&file, CHANNEL).unwrap();
        let loaded = load(&file, &["time.end=2".into()]).unwrap();
        let message = |key| loaded.error_at(key, "no").to_string();
        assert!(
            message("time.cfl").ends_with("case.toml:21: time.cfl: no"),
            "{}",
            message("time.cfl")
        );
        assert!(
            message("time.end").ends_with("case.toml: time.end: no (given by --set)"),
            "{}",
            message("time.end")
        );
    }

    #[test]
    fn schema_has_every_table() {
        let schema = schema();
        for table in ["domain", "fluid", "boundary", "particle", "time", "measure", "output"] {
            assert!(schema["properties"][table].is_object(), "{table}");
        }
    }
}
