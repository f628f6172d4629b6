//! The rules of one body, which a swarm shares.

use super::overlap::slack;
use super::*;
use crate::config::SIDES;
use crate::config::fault::{AXES, Check, Within, not_negative, positive, short, vector};

/// Checks these keys for a body of this diameter (m).
fn check_enter(enter: &Enter, case: &Case, diameter: f64, free: bool) -> Check {
    let Enter { time, region, gap, .. } = enter;
    ensure!(free, "", "is for free particles: set motion = \"free\" or remove it");
    not_negative("time", *time, "s")?;
    not_negative("gap", *gap, "m")?;
    region.as_ref().map_or(Ok(()), |region| region.check(case, diameter, *gap).within("region"))
}

/// Material, motion and start of a particle, whose rules a swarm shares.
pub(in crate::config) struct Nature<'a> {
    /// Its motion.
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
    /// Checks these keys of a table.
    pub(in crate::config) fn check(&self, case: &Case) -> Check {
        let dimension = case.dimension();
        positive("density", self.density, "kg/m3")?;
        let ratio = self
            .density
            .filter(|_| *self.motion == Motion::Free)
            .map_or(1.0, |own| own / case.fluid.density);
        ensure!(
            DENSITY_RATIOS.contains(&ratio),
            "density",
            "is {ratio:.1e} times the fluid's: free particles are computed from {:e} to {:e} \
            times, and contacts hold up to 1e4; look at the units of both densities",
            DENSITY_RATIOS.start(),
            DENSITY_RATIOS.end()
        );
        not_negative("viscosity", self.viscosity, "Pa s")?;
        ensure!(
            self.material != Some(""),
            "material",
            "is empty: give the material a name, or remove the key"
        );
        printable("material", self.material)?;
        motion(self.motion, "motion", dimension)?;
        let free = *self.motion == Motion::Free;
        let cure =
            "set motion = \"free\", or give { prescribed = { velocity = [...], spin = ... } }";
        ensure!(
            free || self.velocity.is_none(),
            "velocity",
            "is how a free particle starts: {cure}"
        );
        ensure!(free || self.spin.is_none(), "spin", "is how a free particle starts: {cure}");
        ensure!(
            free || self.locked.is_empty(),
            "locked",
            "is for free particles: set motion = \"free\" or remove it"
        );
        if let Some(velocity) = self.velocity {
            vector("velocity", velocity, dimension, "m/s")?;
        }
        if let Some(spin) = self.spin {
            check_spin(spin, "spin", dimension)?;
        }
        for (i, lock) in self.locked.iter().enumerate() {
            let key = format!("locked.{i}");
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
pub(in crate::config) fn printable(key: &str, name: Option<&str>) -> Check {
    let plain = name.is_none_or(|name| !name.contains(char::is_control));
    ensure!(plain, key, "has a line break, a tab or another control character: leave it out");
    Ok(())
}

/// Checks one entry of `[[particle]]` by itself.
pub(in crate::config) fn particle(case: &Case, particle: &Particle, index: usize) -> Check {
    let dimension = case.dimension();
    let named = particle.name.as_deref() != Some("");
    ensure!(named, "name", "is empty: give the particle a name, or remove the key");
    printable("name", particle.name.as_deref())?;
    let key_shape = format!("shape.{}", particle.shape.name());
    if particle.shape.is_round() {
        let fits = particle.shape.dimension() == dimension;
        ensure!(fits, "shape", "a disc is for 2D, a sphere for 3D; this case is {dimension}D");
        positive(&format!("{key_shape}.diameter"), particle.shape.diameter(), "m")?;
    }
    if let Some(orientation) = &particle.orientation {
        orientation.check("orientation", dimension)?;
    }
    let place = "position";
    vector(place, &particle.position, dimension, "m")?;
    below_periods(case, &period_key(&key_shape, particle), particle.shape.bounding_diameter())?;
    inside(case, place, &format!("particle {index}"), particle)?;
    let Particle { motion, density, viscosity, .. } = particle;
    let velocity = particle.velocity.as_deref();
    let spin = particle.spin.as_ref();
    let locked = particle.locked.as_slice();
    let material = particle.material.as_deref();
    let nature = Nature {
        motion,
        density: *density,
        viscosity: *viscosity,
        velocity,
        spin,
        locked,
        material,
    };
    nature.check(case)?;
    let enter = particle.enter.as_ref();
    enter.map_or(Ok(()), |enter| {
        let diameter = particle.shape.bounding_diameter();
        check_enter(enter, case, diameter, *motion == Motion::Free).within("enter")
    })
}

/// The key that says how large a body is.
fn period_key(shape: &str, particle: &Particle) -> String {
    if particle.shape.is_round() { format!("{shape}.diameter") } else { shape.to_owned() }
}

/// No body meets itself across periodic sides: its diameter (m) is below each period.
pub(in crate::config) fn below_periods(case: &Case, key: &str, diameter: f64) -> Check {
    for (axis, &size) in case.domain.size.iter().enumerate() {
        let holds = diameter < size || !case.periodic(axis);
        let x = AXES[axis];
        ensure!(
            holds,
            key,
            "must be below the periodic domain's {size:?} m along {x}, not {diameter:?}"
        );
    }
    Ok(())
}

/// The body `who` is within the box: its centre where sides are periodic, all of it elsewhere.
pub(in crate::config) fn inside(case: &Case, key: &str, who: &str, body: &Particle) -> Check {
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
            let [below, above] = body.reach(axis);
            let low = centre - below;
            let high = centre + above;
            let slack = slack(case, [body; 2]);
            let holds = low >= -slack && high <= size + slack;
            let extent = format!("from {} to {} m along {x}", short(low), short(high));
            let cure = if high - low > size {
                "it is larger than the box: look at the units of both, or turn it".to_owned()
            } else {
                format!(
                    "move it inside, or make {} and {} periodic",
                    SIDES[2 * axis],
                    SIDES[2 * axis + 1]
                )
            };
            let domain = format!("the domain from 0 to {size:?} m");
            ensure!(holds, key, "{who} reaches {extent}, outside {domain}: {cure}");
        }
    }
    Ok(())
}

/// Checks the motion of a body.
pub(in crate::config) fn motion(motion: &Motion, key: &str, dimension: usize) -> Check {
    let Motion::Prescribed(prescribed) = motion else { return Ok(()) };
    let velocity = &prescribed.velocity;
    if !velocity.is_empty() {
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
        .map_or(Ok(()), |spin| check_spin(spin, &format!("{key}.prescribed.spin"), dimension))
}

fn check_spin(spin: &Spin, key: &str, dimension: usize) -> Check {
    let (spin, fits) = match spin {
        Spin::Plane(spin) => (std::slice::from_ref(spin), dimension == 2),
        Spin::Space(spin) => (spin.as_slice(), dimension == 3),
    };
    ensure!(fits, key, "is one number in 2D and three in 3D (rad/s); this case is {dimension}D");
    ensure!(spin.iter().all(|c| c.is_finite()), key, "must be finite (rad/s), not {spin:?}");
    Ok(())
}
