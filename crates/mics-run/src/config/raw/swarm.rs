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
    /// What measures and figures know all of them by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// How many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Where: they lie wholly inside. They are put down at random, and moved apart where there is
    /// no room at random: up to about 80 % of the area in 2D and 60 % of the volume in 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
    /// Their diameters (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter: Option<Diameters>,
    /// What the random numbers begin with, default 1: the same seed gives the same places
    /// everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Least distance from their surfaces to those of other bodies and to walls (m), default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// Instead of the keys above: a CSV file, by its path from the case file's folder. Its header
    /// names the columns: x, y (z in 3D) and diameter; density, vx, vy, vz and spin (about z) if
    /// wanted, which win over the keys below. The `particles.csv` in a run's folder gives that
    /// run's bodies as they were at its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// Density (kg/m3), default the fluid's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Viscosity inside the particles (Pa s), default the fluid's; the paper has 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<f64>,
    /// What moves them; default free, of the bodies of a run what moved them there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// Velocity of free particles at time 0 (m/s), default zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Angular velocity of free particles at time 0 (rad/s): one number in 2D, three in 3D; default
    /// zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<Spin>,
    /// Directions in which free particles keep their velocity whatever the forces; default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locked: Vec<Lock>,
    /// The name that `[[contact.pair]]` knows them by, default `default`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Feeds them into the region one after the other while the run goes on; default all are there
    /// at time 0. Without a `velocity` they come in with that of the fluid whose place they take.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feed: Option<Feed>,
}

/// How a swarm is fed. One that finds no place waits until there is one.
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
mod tests {
    use super::*;
    use crate::config::load;
    use crate::config::raw::particle::{distance, overlap};
    use crate::config::raw::validate;
    use std::f64::consts::PI;

    /// A box of 2 by 1 (by 1) m, periodic along x, with walls elsewhere, and these further keys.
    fn text(dimension: usize, keys: &str) -> String {
        let (size, cells) = (&[2.0, 1.0, 1.0][..dimension], &[16, 8, 8][..dimension]);
        let lids = if dimension == 3 { "bottom = \"wall\"\ntop = \"wall\"" } else { "" };
        format!(
            "name = \"box\"\ntime.end = 1.0\ndomain = {{ size = {size:?}, cells = {cells:?} }}\n\
             fluid = {{ density = 1.0, viscosity = 0.1 }}\n{keys}\n\
             [boundary]\nwest = \"periodic\"\neast = \"periodic\"\nsouth = \"wall\"\n\
                 north = \"wall\"\n{lids}"
        )
    }

