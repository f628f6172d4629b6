//! Bodies, one by one.

use super::{Case, FACES, Region};
use crate::config::fault::{AXES, Check, not_negative, positive, short, unlike, vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// One body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Particle {
    /// What measures and figures know it by, besides its number: particles count from 0 in the
    /// order of the file, those of `[[particle]]` before those of `[[swarm]]`. Several may have one
    /// name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its shape.
    pub shape: Shape,
    /// Density (kg/m3), default the fluid's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Viscosity inside the particle (Pa s), default the fluid's; the paper has 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<f64>,
    /// Centre at time 0 (m).
    pub position: Vec<f64>,
    /// What moves it; default free.
    #[serde(default)]
    pub motion: Motion,
    /// Velocity of a free particle's centre at time 0 (m/s), default zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Angular velocity of a free particle at time 0 (rad/s): one number in 2D (positive from x to
    /// y), three in 3D; default zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<Spin>,
    /// Directions in which a free particle keeps its velocity whatever the forces; default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locked: Vec<Lock>,
    /// The name that `[[contact.pair]]` knows it by, default `default`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// When and where it comes into the box, default at time 0 at its position. One without a
    /// `velocity` comes in with that of the fluid whose place it takes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enter: Option<Enter>,
}

/// How a free body comes into the box while the run goes on: at the end of the first step after its
/// time in which a place for it is free. It shares its momentum with the fluid that it sets off: a
/// disc of s times the density of a fluid at rest goes on with s/(s + 1) of its velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Enter {
    /// When (s).
    pub time: f64,
    /// Where: at random in this part of the box, wholly inside; default at its position.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
    /// Least distance to other bodies and to walls then (m), default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// What the random numbers begin with, default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

impl Enter {
    /// Checks these keys of the table `table` for a body of this diameter (m).
    fn check(&self, case: &Case, table: &str, diameter: f64, free: bool) -> Check {
        let Enter { time, region, gap, .. } = self;
        ensure!(free, table, "is for free particles: set motion = \"free\" or remove it");
        not_negative(&format!("{table}.time"), *time, "s")?;
        not_negative(&format!("{table}.gap"), *gap, "m")?;
        region
            .as_ref()
            .map_or(Ok(()), |region| region.check(case, table, diameter, gap.unwrap_or(0.0)))
    }
}

impl Particle {
    /// Where its centre may come into the box, by axis: from, and how far (m).
    pub fn entrance(&self, case: &Case) -> Vec<(f64, f64)> {
        let here = || self.position.iter().map(|x| (*x, 0.0)).collect();
        let region = self
            .enter
            .as_ref()
            .and_then(|enter| Some((enter.region.as_ref()?, enter.gap.unwrap_or(0.0))));
        region
            .and_then(|(region, gap)| region.room(case, gap, self.shape.diameter()))
            .unwrap_or_else(here)
    }

    /// The name of its material where none is given.
    pub const DEFAULT_MATERIAL: &str = "default";

    /// The name of its material.
    pub fn material(&self) -> &str {
        self.material.as_deref().unwrap_or(Self::DEFAULT_MATERIAL)
    }
}

/// A direction in which a free body keeps its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Lock {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z, 3D only.
    Z,
    /// All rotation.
    Rotation,
}

/// The shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A disc (2D), of unit depth.
    Disc(Round),
    /// A sphere (3D).
    Sphere(Round),
}

impl Shape {
    /// The diameter (m) of a disc or sphere.
    pub fn diameter(&self) -> f64 {
        let (Shape::Disc(round) | Shape::Sphere(round)) = self;
        round.diameter
    }

    /// The volume (m3) of a sphere, the area (m2) of a disc.
    pub fn volume(&self) -> f64 {
        let d = self.diameter();
        match self {
            Shape::Disc(_) => std::f64::consts::FRAC_PI_4 * d * d,
            Shape::Sphere(_) => std::f64::consts::FRAC_PI_6 * d * d * d,
        }
    }
}

/// The size of a disc or sphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Round {
    /// Diameter (m).
    pub diameter: f64,
}

/// What moves a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Motion {
    /// Forces and contacts move it.
    #[default]
    Free,
    /// It rests.
    Fixed,
    /// It moves as told, whatever the forces.
    Prescribed(Prescribed),
}

