//! Bodies by their names.

use super::message::suggest;
use super::{Case, Particle};
use std::collections::BTreeSet;

impl Case {
    /// What a body is called: its name, with its number where others have the name too; without a
    /// name its number, from 0. Obstacles follow the particles.
    pub fn called(&self, id: usize) -> String {
        let name = |p: &Particle| p.name.clone();
        let wall =
            id.checked_sub(self.particle.len()).and_then(|k| Some((k, self.obstacle.get(k)?)));
        if let Some((k, obstacle)) = wall {
            return obstacle.name.clone().unwrap_or(format!("obstacle {k}"));
        }
        match self.particle.get(id).and_then(name) {
            None => format!("particle {id}"),
            Some(own)
                if self
                    .particle
                    .iter()
                    .filter(|p| p.name.as_ref() == Some(&own))
                    .nth(1)
                    .is_none() =>
            {
                own
            }
            Some(own) => format!("{own} {id}"),
        }
    }

    /// The particles of a number, from 0, or of a name.
    ///
    /// # Errors
    /// When there is none, in words.
    pub fn find(&self, wanted: &str) -> Result<Vec<usize>, String> {
        let count = self.particle.len();
        if let Ok(id) = wanted.parse::<usize>() {
            let unknown =
                || format!("there is no particle {id}: the case has {count}, counted from 0");
            return (id < count).then(|| vec![id]).ok_or_else(unknown);
        }
        let named = |id: &usize| self.particle[*id].name.as_deref() == Some(wanted);
        let ids: Vec<usize> = (0..count).filter(named).collect();
        let known = self.particle.iter().filter_map(|p| p.name.as_deref());
        if ids.is_empty() { Err(unnamed("particle", wanted, known)) } else { Ok(ids) }
    }
}

/// The refusal of a name that no particle, or obstacle, has, where these are known.
pub(super) fn unnamed<'a>(
    kind: &str,
    wanted: &str,
    known: impl Iterator<Item = &'a str>,
) -> String {
    let known: Vec<&str> = known.collect::<BTreeSet<_>>().into_iter().collect();
    let cure = match &known[..] {
        [] => format!("give it one, as in name = \"pier\" in its [[{kind}]]"),
        known => suggest(wanted, known),
    };
    format!("no {kind} has the name \"{wanted}\"; {cure}")
}
