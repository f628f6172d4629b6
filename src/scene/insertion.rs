//! Bodies that leave the box or come into it: their history goes or begins, that of the others
//! stays, and the method is made anew for those that are there.

use super::{Scene, build};
use crate::config::{Case, Enter, Region};
use crate::geometry::{Block, images};
use crate::grid::BoundaryKind;
use crate::method::energy;
use crate::particles::{Body, Motion, nearest_image};
use crate::sharing::Sharing;
use crate::state::{BodyHistory, Exchange};
use crate::{Error, Result};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::HashMap;

/// Random places that a body tries in a step before it waits for the next one.
const TRIES: usize = 200;

/// The place in the list of the first free body whose surface may reach an outflow within a step as
/// long as `dt` (s), and the axis; bodies whose numbers are in `but` do not count. No body reaches
/// through an outflow: the fluid's force on the part outside would be missing.
pub fn leaving<const D: usize>(scene: &Scene<D>, dt: f64, but: &[usize]) -> Option<(usize, usize)> {
    let grid = &scene.domain.grid;
    let kinds = &scene.domain.boundaries.kinds;
    let open = |axis: usize, side: usize| matches!(kinds[axis][side], Some(BoundaryKind::Outflow));
    let leaves = |body: &Body, axis: usize| {
        let at = body.centre[axis] + 1.5 * dt * body.velocity[axis];
        let extent = body.reach()[axis];
        // A body that moves inwards stays, however near it is.
        let low = at <= extent && body.velocity[axis] < 0.0;
        let high = at >= grid.size[axis] - extent && body.velocity[axis] > 0.0;
        (low && open(axis, 0)) || (high && open(axis, 1))
    };
    let goes = |body: &Body| matches!(body.motion, Motion::Free(_)) && !but.contains(&body.id);
    let free = scene.state.bodies.iter().enumerate().filter(|(_, body)| goes(body));
    free.flat_map(|(k, body)| (0..D).map(move |axis| (k, body, axis)))
        .find_map(|(k, body, axis)| leaves(body, axis).then_some((k, axis)))
}

/// Takes the body at the place `k` of the list out of the box. Its momentum and energy are counted
/// as the boundary's. Collective.
///
/// # Errors
/// When the method cannot be made for the others.
pub fn remove<const D: usize>(scene: &mut Scene<D>, case: &Case, k: usize) -> Result<Body> {
    if k >= scene.state.bodies.len() {
        return Err(Error::Run(format!("there is no body {k} to be removed")));
    }
    let s = &mut scene.state;
    let gone = s.bodies.remove(k);
    s.exchange.remove(k);
    if let Some(walls) = &mut s.surfaces {
        walls.bodies.remove(k);
    }
    s.touching.springs.retain(|(first, second, _)| *first != k && *second != k);
    for (first, second, _) in &mut s.touching.springs {
        // A wall's number follows those of the bodies.
        *first -= usize::from(*first > k);
        *second -= usize::from(*second > k);
    }
    remake(scene, case, &[])?;
    Ok(gone)
}

/// Brings the body at the place `k` of the list to another place (m), at the velocity that it
/// has. Collective.
///
/// # Errors
/// As [`remove`].
pub fn bring<const D: usize>(
    scene: &mut Scene<D>,
    case: &Case,
    k: usize,
    centre: Vector3<f64>,
) -> Result<()> {
    scene.state.bodies[k].centre = centre;
    scene.state.touching.springs.retain(|(first, second, _)| *first != k && *second != k);
    let id = scene.state.bodies[k].id;
    remake(scene, case, &[id])
}

/// Lets those of the waiting bodies come in whose time has come and for which there is a free
/// place, and returns them as they come. Places follow from seed, step and number alone.
/// Collective.
///
/// # Errors
/// As [`remove`].
pub fn admit<const D: usize>(scene: &mut Scene<D>, case: &Case) -> Result<Vec<Body>> {
    let mut came: Vec<Body> = Vec::new();
    // Where a body has found no place, none that is as large tries in this step.
    let mut full: Vec<(&Region, f64, f64)> = Vec::new();
    for n in 0..scene.state.waiting.len() {
        let id = scene.state.waiting[n] as usize;
        let Some((particle, enter)) =
            case.particle.get(id).and_then(|p| Some((p, p.enter.as_ref()?)))
        else {
            return Err(Error::Run(format!(
                "body {id} waits to come in, and the case has none such"
            )));
        };
        if enter.time > scene.state.time {
            continue;
        }
        let radius = 0.5 * particle.shape.bounding_diameter();
        if full.iter().any(|(region, gap, least)| {
            enter.region.as_ref() == Some(*region) && enter.gap >= *gap && radius >= *least
        }) {
            continue;
        }
        let Some(place) = free_place(scene, id, radius, enter, &particle.entrance(case)) else {
            full.extend(enter.region.as_ref().map(|region| (region, enter.gap, radius)));
            continue;
        };
        let mut body = build::body(particle);
        body.id = id;
        body.centre = place;
        if particle.velocity.is_none() {
            body.velocity = mean_velocity(scene, &body)?;
        }
        let s = &mut scene.state;
        // The case's obstacles are the last bodies.
        let k = s.bodies.len() - case.obstacle.len();
        s.bodies.insert(k, body.clone());
        s.exchange.insert(k, Exchange::default());
        if let Some(walls) = &mut s.surfaces {
            walls.bodies.insert(k, BodyHistory::default());
        }
        for (first, second, _) in &mut s.touching.springs {
            *first += usize::from(*first >= k);
            *second += usize::from(*second >= k);
        }
        came.push(body);
    }
    if came.is_empty() {
        return Ok(came);
    }
    let ids: Vec<usize> = came.iter().map(|body| body.id).collect();
    scene.state.waiting.retain(|id| !ids.contains(&(*id as usize)));
    remake(scene, case, &ids)?;
    Ok(came)
}

