//! Refusal of bodies that have moved into each other or into the boundary of the box.

use crate::domain::Domain;
use crate::particles::{Body, gap, nearest_image};
use crate::{Error, Result};
use nalgebra::Vector3;

/// Refuses bodies that have moved into each other or into the boundary of the box where no law of
/// contact can stop them: a cell holds no more solid than its volume, and a wall is where the box
/// ends. Nothing stops two that are both held, as a wall is.
///
/// # Errors
/// With the bodies' numbers and what to do.
pub(crate) fn refuse_collisions<const D: usize>(
    domain: &Domain<D>,
    bodies: &[Body],
    has_law: bool,
) -> Result<()> {
    let grid = &domain.grid;
    let periods = domain.periods();
    let lawless = |b: &Body| !has_law || b.freedom().is_none();
    for (index, body) in bodies.iter().enumerate().filter(|(_, b)| b.moves() && lawless(b)) {
        let cure = match body.freedom() {
            Some(_) => "give the case a [contact] table, or end the run before",
            None => "it moves as prescribed: end the run before, or change its motion",
        };
        let bounds = body.reach();
        // An obstacle may cross the boundary of the box, and other obstacles.
        let obstacle = |b: &Body| b.shape().is_obstacle();
        let axes = ["x", "y", "z"].into_iter().enumerate().take(D);
        for (a, axis) in axes.filter(|(a, _)| !grid.periodic[*a] && !obstacle(body)) {
            let inside = bounds[a] * (1.0 - 1e-9)..=grid.size[a] - bounds[a] * (1.0 - 1e-9);
            if !inside.contains(&body.centre[a]) {
                return Err(Error::Run(format!(
                    "{} has reached the boundary of the box along {axis} (its centre is at \
                    {:.6} m); {cure}",
                    body.called(),
                    body.centre[a]
                )));
            }
        }
        let others = bodies.iter().enumerate().filter(|(k, b)| *k != index && lawless(b));
        for (_, other) in others.filter(|(_, b)| !(obstacle(b) && obstacle(body))) {
            let apart = nearest_image(&body.centre, &other.centre, &periods);
            let touching = (body.radius() + other.radius()) * (1.0 - 1e-9);
            if apart.norm_squared() < touching * touching && overlap(body, other, &apart) {
                return Err(Error::Run(format!(
                    "{} has run into {} (their centres are {:.6} m apart); {cure}",
                    body.called(),
                    other.called(),
                    apart.norm()
                )));
            }
        }
    }
    Ok(())
}

/// Whether two bodies overlap whose spheres do, the second one's centre `apart` from the first's
/// (m).
fn overlap(body: &Body, other: &Body, apart: &Vector3<f64>) -> bool {
    gap(body, other, apart).1 <= 1e-9 * body.radius().min(other.radius())
}
