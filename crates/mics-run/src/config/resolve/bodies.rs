//! Particles and obstacles, their defaults filled in.

use super::super::fault::Fault;
use super::super::raw::{self, Fluid, Spin};
use super::super::resolved::{Enter, Motion, Obstacle, Particle};

/// A particle in this fluid; `rest` is no velocity (m/s).
pub(super) fn particle(
    index: usize,
    raw: raw::Particle,
    entrance: Vec<(f64, f64)>,
    fluid: &Fluid,
    rest: &[f64],
) -> Result<Particle, Fault> {
    let velocity = raw.velocity.clone();
    let enter = raw.enter.clone().map(|raw::Enter { time, region, gap, seed }| {
        let gap = gap.unwrap_or(0.0);
        let seed = seed.unwrap_or(1);
        Enter { time, region, entrance, gap, seed, velocity }
    });
    let material = raw.material().to_owned();
    let motion = match raw.motion {
        raw::Motion::Fixed => Motion::Fixed,
        raw::Motion::Free => {
            let (velocity, spin) = start(raw.velocity, raw.spin, rest);
            Motion::Free { velocity, spin, locked: raw.locked }
        }
        raw::Motion::Prescribed(prescribed) => given_motion(prescribed, rest),
    };
    Ok(Particle {
        name: raw.name,
        material,
        shape: raw.shape,
        orientation: raw.orientation,
        density: raw.density.unwrap_or(fluid.density),
        viscosity: raw.viscosity.unwrap_or(fluid.viscosity),
        position: raw.position,
        motion,
        enter,
    })
}

/// Velocity (m/s) and spin (rad/s) as given; `rest` where they are not.
fn start(velocity: Option<Vec<f64>>, spin: Option<Spin>, rest: &[f64]) -> (Vec<f64>, [f64; 3]) {
    let spin = match spin {
        None => [0.0; 3],
        Some(Spin::Plane(z)) => [0.0, 0.0, z],
        Some(Spin::Space(spin)) => spin,
    };
    (velocity.unwrap_or_else(|| rest.to_vec()), spin)
}

fn given_motion(raw: raw::Prescribed, rest: &[f64]) -> Motion {
    let (velocity, spin) = start(raw.velocity, raw.spin, rest);
    Motion::Prescribed { velocity, spin, oscillation: raw.oscillation }
}

/// An obstacle that has been built; `rest` is no velocity (m/s).
pub(super) fn obstacle(index: usize, raw: raw::Obstacle, rest: &[f64]) -> Result<Obstacle, Fault> {
    let material = raw.material().to_owned();
    let wall = raw.wall.ok_or_else(|| Fault {
        key: format!("obstacle.{index}"),
        message: "has not been built".to_owned(),
    })?;
    let motion = match raw.motion {
        raw::Moved::Fixed => Motion::Fixed,
        raw::Moved::Prescribed(prescribed) => given_motion(prescribed, rest),
    };
    Ok(Obstacle { name: raw.name, wall, motion, material })
}
