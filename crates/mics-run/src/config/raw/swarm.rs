//! Many bodies at once: `[[swarm]]`, turned into entries of `particle`.

mod of_run;
mod placement;
mod region;
mod table;

use std::path::Path;

use super::begin::ReadBodies;
use super::particle::{Enter, Nature};
use super::{Case, Lock, Motion, Particle, Round, Shape, Spin};
use crate::config::fault::{Check, not_negative, positive};
pub use region::Region;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bodies scattered at random over a region, or listed in a CSV file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Swarm {
    /// Their common name in measures and figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// How many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Where they lie, at random, packed up to about 80 % of the area in 2D and 60 % of the volume
    /// in 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
    /// Their diameters (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter: Option<Diameters>,
    /// Seed of the random numbers, default 1; the same seed gives the same places on all machines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Least distance to bodies and walls (m), default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// Instead of the keys above: a CSV file, relative to the case file, with columns x, y (z in
    /// 3D), diameter and, if wanted, density, vx, vy, vz, spin (about z), which win over the keys
    /// below. The `particles.csv` of a run gives its bodies at its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// Density (kg/m3), default the fluid's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Viscosity inside the particles (Pa s), default the fluid's; the paper has 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<f64>,
    /// What moves them; default free, or as in the run that `from` names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// Velocity of free particles at time 0 (m/s), default zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Angular velocity of free particles at time 0 (rad/s), default zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<Spin>,
    /// Directions in which free particles keep their velocity; default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locked: Vec<Lock>,
    /// Their name in `[[contact.pair]]`, default `default`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Feeds them into the region one by one during the run; default all are there at time 0.
    /// Without `velocity` they enter at that of the fluid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feed: Option<Feed>,
}

/// How a swarm is fed. A body waits until a place is free.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Feed {
    /// How many a second (1/s).
    pub rate: f64,
    /// When the first one comes (s), default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
}

/// The diameters of a swarm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a swarm's diameter is one number or { uniform = [least, largest] } (m)"
)]
pub enum Diameters {
    /// All the same (m).
    Same(f64),
    /// Spread over a range.
    Spread(Range),
}

impl Diameters {
    /// The least and the largest (m).
    pub fn bounds(&self) -> [f64; 2] {
        match self {
            Diameters::Same(diameter) => [*diameter; 2],
            Diameters::Spread(range) => range.uniform,
        }
    }
}

/// A range of diameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// The least and the largest (m), all between equally likely.
    pub uniform: [f64; 2],
}

/// More would be a slip of the finger.
const MOST: usize = 1_000_000;

/// A swarm to be scattered: its keys that `from` would replace, checked.
struct Scatter<'a> {
    count: usize,
    region: &'a Region,
    diameter: &'a Diameters,
    seed: u64,
    gap: f64,
}

impl Swarm {
    /// Checks the entry `index` by itself, its file unread.
    pub(super) fn check(&self, case: &Case, index: usize) -> Check {
        let table = format!("swarm.{index}");
        match &self.from {
            None => self.check_scatter(case, &table)?,
            Some(file) => {
                let key = format!("{table}.from");
                ensure!(
                    !file.is_empty(),
                    key,
                    "is empty: name a CSV file, as in from = \"particles.csv\""
                );
                let given = [
                    ("count", self.count.is_some()),
                    ("region", self.region.is_some()),
                    ("diameter", self.diameter.is_some()),
                    ("seed", self.seed.is_some()),
                    ("gap", self.gap.is_some()),
                    ("feed", self.feed.is_some()),
                ];
                for (name, given) in given {
                    let key = format!("{table}.{name}");
                    ensure!(
                        !given,
                        key,
                        "{name} and from exclude each other, as the file says where: remove one of \
                        them"
                    );
                }
            }
        }
        let Swarm { density, viscosity, .. } = self;
        let motion = &self.motion.clone().unwrap_or_default();
        let (velocity, spin) = (self.velocity.as_deref(), self.spin.as_ref());
        let (locked, material) = (self.locked.as_slice(), self.material.as_deref());
        let nature = Nature {
            motion,
            density: *density,
            viscosity: *viscosity,
            velocity,
            spin,
            locked,
            material,
        };
        nature.check(&table, case)
    }

