//! Many bodies at once: `[[swarm]]`, turned into entries of `particle`.

mod kinds;
mod of_run;
mod placement;
mod region;
mod table;

use std::path::Path;

use super::begin::ReadBodies;
use super::particle::{Enter, Nature};
use super::shape::sensible;
use super::{Case, Listed, Lock, Motion, Particle, Spin, Typed};
use crate::config::fault::{Check, Within, not_negative, positive};
pub use kinds::Kind;
use kinds::Made;
pub use region::Region;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bodies scattered at random over a region, or listed in a CSV file.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Swarm {
    /// Their common name in measures and figures.
    pub name: Option<String>,
    /// Number of bodies.
    pub count: Option<usize>,
    /// Where they lie, at random, packed up to about 80 % of the area in 2D and 60 % of the volume
    /// in 3D.
    pub region: Option<Region>,
    /// Their diameters (m); of shapes that are not round those of the disc or sphere of their
    /// volume, to which they are scaled, and by default as they are.
    pub diameter: Option<Diameters>,
    /// The shape of all; default a disc in 2D, a sphere in 3D. Shapes that are not round are put
    /// down with their bounding discs or spheres clear of each other.
    pub shape: Option<Typed>,
    /// Their shapes, where they have several, each with its share, as in
    /// `[{ ellipsoid = { axes = [0.02, 0.01, 0.01] }, share = 0.3 }, ...]`.
    pub shapes: Option<Vec<Listed>>,
    /// Orientations of bodies that are not round; default at random.
    pub orientations: Option<Orientations>,
    /// The shapes of `shape` or `shapes`, once they have been built.
    #[serde(skip)]
    pub solids: Vec<Kind>,
    /// Seed of the random numbers, default 1; the same seed gives the same places on all machines.
    pub seed: Option<u64>,
    /// Least distance to bodies and walls (m), default 0.
    pub gap: Option<f64>,
    /// Instead of the keys above: a CSV file, relative to the case file, with columns x, y (z in
    /// 3D), diameter (beside `shape` and `shapes` if wanted) and, if wanted, shape (its number in
    /// `shapes`, from 0), angle (rad; in 3D qw, qx, qy, qz), density, vx, vy, vz, spin (about z),
    /// which win over the keys below. The `particles.csv` of a run gives its bodies at its end.
    pub from: Option<String>,
    /// Density (kg/m3), default the fluid's.
    pub density: Option<f64>,
    /// Viscosity inside the particles (Pa s), default the fluid's; the paper has 0.
    pub viscosity: Option<f64>,
    /// Their motion; default free, or as in the run that `from` names.
    pub motion: Option<Motion>,
    /// Velocity of free particles at time 0 (m/s), default zero.
    pub velocity: Option<Vec<f64>>,
    /// Angular velocity of free particles at time 0 (rad/s), default zero.
    pub spin: Option<Spin>,
    /// Directions in which free particles keep their velocity; default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locked: Vec<Lock>,
    /// Their name in `[[contact.pair]]`, default `default`.
    pub material: Option<String>,
    /// Feeds them into the region one by one during the run; default all are there at time 0.
    /// Without `velocity` they enter at that of the fluid.
    pub feed: Option<Feed>,
}

/// Feed of a swarm. A body waits until a place is free.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Feed {
    /// Bodies a second (1/s).
    pub rate: f64,
    /// When the first one comes (s), default 0.
    pub from: Option<f64>,
}

/// Orientations of the bodies of a swarm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Orientations {
    /// At random, every orientation equally likely.
    #[default]
    Random,
    /// As their shapes lie in their own axes.
    Fixed,
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

/// Most bodies of a swarm: more would be a slip of the finger.
const MOST: usize = 1_000_000;

/// A swarm to be scattered: its keys that `from` would replace, checked.
struct Scatter<'a> {
    count: usize,
    region: &'a Region,
    diameter: Option<&'a Diameters>,
    seed: u64,
    gap: f64,
    /// Diameter (m) of the disc or sphere that would hold any of them.
    widest: f64,
}

impl Swarm {
    /// Checks the entry `index` by itself, its file unread.
    pub(super) fn check(&self, case: &Case, index: usize) -> Check {
        match &self.from {
            None => self.check_scatter(case, index)?,
            Some(file) => {
                ensure!(
                    !file.is_empty(),
                    "from",
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
                    ensure!(
                        !given,
                        name,
                        "{name} and from exclude each other, as the file says where: remove one of \
                        them"
                    );
                }
            }
        }
        let Swarm { density, viscosity, .. } = self;
        let motion = &self.motion.clone().unwrap_or_default();
        let velocity = self.velocity.as_deref();
        let spin = self.spin.as_ref();
        let locked = self.locked.as_slice();
        let material = self.material.as_deref();
        let nature = Nature {
            motion,
            density: *density,
            viscosity: *viscosity,
            velocity,
            spin,
            locked,
            material,
        };
        nature.check(case)
    }