/// A place (m) at which a body of this radius (m) comes in by its entrance (by axis: from, and
/// how far, in m), if there is one.
fn free_place<const D: usize>(
    scene: &Scene<D>,
    id: usize,
    radius: f64,
    enter: &Enter,
    entrance: &[(f64, f64)],
) -> Option<Vector3<f64>> {
    let periods = scene.domain.periods();
    let size = &scene.domain.grid.size;
    let mut random = ChaCha8Rng::seed_from_u64(enter.seed ^ scene.state.steps << 20);
    random.set_stream(id as u64);
    let tries = if enter.region.is_some() { TRIES } else { 1 };
    (0..tries).find_map(|_| {
        let mut place = Vector3::zeros();
        for (axis, (low, length)) in entrance.iter().enumerate() {
            let x = low + length * ((random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64);
            // Rounding may reach the far side of a period, which is its near side.
            place[axis] = if periods[axis].is_some() && x >= size[axis] { 0.0 } else { x };
        }
        let clear = |other: &Body| {
            let apart = nearest_image(&other.centre, &place, &periods).norm();
            apart >= radius + other.radius() + enter.gap
        };
        scene.state.bodies.iter().all(clear).then_some(place)
    })
}

/// The mean velocity (m/s) of the cells whose centres a body covers, or of the one that it is
/// in. Collective.
fn mean_velocity<const D: usize>(scene: &Scene<D>, body: &Body) -> Result<Vector3<f64>> {
    let grid = &scene.domain.grid;
    let mut sums = [0.0; 4];
    for image in images(grid, body.shape(), &body.centre) {
        for at in Block::owned(grid, &image, &body.reach()) {
            let arm = Vector3::from_fn(|a, _| {
                if a < D { (at[a] as f64 + 0.5) * grid.h[a] - image[a] } else { 0.0 }
            });
            let Some(c) = grid.owned_index(at).filter(|_| body.distance(&arm) <= 0.0) else {
                continue;
            };
            sums[3] += 1.0;
            scene.state.u.iter().zip(&mut sums).for_each(|(u, sum)| *sum += u[c]);
        }
    }
    scene.domain.session.sum(&mut sums)?;
    Ok(Vector3::new(sums[0], sums[1], sums[2]) / sums[3].max(1.0))
}

/// Makes the method anew for the present bodies, of which these are `new` at their places, and the
/// balance and the budget with it. Collective.
fn remake<const D: usize>(scene: &mut Scene<D>, case: &Case, new: &[usize]) -> Result<()> {
    let clock = scene.domain.clock.clone();
    scene.method = build::method(&scene.domain, case, &scene.state.bodies, scene.impact);
    // A method without free bodies would keep the modes of those that have left.
    scene.domain.projection.set_modes(&[], &[], &[], &Sharing::default())?;
    scene.resume()?;
    scene.domain.clock = clock;
    scene.method.impose_inserted(&mut scene.domain, &mut scene.state, new)?;
    scene.method.begin_bodies(&mut scene.domain, &mut scene.state, new)?;
    scene.method.start_balance(&mut scene.domain, &mut scene.state)?;
    energy::reopen(&mut scene.domain, &mut scene.state, &mut *scene.method)
}

/// The numbers of bodies.
pub fn ids(bodies: &[Body]) -> Vec<u64> {
    bodies.iter().map(|body| body.id as u64).collect()
}

/// Keeps the bodies of these numbers only, in this order, before their state is read. Collective.
///
/// # Errors
/// When there is another one among them.
pub fn keep_only<const D: usize>(scene: &mut Scene<D>, case: &Case, kept: &[u64]) -> Result<()> {
    if ids(&scene.state.bodies) == kept {
        return Ok(());
    }
    let s = &mut scene.state;
    let mut there: HashMap<u64, Body> =
        s.bodies.drain(..).map(|body| (body.id as u64, body)).collect();
    for id in kept {
        let entered = || {
            let particle = case.particle.get(*id as usize).filter(|p| p.enter.is_some())?;
            let mut body = build::body(particle);
            body.id = *id as usize;
            Some(body)
        };
        let body = there.remove(id).or_else(entered);
        let missing = || Error::Usage("it has particles that the case has not".into());
        s.bodies.push(body.ok_or_else(missing)?);
    }
    s.exchange.resize(kept.len(), Exchange::default());
    if let Some(walls) = &mut s.surfaces {
        walls.bodies.resize(kept.len(), BodyHistory::default());
    }
    scene.method = build::method(&scene.domain, case, &scene.state.bodies, scene.impact);
    Ok(())
}
