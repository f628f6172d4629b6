//! Presets: keys that a case leaves out, filled in before it is read.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A named set of choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Preset {
    /// As the paper of 2003 prints it: Euler steps with QSI, polygon fractions in 2D, force by (19), the third term of
    /// (27) in boundary cells only, (28-29), buoyancy in (17) only, (16) at cells, inviscid particles, (22) as printed.
    #[serde(rename = "mics-2003")]
    Mics2003,
}

/// What `preset = "mics-2003"` fills into each table of these names.
const MICS_2003: &str = r#"
time = { scheme = "euler", advection = "qsi" }
coupling = { fraction = "polygon", force = "literal", rotation = "boundary", mix_pressure = true, buoyancy = "particle", gradient = "cells" }
contact = { tangential_damping = "printed" }
particle = { viscosity = 0.0 }
swarm = { viscosity = 0.0 }
"#;

/// Fills in what the preset of a case says and the case does not, under the span of its key; returns where that starts,
/// `None` without a (known) preset.
pub(super) fn fill(case: &mut DeValue) -> Option<usize> {
    let DeValue::Table(case) = case else { return None };
    let (key, name) = case.get_key_value("preset")?;
    if name.get_ref().as_str() != Some("mics-2003") {
        return None;
    }
    let (key, value) = (key.span(), name.span());
    let planar = case.get("domain").and_then(|domain| domain.get_ref().get("size")).and_then(|size| {
        let DeValue::Array(size) = size.get_ref() else { return None };
        Some(size.len() == 2)
    });
    let Ok(tables) = DeTable::parse(MICS_2003) else { return None };
    for (table, fills) in tables.into_inner() {
        let DeValue::Table(fills) = fills.into_inner() else { continue };
        // The one table that is never missing: it has no key that must be given.
        if table.get_ref() == "coupling" && !case.contains_key("coupling") {
            let name = Spanned::new(key.clone(), "coupling".into());
            case.insert(name, Spanned::new(value.clone(), DeValue::Table(DeTable::new())));
        }
        let targets: Vec<&mut DeTable> = match case.get_mut(table.get_ref().as_ref()).map(Spanned::get_mut) {
            Some(DeValue::Table(target)) => vec![target],
            Some(DeValue::Array(list)) => {
                let tables = list.iter_mut().map(Spanned::get_mut);
                tables
                    .filter_map(|entry| if let DeValue::Table(target) = entry { Some(target) } else { None })
                    .collect()
            }
            _ => Vec::new(),
        };
        for target in targets {
            for (name, fill) in &fills {
                let fits = name.get_ref() != "fraction" || planar == Some(true);
                if fits && !target.contains_key(name.get_ref().as_ref()) {
                    let name = Spanned::new(key.clone(), name.get_ref().clone());
                    target.insert(name, Spanned::new(value.clone(), fill.get_ref().clone()));
                }
            }
        }
    }
    Some(key.start)
}