    /// Diameter (m) of the disc or sphere that would hold any of its bodies.
    fn widest(&self) -> f64 {
        let largest = self.diameter.as_ref().map(|diameter| diameter.bounds()[1]);
        let widest = self.solids.iter().map(|kind| kind.bounding(largest)).fold(0.0, f64::max);
        if self.solids.is_empty() { largest.unwrap_or(0.0) } else { widest }
    }

    fn scatter(&self) -> Option<Scatter<'_>> {
        let count = self.count?;
        let region = self.region.as_ref()?;
        let diameter = self.diameter.as_ref();
        let sized = diameter.is_some() || self.shape.is_some() || self.shapes.is_some();
        sized.then_some(Scatter {
            count,
            region,
            diameter,
            seed: self.seed.unwrap_or(1),
            gap: self.gap.unwrap_or(0.0),
            widest: self.widest(),
        })
    }

    fn check_scatter(&self, case: &Case, index: usize) -> Check {
        let Some(Scatter { count, region, diameter, gap, .. }) = self.scatter() else {
            let given = [self.count.is_some(), self.region.is_some(), self.diameter.is_some()];
            let missing =
                ["count", "region", "diameter"].into_iter().zip(given).find(|(_, given)| !given);
            let missing = missing.map_or("count", |(name, _)| name);
            let cure = "a swarm needs count, region and diameter (or a shape), or \
                from = \"particles.csv\"";
            ensure!(false, missing, "missing key `{missing}` in [swarm.{index}]: {cure}");
            return Ok(());
        };
        ensure!((1..=MOST).contains(&count), "count", "must be from 1 to {MOST}, not {count}");
        let bounds = diameter.map(Diameters::bounds);
        if let Some([least, largest]) = bounds {
            positive("diameter", least, "m")?;
            positive("diameter", largest, "m")?;
            let holds = least <= largest;
            ensure!(
                holds,
                "diameter",
                "the least, {least:?} m, comes first, then the largest, {largest:?} m"
            );
        }
        not_negative("gap", gap, "m")?;
        for kind in self.solids.iter().filter(|kind| !kind.shape.is_round()) {
            for of in bounds.map_or(vec![None], |bounds| bounds.map(Some).to_vec()) {
                sensible(case, kind.bounding(of), "shape")?;
            }
        }
        region.check(case, self.widest(), gap).within("region")?;
        if let Some(Feed { rate, from }) = self.feed {
            ensure!(
                self.motion.as_ref().is_none_or(|m| *m == Motion::Free),
                "feed",
                "is for free particles"
            );
            positive("feed.rate", rate, "1/s")?;
            not_negative("feed.from", from, "s")?;
        }
        Ok(())
    }

    /// A particle of this swarm, there at time 0.
    fn particle(&self, made: Made, position: Vec<f64>) -> Particle {
        let Made { shape, orientation } = made;
        Particle {
            name: self.name.clone(),
            shape,
            orientation,
            density: self.density,
            viscosity: self.viscosity,
            position,
            motion: self.motion.clone().unwrap_or_default(),
            velocity: self.velocity.clone(),
            spin: self.spin,
            locked: self.locked.clone(),
            material: self.material.clone(),
            enter: None,
        }
    }

    /// The particles that are fed, at the middle of the region until they come in.
    fn fed(&self, dimension: usize, Feed { rate, from }: &Feed, swarm: &Scatter) -> Vec<Particle> {
        let Scatter { region, seed, gap, .. } = swarm;
        let middle = |axis: usize| 0.5 * (region.min[axis] + region.max[axis]);
        let bodies = kinds::bodies(swarm, self, dimension).0.into_iter().enumerate();
        let entering = bodies.map(|(n, made)| {
            let enter = Enter {
                time: from.unwrap_or(0.0) + n as f64 / rate,
                region: Some((*region).clone()),
                gap: *gap,
                seed: *seed,
            };
            let place = (0..dimension).map(middle).collect();
            Particle { enter: Some(enter), ..self.particle(made, place) }
        });
        entering.collect()
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
                let (bodies, random) = kinds::bodies(&scatter, swarm, case.dimension());
                let key = format!("swarm.{index}.count");
                for (made, place) in placement::scatter(case, &scatter, bodies, random, &key)? {
                    case.particle.push(swarm.particle(made, place));
                }
            }
            (None, None, _) => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
