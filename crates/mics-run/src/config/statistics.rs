//! Means over time, and records at points.

use super::{Axis, Case};
use crate::config::fault::{AXES, Check, not_negative, positive, vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Means and second moments over time, in every cell and in layers: `statistics.vti` and
/// `profile.csv`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Statistics {
    /// From this time on (s), default 0.
    pub from: f64,
    /// Until this time (s), default the end.
    pub until: Option<f64>,
    /// Steps from one sample to the next, default 5.
    pub every: u64,
    /// Axis across the layers whose means are in `profile.csv`; default none.
    pub profile: Option<Axis>,
}

impl Default for Statistics {
    fn default() -> Self {
        Statistics { from: 0.0, until: None, every: 5, profile: None }
    }
}

impl Statistics {
    /// Checks it as a part of its case.
    pub(in crate::config) fn check(&self, case: &Case) -> Check {
        not_negative("from", self.from, "s")?;
        positive("until", self.until, "s")?;
        let until = self.until.unwrap_or(case.time.end);
        ensure!(self.from < until, "from", "must be before {until:?} s, not {:?}", self.from);
        ensure!(self.every > 0, "every", "must be 1 step or more, not 0");
        self.profile.map_or(Ok(()), |axis| axis.check("profile", case.dimension()))
    }
}

/// A point, or points on a line, whose velocity and pressure `probes.csv` records.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Its name in `probes.csv`.
    pub name: String,
    /// Where it is (m); the first point of a line.
    pub at: Vec<f64>,
    /// The last point of a line (m); default none: a point.
    pub to: Option<Vec<f64>>,
    /// Points of the line, ends included; default 2.
    pub points: Option<usize>,
    /// Steps from one record to the next, default 1.
    pub every: Option<u64>,
    /// From this time on (s), default 0.
    #[serde(default)]
    pub from: f64,
}

impl Probe {
    /// Checks the entry `index` of a case.
    pub(in crate::config) fn check(&self, case: &Case, index: usize) -> Check {
        let plain = !self.name.is_empty() && !self.name.contains([',', '"', '\n']);
        ensure!(plain, "name", "must be some text without commas and quotes");
        let own = case.probe[..index].iter().all(|other| other.name != self.name);
        ensure!(
            own,
            "name",
            "\"{}\" names another probe already: give each its own name",
            self.name
        );
        for (name, place) in [("at", Some(&self.at)), ("to", self.to.as_ref())] {
            let Some(place) = place else { continue };
            vector(name, place, case.dimension(), "m")?;
            for (axis, size) in case.domain.size.iter().enumerate() {
                let at = place[axis];
                let x = AXES[axis];
                let holds = (0.0..=*size).contains(&at);
                ensure!(
                    holds,
                    format!("{name}.{axis}"),
                    "{x} = {at:?} m is outside: 0 <= {x} <= {size:?} m"
                );
            }
        }
        let line = self.to.is_some() || self.points.is_none();
        ensure!(line, "points", "is of a line: give its other end, `to`, or remove it");
        ensure!(
            self.points.is_none_or(|n| (2..=100_000).contains(&n)),
            "points",
            "must be from 2 to 100,000"
        );
        ensure!(self.every != Some(0), "every", "must be 1 step or more, not 0");
        not_negative("from", self.from, "s")
    }

    /// Its points (m).
    pub fn places(&self) -> Vec<Vec<f64>> {
        let Some(to) = &self.to else { return vec![self.at.clone()] };
        let count = self.points.unwrap_or(2);
        let share = |i: usize| i as f64 / (count - 1) as f64;
        let between =
            |i: usize| self.at.iter().zip(to).map(|(a, b)| a + share(i) * (b - a)).collect();
        (0..count).map(between).collect()
    }
}