/// A prescribed motion: constant velocity and spin, to and fro about it where there is an
/// oscillation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Prescribed {
    /// Velocity of the centre (m/s), default zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Angular velocity (rad/s): one number in 2D (positive from x to y), three in 3D; default
    /// zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<Spin>,
    /// What the centre does besides; default nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub oscillation: Option<Oscillation>,
}

/// A motion to and fro: the centre is at `position + velocity t + amplitude sin(2 pi frequency t)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Oscillation {
    /// How far it goes along each axis (m); a negative number sets off the other way.
    pub amplitude: Vec<f64>,
    /// How often it comes back (1/s), positive.
    pub frequency: f64,
}

impl Oscillation {
    /// Largest speed of the motion to and fro (m/s).
    pub fn speed(&self) -> f64 {
        TAU * self.frequency * self.amplitude.iter().map(|a| a * a).sum::<f64>().sqrt()
    }
}

/// An angular velocity: one number in 2D, three in 3D (rad/s).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a spin is one number in 2D, three in 3D (rad/s)")]
pub enum Spin {
    /// About the axis that points at the viewer of a 2D scene.
    Plane(f64),
    /// About x, y, z.
    Space([f64; 3]),
}

/// What a particle is made of and how it starts, by its rules that a swarm shares.
pub(super) struct Nature<'a> {
    /// What moves it.
    pub motion: &'a Motion,
    /// Density (kg/m3).
    pub density: Option<f64>,
    /// Viscosity (Pa s).
    pub viscosity: Option<f64>,
    /// Velocity at time 0 (m/s).
    pub velocity: Option<&'a [f64]>,
    /// Angular velocity at time 0 (rad/s).
    pub spin: Option<&'a Spin>,
    /// Locked directions.
    pub locked: &'a [Lock],
    /// Its material's name.
    pub material: Option<&'a str>,
}

/// Density over the fluid's of free particles: a hundred times beyond what is tested (1e-4 to 1e5),
/// and far within the range of any two materials.
const DENSITY_RATIOS: std::ops::RangeInclusive<f64> = 1e-6..=1e7;

impl Nature<'_> {
    /// Checks these keys of the table `table`.
    pub(super) fn check(&self, table: &str, case: &Case) -> Check {
        let (key, dimension) = (|rest: &str| format!("{table}.{rest}"), case.dimension());
        positive(&key("density"), self.density, "kg/m3")?;
        let ratio = self
            .density
            .filter(|_| *self.motion == Motion::Free)
            .map_or(1.0, |own| own / case.fluid.density);
        ensure!(
            DENSITY_RATIOS.contains(&ratio),
            key("density"),
            "is {ratio:.1e} times the fluid's: free particles are computed from {:e} to {:e} \
            times, and contacts hold up to 1e4; look at the \
             units of both densities",
            DENSITY_RATIOS.start(),
            DENSITY_RATIOS.end()
        );
        not_negative(&key("viscosity"), self.viscosity, "Pa s")?;
        ensure!(
            self.material != Some(""),
            key("material"),
            "is empty: give the material a name, or remove the key"
        );
        printable(&key("material"), self.material)?;
        motion(self.motion, &key("motion"), dimension)?;
        let free = *self.motion == Motion::Free;
        let cure =
            "set motion = \"free\", or give { prescribed = { velocity = [...], spin = ... } }";
        ensure!(
            free || self.velocity.is_none(),
            key("velocity"),
            "is how a free particle starts: {cure}"
        );
        ensure!(free || self.spin.is_none(), key("spin"), "is how a free particle starts: {cure}");
        ensure!(
            free || self.locked.is_empty(),
            key("locked"),
            "is for free particles: set motion = \"free\" or remove it"
        );
        if let Some(velocity) = self.velocity {
            vector(&key("velocity"), velocity, dimension, "m/s")?;
        }
        if let Some(spin) = self.spin {
            spin.check(&key("spin"), dimension)?;
        }
        for (i, lock) in self.locked.iter().enumerate() {
            let key = key(&format!("locked.{i}"));
            let known = if dimension == 3 { "x, y, z and rotation" } else { "x, y and rotation" };
            ensure!(
                dimension == 3 || *lock != Lock::Z,
                key,
                "z is for 3D only; in 2D lock any of {known}"
            );
            ensure!(
                !self.locked[..i].contains(lock),
                key,
                "is given twice: lock any of {known}, each once"
            );
        }
        Ok(())
    }
}

