//! Where bodies may not go.

use crate::grid::Grid;
use crate::solids::{Body, nearest_image};
use crate::{Error, Result};

/// Refuses bodies that have moved into each other or into the border of the box where no law of contact can stop them: a
/// cell holds no more solid than its volume, and a wall is where the box ends. What is held on both sides nothing stops.
///
/// # Errors
/// With the bodies' numbers and what to do.
pub(super) fn refuse_meetings<const D: usize>(
    grid: &Grid<D>,
    bodies: &[Body],
    has_law: bool,
    periods: &[Option<f64>; 3],
) -> Result<()> {
    let lawless = |b: &Body| !has_law || b.freedom().is_none();
    for (mover, body) in bodies.iter().enumerate().filter(|(_, b)| b.moves() && lawless(b)) {
        let cure = match body.freedom() {
            Some(_) => "give the case a [contact] table, or end the run before",
            None => "it moves as prescribed: end the run before, or change its motion",
        };
        for (a, axis) in ["x", "y", "z"].into_iter().enumerate().take(D).filter(|(a, _)| !grid.periodic[*a]) {
            let inside = body.radius * (1.0 - 1e-9)..=grid.size[a] - body.radius * (1.0 - 1e-9);
            if !inside.contains(&body.centre[a]) {
                return Err(Error::Run(format!(
                    "particle {mover} has reached the border of the box along {axis} (its centre is at {:.6} m); {cure}",
                    body.centre[a]
                )));
            }
        }
        for (k, other) in bodies.iter().enumerate().filter(|(k, b)| *k != mover && lawless(b)) {
            let apart = nearest_image(&body.centre, &other.centre, periods);
            let reach = (body.radius + other.radius) * (1.0 - 1e-9);
            if apart.norm_squared() < reach * reach {
                return Err(Error::Run(format!(
                    "particle {mover} has run into particle {k} (their centres are {:.6} m apart); {cure}",
                    apart.norm()
                )));
            }
        }
    }
    Ok(())
}
