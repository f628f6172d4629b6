//! Presets: keys that a case leaves out, filled in before it is read.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A named set of choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Preset {
    /// As the paper of 2003 prints it: `coupling.wall = "mixing"`, Euler steps with QSI, inviscid
    /// particles, (22) as printed.
    #[serde(rename = "mics-2003")]
    Mics2003,
}

/// Keys that `preset = "mics-2003"` fills into each table of these names.
const MICS_2003: &str = r#"
time = { scheme = "euler", advection = "qsi" }
contact = { tangential_damping = "printed" }
particle = { viscosity = 0.0 }
swarm = { viscosity = 0.0 }

[coupling]
wall = "mixing"
"#;

/// Fills in the keys that the preset of a case gives and the case does not, under the span of the
/// key `preset`; returns where that starts, `None` without a (known) preset.
pub(in crate::config) fn fill(case: &mut DeValue) -> Option<usize> {
    let DeValue::Table(case) = case else { return None };
    let (key, name) = case.get_key_value("preset")?;
    if name.get_ref().as_str() != Some("mics-2003") {
        return None;
    }
    let key = key.span();
    let value = name.span();
    let Ok(tables) = DeTable::parse(MICS_2003) else { return None };
    for (table, fills) in tables.into_inner() {
        let DeValue::Table(fills) = fills.into_inner() else { continue };
        // The one table that is never missing: it has no key that must be given.
        if table.get_ref() == "coupling" && !case.contains_key("coupling") {
            let name = Spanned::new(key.clone(), "coupling".into());
            case.insert(name, Spanned::new(value.clone(), DeValue::Table(DeTable::new())));
        }
        let targets: Vec<&mut DeTable> =
            match case.get_mut(table.get_ref().as_ref()).map(Spanned::get_mut) {
                Some(DeValue::Table(target)) => vec![target],
                Some(DeValue::Array(list)) => {
                    let tables = list.iter_mut().map(Spanned::get_mut);
                    tables
                        .filter_map(|entry| {
                            if let DeValue::Table(target) = entry { Some(target) } else { None }
                        })
                        .collect()
                }
                _ => Vec::new(),
            };
        for target in targets {
            for (name, fill) in &fills {
                if !target.contains_key(name.get_ref().as_ref()) {
                    let name = Spanned::new(key.clone(), name.get_ref().clone());
                    target.insert(name, Spanned::new(value.clone(), fill.get_ref().clone()));
                }
            }
        }
    }
    Some(key.start)
}

#[cfg(test)]
mod tests {
    use crate::config::*;

    fn loaded(dimension: usize, keys: &str, overrides: &[&str]) -> Case {
        let size = &[2.0, 1.0, 1.0][..dimension];
        let cells = &[16, 8, 8][..dimension];
        let lids = if dimension == 3 { "bottom = \"wall\"\ntop = \"wall\"" } else { "" };
        let text = format!(
            "name = \"box\"\npreset = \"mics-2003\"\n{keys}\n[time]\nend = 1.0\n\
            [domain]\nsize = {size:?}\ncells = {cells:?}\n[fluid]\ndensity = 1.0\n\
            viscosity = 0.1\n\
            [boundary]\nwest = \"wall\"\neast = \"wall\"\nsouth = \"wall\"\nnorth = \"wall\"\n\
            {lids}"
        );
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("case.toml");
        std::fs::write(&file, text).unwrap();
        let overrides: Vec<String> = overrides.iter().map(|given| given.to_string()).collect();
        let case = load(&file, &overrides).unwrap_or_else(|e| panic!("{e}")).case;
        std::fs::write(&file, case.to_toml()).unwrap();
        assert_eq!(load(&file, &[]).unwrap_or_else(|e| panic!("{e}")).case, case);
        case
    }

    #[test]
    fn preset_fills_missing_keys() {
        let disc = "{ shape = { disc = { diameter = 0.1 } }, position = [0.5, 0.5] }";
        let swarm =
            "{ count = 3, region = { min = [1.0, 0.0], max = [2.0, 1.0] }, diameter = 0.1 }";
        let contact = "contact = { normal_stiffness = 1e5 }";
        let case = loaded(2, &format!("particle = [{disc}]\nswarm = [{swarm}]\n{contact}"), &[]);
        assert_eq!((case.time.scheme(), case.time.advection), (Scheme::Euler, Advection::Qsi));
        assert_eq!(case.coupling.wall, WallRule::Mixture);
        assert_eq!(case.particle.len(), 4);
        assert!(case.particle.iter().all(|particle| particle.viscosity() == 0.0));
        assert_eq!(
            case.contact.map(|contact| contact.tangential_damping),
            Some(TangentialDamping::Printed)
        );
    }

    #[test]
    fn preset_keeps_given_keys_and_makes_no_table() {
        let disc =
            "{ shape = { disc = { diameter = 0.1 } }, position = [0.5, 0.5], viscosity = 3.0 }";
        let keys = format!("particle = [{disc}]");
        let case = loaded(2, &keys, &["time.advection=\"upwind5\""]);
        assert_eq!(
            (case.time.advection, case.time.length()),
            (Advection::Upwind5, Step::Courant(0.2))
        );
        assert_eq!((case.particle[0].viscosity(), case.contact), (3.0, None));
        assert_eq!((case.coupling.wall, case.preset), (WallRule::Mixture, Some(Preset::Mics2003)));
    }
}