/// Checks that a name can be drawn and stand in a line.
pub(super) fn printable(key: &str, name: Option<&str>) -> Check {
    let plain = name.is_none_or(|name| !name.contains(char::is_control));
    ensure!(plain, key, "has a line break, a tab or another control character: leave it out");
    Ok(())
}

/// Checks one entry of `[[particle]]` by itself.
pub(super) fn particle(case: &Case, particle: &Particle, index: usize) -> Check {
    let dimension = case.dimension();
    let table = format!("particle.{index}");
    let named = particle.name.as_deref() != Some("");
    ensure!(
        named,
        format!("{table}.name"),
        "is empty: give the particle a name, or remove the key"
    );
    printable(&format!("{table}.name"), particle.name.as_deref())?;
    let (shape, wanted) = match particle.shape {
        Shape::Disc(_) => ("disc", 2),
        Shape::Sphere(_) => ("sphere", 3),
    };
    let key = format!("{table}.shape");
    ensure!(
        dimension == wanted,
        key,
        "a disc is for 2D, a sphere for 3D; this case is {dimension}D"
    );
    let diameter = particle.shape.diameter();
    let key_diameter = format!("{table}.shape.{shape}.diameter");
    positive(&key_diameter, diameter, "m")?;
    let place = format!("{table}.position");
    vector(&place, &particle.position, dimension, "m")?;
    below_periods(case, &key_diameter, diameter)?;
    inside(case, &place, &format!("particle {index}"), particle)?;
    let Particle { motion, density, viscosity, .. } = particle;
    let (velocity, spin) = (particle.velocity.as_deref(), particle.spin.as_ref());
    let (locked, material) = (particle.locked.as_slice(), particle.material.as_deref());
    let nature = Nature {
        motion,
        density: *density,
        viscosity: *viscosity,
        velocity,
        spin,
        locked,
        material,
    };
    nature.check(&table, case)?;
    let enter = particle.enter.as_ref();
    enter.map_or(Ok(()), |enter| {
        enter.check(case, &format!("{table}.enter"), diameter, *motion == Motion::Free)
    })
}

/// No body meets itself across periodic sides: its diameter (m) is below each period.
pub(super) fn below_periods(case: &Case, key: &str, diameter: f64) -> Check {
    for (axis, &size) in case.domain.size.iter().enumerate() {
        let (holds, x) = (diameter < size || !case.periodic(axis), AXES[axis]);
        ensure!(
            holds,
            key,
            "must be below the periodic domain's {size:?} m along {x}, not {diameter:?}"
        );
    }
    Ok(())
}

/// The body `who` is within the box: its centre where sides are periodic, all of it elsewhere.
pub(super) fn inside(case: &Case, key: &str, who: &str, body: &Particle) -> Check {
    let diameter = body.shape.diameter();
    for (axis, (&centre, &size)) in body.position.iter().zip(&case.domain.size).enumerate() {
        let x = AXES[axis];
        if case.periodic(axis) {
            let domain = format!("the domain: 0 <= {x} < {size:?} m");
            ensure!(
                (0.0..size).contains(&centre),
                key,
                "{who} has its centre at {x} = {centre:?} m, outside {domain}"
            );
        } else {
            let (low, high, slack) =
                (centre - 0.5 * diameter, centre + 0.5 * diameter, slack(case, [body; 2]));
            let holds = low >= -slack && high <= size + slack;
            let extent = format!("from {} to {} m along {x}", short(low), short(high));
            let cure = format!(
                "move it inside, or make {} and {} periodic",
                FACES[2 * axis],
                FACES[2 * axis + 1]
            );
            let domain = format!("the domain from 0 to {size:?} m");
            ensure!(holds, key, "{who} reaches {extent}, outside {domain}: {cure}");
        }
    }
    Ok(())
}

