//! The keys that a case leaves out, where their defaults depend on others.

use super::time::Bodies;
use super::{Case, Motion, Side, WallRule, direction};
use crate::config::fault::{Check, Within};

/// Fills in the keys that are not given, of a checked case whose swarms are among its
/// particles.
pub(in crate::config) fn fill(case: &mut Case) -> Check {
    fill_measures(case)?;
    let rest = vec![0.0; case.dimension()];
    if case.initial.velocity.is_empty() {
        case.initial.velocity = inflow(case).unwrap_or_else(|| rest.clone());
    }
    if case.fluid.gravity.is_empty() {
        case.fluid.gravity = rest;
    }
    for particle in &mut case.particle {
        particle.fill(&case.fluid);
    }
    if let Some(contact) = &mut case.contact {
        let diameters = case.particle.iter().map(|p| p.shape.diameter());
        contact.fill(diameters.reduce(f64::min).unwrap_or(0.0));
    }
    let count = case.particle.len();
    let resting = case.particle.iter().filter(|p| p.motion == Motion::Fixed).count();
    case.output.fill(count, resting);
    let moves = resting < count || case.obstacle.iter().any(|o| o.motion != Motion::Fixed);
    let bodies = match (case.has_bodies(), moves) {
        (false, _) => Bodies::None,
        (true, false) => Bodies::Fixed,
        (true, true) if case.crowding() > 1.0 => Bodies::Crowd,
        (true, true) => Bodies::Moving,
    };
    case.time.fill(case.coupling.wall == WallRule::Mixture && case.has_bodies(), bodies)
}

fn fill_measures(case: &mut Case) -> Check {
    let mut measures = case.measure.clone();
    for (index, measure) in measures.iter_mut().enumerate() {
        let key = format!("measure.{index}");
        let direction = direction::of(case, measure).within(&key)?;
        let axis = direction::axis(case, measure).within(&key)?;
        measure.fill(case, direction, axis);
    }
    case.measure = measures;
    Ok(())
}

/// The velocity (m/s) of the first inflow at time 0, of a profile of points at its middle.
fn inflow(case: &Case) -> Option<Vec<f64>> {
    (0..6).find_map(|face| {
        let side = case.boundary.side(face)?;
        let mut velocity = match side {
            Side::InflowProfile(p) => p.velocity_at(0.5 * case.domain.size[usize::from(face < 2)]),
            _ => side.inflow().first()?.clone(),
        };
        if let Some(table) = side.over_time() {
            velocity.iter_mut().for_each(|v| *v *= table.at(0.0));
        }
        Some(velocity)
    })
}