    fn scatter(&self) -> Option<Scatter<'_>> {
        let (count, region, diameter) =
            (self.count?, self.region.as_ref()?, self.diameter.as_ref()?);
        Some(Scatter {
            count,
            region,
            diameter,
            seed: self.seed.unwrap_or(1),
            gap: self.gap.unwrap_or(0.0),
        })
    }

    fn check_scatter(&self, case: &Case, table: &str) -> Check {
        let key = |rest: &str| format!("{table}.{rest}");
        let Some(Scatter { count, region, diameter, gap, .. }) = self.scatter() else {
            let given = [self.count.is_some(), self.region.is_some(), self.diameter.is_some()];
            let missing =
                ["count", "region", "diameter"].into_iter().zip(given).find(|(_, given)| !given);
            let missing = missing.map_or("count", |(name, _)| name);
            let cure = "a swarm needs count, region and diameter, or from = \"particles.csv\"";
            ensure!(false, key(missing), "missing key `{missing}` in [{table}]: {cure}");
            return Ok(());
        };
        ensure!((1..=MOST).contains(&count), key("count"), "must be from 1 to {MOST}, not {count}");
        let [least, largest] = diameter.bounds();
        positive(&key("diameter"), least, "m")?;
        positive(&key("diameter"), largest, "m")?;
        let holds = least <= largest;
        ensure!(
            holds,
            key("diameter"),
            "the least, {least:?} m, comes first, then the largest, {largest:?} m"
        );
        not_negative(&key("gap"), gap, "m")?;
        region.check(case, table, largest, gap)?;
        if let Some(Feed { rate, from }) = self.feed {
            ensure!(
                self.motion.as_ref().is_none_or(|m| *m == Motion::Free),
                key("feed"),
                "is for free particles"
            );
            positive(&key("feed.rate"), rate, "1/s")?;
            not_negative(&key("feed.from"), from, "s")?;
        }
        Ok(())
    }

    /// A particle of this swarm, there at time 0.
    fn particle(&self, dimension: usize, diameter: f64, position: Vec<f64>) -> Particle {
        let round = Round { diameter };
        Particle {
            name: self.name.clone(),
            shape: if dimension == 2 { Shape::Disc(round) } else { Shape::Sphere(round) },
            density: self.density,
            viscosity: self.viscosity,
            position,
            motion: self.motion.clone().unwrap_or_default(),
            velocity: self.velocity.clone(),
            spin: self.spin.clone(),
            locked: self.locked.clone(),
            material: self.material.clone(),
            enter: None,
        }
    }

    /// The particles that are fed, at the middle of the region until they come in.
    fn fed(
        &self,
        dimension: usize,
        Feed { rate, from }: &Feed,
        swarm: &Scatter,
    ) -> impl Iterator<Item = Particle> {
        let Scatter { region, seed, gap, .. } = swarm;
        let middle = |axis: usize| 0.5 * (region.min[axis] + region.max[axis]);
        placement::diameters(swarm).0.into_iter().enumerate().map(move |(n, diameter)| {
            let enter = Enter {
                time: from.unwrap_or(0.0) + n as f64 / rate,
                region: Some((*region).clone()),
                gap: Some(*gap),
                seed: Some(*seed),
            };
            let place = (0..dimension).map(middle).collect();
            Particle { enter: Some(enter), ..self.particle(dimension, diameter, place) }
        })
    }
}

/// Turns the swarms of a checked case into particles, in their order; files are looked for from
/// `folder` on, and `read` reads the case of a run that lists them.
pub(in crate::config) fn expand(case: &mut Case, folder: &Path, read: ReadBodies) -> Check {
    let swarms = std::mem::take(&mut case.swarm);
    for (index, swarm) in swarms.iter().enumerate() {
        match (&swarm.from, swarm.scatter(), &swarm.feed) {
            (Some(file), ..) if of_run::is_of_run(&folder.join(file)) => of_run::append(
                case,
                swarm,
                &folder.join(file),
                &format!("swarm.{index}.from"),
                read,
            )?,
            (Some(file), ..) => {
                table::append(case, swarm, &folder.join(file), &format!("swarm.{index}.from"))?
            }
            (None, Some(scatter), Some(feed)) => {
                case.particle.extend(swarm.fed(case.dimension(), feed, &scatter));
            }
            (None, Some(scatter), None) => {
                for (diameter, place) in
                    placement::scatter(case, &scatter, &format!("swarm.{index}.count"))?
                {
                    case.particle.push(swarm.particle(case.dimension(), diameter, place));
                }
            }
            (None, None, _) => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
