//! Keys of a case that may change when a run goes on.

use super::read::{Loaded, written};
use crate::{Error, Result};
use toml::{Table, Value};

/// Keys that may change when a run goes on, beside further measures: its end, its output, and the
/// solution of the pressure equation.
const FREE: [&str; 4] = ["time.end", "output", "pressure", "petsc"];

/// Keys of a measure that may change: its reference, the tolerance and the source.
const COMPARED: [&str; 3] = ["reference", "tolerance", "source"];

/// Refuses to go on with a run whose case, as it was written out then, differs in more than a
/// restart may change.
///
/// # Errors
/// With the first key that differs and what it was.
pub fn refuse_changes(loaded: &Loaded, before: &str) -> Result<()> {
    // Resolved anew: a key that an older version did not write out had the value that it has by
    // default.
    let before =
        written(before).map_err(|why| Error::Usage(format!("its case cannot be read: {why}")))?;
    let [before, now] = [&before, &loaded.case].map(|case| case.to_toml().parse::<Table>());
    let table = |parsed: Result<Table, toml::de::Error>| {
        parsed.map_err(|e| Error::Usage(e.message().to_owned()))
    };
    let mut before = table(before)?;
    let mut now = table(now)?;
    let [old, new] = [&mut before, &mut now].map(take_measures);
    let before = Value::Table(before);
    let now = Value::Table(now);
    let changed = difference(&before, &now, String::new()).or_else(|| changed_measure(&old, &new));
    let Some((key, was)) = changed else {
        return Ok(());
    };
    let was = was.map_or("was not given".to_owned(), |was| format!("was {was}"));
    let why = format!(
        "{was} in the run to go on with; a restart may change {} only, and add measures of \
        other names",
        FREE.join(", ")
    );
    Err(loaded.error_at(&key, why + ": give the old value, or another --out for a run of its own"))
}

/// Takes the measures out of a case, without what they are compared with.
fn take_measures(case: &mut Table) -> Vec<Table> {
    let Some(Value::Array(measures)) = case.remove("measure") else { return Vec::new() };
    let tables = measures.into_iter().filter_map(|measure| {
        let Value::Table(mut measure) = measure else { return None };
        COMPARED.iter().for_each(|key| drop(measure.remove(*key)));
        Some(measure)
    });
    tables.collect()
}

/// The first key of a measure that differs from the measure of the same name before; measures of
/// other names have been added or removed.
fn changed_measure(before: &[Table], now: &[Table]) -> Option<(String, Option<String>)> {
    now.iter().enumerate().find_map(|(k, measure)| {
        let old = before.iter().find(|old| old.get("name") == measure.get("name"))?;
        difference(
            &Value::Table(old.clone()),
            &Value::Table(measure.clone()),
            format!("measure.{k}"),
        )
    })
}

/// The key of the first value that differs, and what it was; free keys aside.
fn difference(before: &Value, now: &Value, key: String) -> Option<(String, Option<String>)> {
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    if FREE.contains(&key.as_str()) {
        return None;
    }
    match (before, now) {
        (Value::Table(a), Value::Table(b)) => {
            let differs = |(name, was): (&String, &Value)| match b.get(name) {
                Some(is) => difference(was, is, below(name)),
                None => Some((below(name), Some(brief(was)))),
            };
            let more =
                || b.keys().find(|name| !a.contains_key(*name)).map(|name| (below(name), None));
            // The defaults of contacts follow from the particles: a changed particle is named
            // first.
            let derived = |(name, _): &(&String, &Value)| key.is_empty() && *name == "contact";
            let first = a.iter().filter(|entry| !derived(entry)).find_map(differs);
            first.or_else(|| a.iter().filter(derived).find_map(differs)).or_else(more)
        }
        (Value::Array(a), Value::Array(b))
            if a.len() == b.len() && a.iter().all(Value::is_table) =>
        {
            a.iter()
                .zip(b)
                .enumerate()
                .find_map(|(k, (a, b))| difference(a, b, below(&k.to_string())))
        }
        (a, b) => (a != b).then(|| (key, Some(brief(a)))),
    }
}

/// A value in a line.
fn brief(value: &Value) -> String {
    if let Value::Array(tables) = value
        && tables.iter().all(Value::is_table)
    {
        return format!("{} of them", tables.len());
    }
    let text = value.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    if text.chars().count() > 60 { "another".into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::super::load;
    use super::refuse_changes;

    const BOX: &str = "name = \"box\"\n[domain]\nsize = [2.0, 1.0]\ncells = [16, 8]\n[fluid]\n\
        density = 1.0\nviscosity = 0.1\n\
        [boundary]\nwest = \"wall\"\neast = \"wall\"\nsouth = \"wall\"\nnorth = \"wall\"\n[time]\n\
        end = 1.0\n\
        [[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.5, 0.5]\n";

    /// Why a run of the box may not go on with this override.
    fn refusal(given: &str) -> Option<String> {
        refusal_of(BOX, given)
    }

    /// Why a run of this case may not.
    fn refusal_of(case: &str, given: &str) -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("case.toml");
        std::fs::write(&file, case).unwrap();
        let before = load(&file, &[]).unwrap().case.to_toml();
        let loaded = load(&file, &[given.to_owned()]).unwrap();
        refuse_changes(&loaded, &before).err().map(|e| e.to_string())
    }

    #[test]
    fn restart_allows_changed_end_output_and_solver() {
        for given in [
            "time.end=2.0",
            "measure=[{ name = \"speed\", kind = \"largest_speed\" }]",
            "output.fields={ every = 3 }",
            "output.checkpoint.every_steps=7",
            "petsc.options=\"-ksp_type cg\"",
            "pressure.divergence_limit=1e-4",
        ] {
            assert_eq!(refusal(given), None);
        }
    }

    #[test]
    fn restart_refuses_other_changes_by_key() {
        for (given, key, was) in [
            ("fluid.viscosity=0.2", "fluid.viscosity", "was 0.1 in the run"),
            ("domain.cells=[32, 16]", "domain.cells", "was [16, 8] in the run"),
            ("particle.0.position=[0.6, 0.5]", "particle.0.position", "was [0.5, 0.5] in the run"),
            ("time.step=0.01", "time.cfl", "was 0.4 in the run"),
            ("particle=[]", "particle", "was 1 of them in the run"),
            ("contact.normal_stiffness=9.0", "contact", "was not given in the run"),
        ] {
            let why = refusal(given).unwrap();
            assert!(why.contains(&format!(": {key}: {was}")), "{given}: {why}");
            assert!(why.contains("may change time.end, output, pressure, petsc only"), "{why}");
        }
    }

    #[test]
    fn restart_names_changed_particle() {
        let why =
            refusal_of(&format!("{BOX}[contact]\n"), "particle.0.shape.disc.diameter=0.2").unwrap();
        assert!(why.contains(": particle.0.shape.disc.diameter: was 0.3 in the run"), "{why}");
    }
}