    /// The same with its swarms turned into particles, or key and message of its refusal.
    fn expanded(dimension: usize, keys: &str, csv: &str) -> Result<Case, (String, String)> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("gravel.csv"), csv).unwrap();
        let mut case = toml::from_str(&text(dimension, keys)).unwrap();
        let checked =
            validate(&case).and_then(|()| expand(&mut case, folder.path(), |_| Err(String::new())));
        checked.map(|()| case).map_err(|fault| (fault.key, fault.message))
    }

    fn good(dimension: usize, keys: &str) -> Case {
        expanded(dimension, keys, "").unwrap()
    }

    #[test]
    fn three_thousand_bodies_find_their_places_in_no_time() {
        let start = crate::cpu::thread_seconds();
        let case = good(
            2,
            "swarm = [{ count = 3000, region = { min = [0.0, 0.0], max = [2.0, 1.0] }, \
             diameter = { uniform = [0.01, 0.025] } }]",
        );
        let spent = crate::cpu::thread_seconds() - start;
        assert!(spent < 0.5, "{spent} s");
        assert_eq!((case.particle.len(), case.swarm.len()), (3000, 0));
        assert!(overlap(&case).is_none());
        let diameters = || case.particle.iter().map(|particle| particle.shape.diameter());
        assert!(
            diameters().all(|d| (0.01..=0.025).contains(&d))
                && diameters().is_sorted_by(|a, b| a >= b)
        );
        assert!((diameters().sum::<f64>() / 3000.0 - 0.0175).abs() < 3e-4);
        // Across the periodic faces too.
        assert!(
            case.particle
                .iter()
                .any(|particle| particle.position[0] < 0.25 * particle.shape.diameter())
        );
    }

    #[test]
    fn a_swarm_is_packed_where_random_places_do_not_suffice() {
        let keys = "particle = \
            [{ shape = { disc = { diameter = 0.8 } }, position = [0.1, 0.5], motion = \
                \"fixed\" }]\n\
                    swarm = [{ count = COUNT, region = { min = [0.6, 0.0], max = [1.6, 1.0] }, \
                        diameter = 0.02, gap = 1e-4 }]";
        // 47 % at random; 75 % packed; 88 % is more than discs at random can fill.
        for count in [1500, 2400] {
            let case = good(2, &keys.replace("COUNT", &count.to_string()));
            assert_eq!(case.particle.len(), count + 1);
            assert!(overlap(&case).is_none());
            for grain in &case.particle[1..] {
                let [x, y] = grain.position[..] else { panic!("2D") };
                assert!((0.61..=1.59).contains(&x) && (0.0101..=0.9899).contains(&y), "{x} {y}");
            }
        }
        let (key, message) = expanded(2, &keys.replace("COUNT", "2800"), "").unwrap_err();
        assert!(
            key == "swarm.0.count"
                && message.contains("2800 do not fit: with their gaps they would cover 88.8 %"),
            "{message}"
        );
    }

    #[test]
    fn spheres_of_two_sizes_fill_more_than_half_of_a_box_across_its_periodic_sides() {
        let case = good(
            3,
            "swarm = [{ count = 1000, region = { min = [0.0, 0.0, 0.0], max = [2.0, 1.0, 1.0] }, \
             diameter = { uniform = [0.115, 0.135] } }]",
        );
        let volume: f64 =
            case.particle.iter().map(|p| p.shape.diameter().powi(3)).sum::<f64>() * PI / 6.0;
        assert!((0.5..0.53).contains(&(0.5 * volume)), "{volume}");
        assert!(overlap(&case).is_none());
        assert!(
            case.particle.iter().any(|p| p.position[0] < 0.02)
                && case.particle.iter().any(|p| p.position[0] > 1.98)
        );
    }

    #[test]
    fn a_seed_gives_the_same_places_everywhere_and_another_seed_others() {
        let keys = "swarm = [{ count = 4, region = { min = [0.0, 0.0], max = [2.0, 1.0] }, \
            diameter = 0.1, seed = SEED }]";
        let places = |seed: &str| {
            let case = good(2, &keys.replace("SEED", seed));
            case.particle.into_iter().map(|particle| particle.position).collect::<Vec<_>>()
        };
        assert_eq!(places("1"), places("1"));
        assert_ne!(places("1"), places("2"));
        // Written down once, to the last digit: what a case gave must stay what it gives.
        assert_eq!(places("1")[0], FIRST_PLACE);
    }

    /// Where the first of four bodies lies by seed 1.
    const FIRST_PLACE: [f64; 2] = [0.5673811826074753, 0.6895492013129978];

    #[test]
    fn swarms_keep_their_gap_to_walls_to_earlier_swarms_and_across_periodic_sides() {
        let case = good(
            3,
            "swarm = [{ count = 60, region = { min = [0.0, 0.0, 0.0], max = [2.0, 1.0, 1.0] }, \
                diameter = 0.15 }, \
             { count = 60, region = { min = [0.0, 0.0, 0.2], max = [2.0, 1.0, 0.7] }, \
             diameter = { uniform = [0.05, 0.1] }, gap = 0.03, motion = \"fixed\", material = \
                 \"glass\" }]",
        );
        assert_eq!(case.particle.len(), 120);
        assert!(overlap(&case).is_none());
        for (i, new) in case.particle.iter().enumerate().skip(60) {
            let radius = 0.5 * new.shape.diameter();
            for other in &case.particle[..i] {
                let apart = distance(&new.position, &other.position, &case.periods());
                assert!(apart >= radius + 0.5 * other.shape.diameter() + 0.03);
            }
            let [_, y, z] = new.position[..] else { panic!("3D") };
            assert!(
                y >= radius + 0.03
                    && y <= 1.0 - radius - 0.03
                    && z >= 0.2 + radius
                    && z <= 0.7 - radius
            );
            assert_eq!((&new.motion, new.material()), (&Motion::Fixed, "glass"));
        }
    }

    #[test]
    fn a_file_gives_places_and_what_else_it_names_and_the_swarm_the_rest() {
        let keys = "swarm = [{ from = \"gravel.csv\", density = 2.0, velocity = [1.0, 0.0], \
            locked = [\"rotation\"] }]";
        let csv = "# made by hand\ndiameter, x, y, vy, spin, density\n0.1, 0.5, 0.5, -1, 3, 4\n\
            0.2,1.0,0.5,0,0,5\n";
        let case = expanded(2, keys, csv).unwrap();
        let first = &case.particle[0];
        assert_eq!((first.shape.diameter(), &first.position[..]), (0.1, &[0.5, 0.5][..]));
        assert_eq!((first.density, first.velocity.as_deref()), (Some(4.0), Some(&[1.0, -1.0][..])));
        assert_eq!(
            (&first.spin, &first.locked[..]),
            (&Some(Spin::Plane(3.0)), &[Lock::Rotation][..])
        );
        assert_eq!((case.particle.len(), case.particle[1].density), (2, Some(5.0)));
    }

    #[test]
    fn a_case_with_swarms_is_written_out_with_every_particle_and_reads_back_equal() {
        let typed = text(
            2,
            "swarm = [{ count = 20, region = { min = [0.0, 0.0], max = [2.0, 1.0] }, diameter = \
                0.05, spin = 1.0 }]\n\
             contact = { normal_stiffness = 1e5, pair = [{ between = [\"wall\", \"default\"], \
                 friction = 0.2 }] }\n\
             measure = [{ name = \"end\", kind = \"position_x\", particle = 19 }]",
        );
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("case.toml");
        std::fs::write(&file, typed).unwrap();
        let case = load(&file, &[]).unwrap().case;
        std::fs::write(&file, case.to_toml()).unwrap();
        assert_eq!(load(&file, &[]).unwrap().case, case);
        assert!(
            case.to_toml().contains("substeps = \"auto\"")
                && case.to_toml().contains("restitution = 0.5")
        );
    }
}