fn motion(motion: &Motion, key: &str, dimension: usize) -> Check {
    let Motion::Prescribed(prescribed) = motion else { return Ok(()) };
    if let Some(velocity) = &prescribed.velocity {
        vector(&format!("{key}.prescribed.velocity"), velocity, dimension, "m/s")?;
    }
    if let Some(Oscillation { amplitude, frequency }) = &prescribed.oscillation {
        let key = format!("{key}.prescribed.oscillation");
        vector(&format!("{key}.amplitude"), amplitude, dimension, "m")?;
        positive(&format!("{key}.frequency"), *frequency, "1/s")?;
    }
    prescribed
        .spin
        .as_ref()
        .map_or(Ok(()), |spin| spin.check(&format!("{key}.prescribed.spin"), dimension))
}

impl Spin {
    fn check(&self, key: &str, dimension: usize) -> Check {
        let (spin, fits) = match self {
            Spin::Plane(spin) => (std::slice::from_ref(spin), dimension == 2),
            Spin::Space(spin) => (spin.as_slice(), dimension == 3),
        };
        ensure!(
            fits,
            key,
            "is one number in 2D and three in 3D (rad/s); this case is {dimension}D"
        );
        ensure!(spin.iter().all(|c| c.is_finite()), key, "must be finite (rad/s), not {spin:?}");
        Ok(())
    }
}

/// Two bodies that overlap, and by how much.
pub(super) struct Overlap {
    /// The index of the earlier.
    pub first: usize,
    /// The index of the later.
    pub second: usize,
    /// How far their centres are apart, and would have to be, in words.
    pub words: String,
}

/// The first two bodies found that overlap at time 0, periodic images included: a sweep along x
/// over those near enough.
pub(super) fn overlap(case: &Case) -> Option<Overlap> {
    let bodies = &case.particle;
    let widest = bodies.iter().map(|body| body.shape.diameter()).fold(0.0, f64::max);
    let periods = case.periods();
    let there = bodies.iter().enumerate().filter(|(_, body)| body.enter.is_none());
    let mut along_x: Vec<(f64, usize)> = there.map(|(i, body)| (body.position[0], i)).collect();
    if let Some(length) = periods[0] {
        let images = along_x.iter().filter(|(x, _)| *x <= widest).map(|&(x, i)| (x + length, i));
        along_x.extend(images.collect::<Vec<_>>());
    }
    along_x.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (rank, &(x, i)) in along_x.iter().enumerate() {
        for &(_, j) in along_x[rank + 1..]
            .iter()
            .take_while(|(other, _)| other - x <= widest)
            .filter(|(_, j)| *j != i)
        {
            let distance = distance(&bodies[i].position, &bodies[j].position, &periods);
            let pair = [i, j].map(|k| &bodies[k]);
            let reach = 0.5 * pair.iter().map(|body| body.shape.diameter()).sum::<f64>();
            let least = reach - slack(case, pair);
            if distance < least {
                let [distance, least] = unlike(distance, least);
                let words =
                    format!("their centres are {distance} m apart, and must be {least} m or more");
                return Some(Overlap { first: i.min(j), second: i.max(j), words });
            }
        }
    }
    None
}

/// How far two bodies may overlap (m): as grains do that press on each other, where contacts say
/// how, and where both are held: they may have settled in another run.
fn slack(case: &Case, pair: [&Particle; 2]) -> f64 {
    let held = pair.iter().all(|body| body.motion != Motion::Free);
    let part = if held || case.contact.is_some() { PRESSED } else { 1e-9 };
    part * pair.iter().map(|body| body.shape.diameter()).fold(f64::INFINITY, f64::min)
}

/// Overlap of grains that press on each other, of the smaller diameter.
const PRESSED: f64 = 0.02;

/// The distance (m) of two places by the shortest way across the periods.
pub(super) fn distance(a: &[f64], b: &[f64], periods: &[Option<f64>]) -> f64 {
    let apart = a.iter().zip(b).zip(periods);
    let apart =
        apart.map(|((a, b), period)| period.map_or(a - b, |l| a - b - l * ((a - b) / l).round()));
    apart.map(|d| d * d).sum::<f64>().sqrt()
}
