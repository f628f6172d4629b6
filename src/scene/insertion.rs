//! Bodies that leave the box or come into it: their history goes or begins, that of the others
//! stays, and the method goes on with those that are there.

use super::{Scene, build};
use crate::config::{Case, Enter, Region, Removed};
use crate::geometry::{Block, images};
use crate::grid::BoundaryKind;
use crate::method::energy;
use crate::particles::{Body, Motion, nearest_image};
use crate::sharing::Sharing;
use crate::state::{BodyHistory, Exchange, State};
use crate::{Error, Result};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::HashMap;

/// Random places that a body tries in a step before it waits for the next one.
const TRIES: usize = 200;

/// Bodies that passed the boundaries between two steps.
#[derive(Default)]
pub struct Passed {
    /// Their passages, in order.
    pub passages: Vec<Passage>,
    /// Whether one came in, or came in again.
    pub came: bool,
    /// A body at an outflow, where the case wants the run to end there.
    pub last: Option<usize>,
}

impl Passed {
    /// Why the run ends at `time` (s), where it does.
    pub fn ending(&self, time: f64) -> Option<String> {
        let id = self.last?;
        Some(format!(
            "particle {id} has reached an outflow at t = {time:.6} s: the run ends here, as \
            output.removed = \"stop\" says"
        ))
    }
}

/// A body that has left, has come in again, or has come in.
pub struct Passage {
    /// The body, as it passed.
    pub body: Body,
    /// The word of `passages.csv`.
    pub what: &'static str,
}

/// Takes the bodies out that would reach an outflow in a step about as long as `dt` (s), and lets
/// those in whose time has come and for which there is a free place. The momentum and energy of
/// bodies that leave are counted as the boundary's. Places follow from seed, step and number alone.
/// Collective.
///
/// # Errors
/// When a body waits that the case has not, or the method cannot go on with those that are there.
pub fn pass_boundaries<const D: usize>(
    scene: &mut Scene<D>,
    case: &Case,
    dt: f64,
) -> Result<Passed> {
    let mut passed = Passed::default();
    let mut new = Vec::new();
    let_out(scene, case, dt, &mut passed, &mut new);
    if passed.last.is_none() {
        admit(scene, case, &mut passed, &mut new)?;
    }
    passed.came = !new.is_empty();
    if !passed.passages.is_empty() {
        go_on(scene, case, &new)?;
    }
    Ok(passed)
}

/// Lets the bodies at outflows out, or in again at the other end: the numbers of these are `new`.
fn let_out<const D: usize>(
    scene: &mut Scene<D>,
    case: &Case,
    dt: f64,
    passed: &mut Passed,
    new: &mut Vec<usize>,
) {
    // Each returns once: the fluid may carry it out at the other side of the box at once.
    while let Some((k, axis)) = leaving(scene, dt, new) {
        let body = &scene.state.bodies[k];
        let place = match case.output.removed {
            Removed::Stop => {
                passed.last = Some(body.id);
                return;
            }
            Removed::Return => other_end(scene, body, axis),
            _ => None,
        };
        passed.passages.push(match place {
            Some(place) => {
                new.push(body.id);
                Passage { body: bring(&mut scene.state, k, place), what: "returned" }
            }
            None => Passage { body: remove(&mut scene.state, k), what: "left" },
        });
    }
}

/// The place in the list of the first free body whose surface may reach an outflow within a step as
/// long as `dt` (s), and the axis; bodies whose numbers are in `but` do not count. No body reaches
/// through an outflow: the fluid's force on the part outside would be missing.
fn leaving<const D: usize>(scene: &Scene<D>, dt: f64, but: &[usize]) -> Option<(usize, usize)> {
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

/// Where a body comes in again that goes out along an axis (m); `None` where another one is in its
/// way.
fn other_end<const D: usize>(scene: &Scene<D>, body: &Body, axis: usize) -> Option<Vector3<f64>> {
    let mut place = body.centre;
    let far = scene.domain.grid.size[axis];
    let extent = body.reach()[axis];
    place[axis] = if body.centre[axis] > 0.5 * far { extent } else { far - extent };
    let others = scene.state.bodies.iter().filter(|other| other.id != body.id);
    is_clear(others, &place, body.radius(), &scene.domain.periods()).then_some(place)
}

/// Takes the body at the place `k` of the list out of the box.
fn remove<const D: usize>(s: &mut State<D>, k: usize) -> Body {
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
    s.bodies.remove(k)
}

/// Brings the body at the place `k` of the list to another place (m), at the velocity that it has.
fn bring<const D: usize>(s: &mut State<D>, k: usize, place: Vector3<f64>) -> Body {
    s.bodies[k].centre = place;
    if let Some(walls) = &mut s.surfaces {
        walls.bodies[k].cut_at = None;
    }
    s.touching.springs.retain(|(first, second, _)| *first != k && *second != k);
    s.bodies[k].clone()
}

/// Lets those of the waiting bodies come in whose time has come and for which there is a free
/// place: their numbers are `new`. Collective.
fn admit<const D: usize>(
    scene: &mut Scene<D>,
    case: &Case,
    passed: &mut Passed,
    new: &mut Vec<usize>,
) -> Result<()> {
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
        new.push(id);
        passed.passages.push(Passage { body, what: "entered" });
    }
    scene.state.waiting.retain(|id| !new.contains(&(*id as usize)));
    Ok(())
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
        is_clear(scene.state.bodies.iter(), &place, radius + enter.gap, &periods).then_some(place)
    })
}

/// Whether nothing of others is within a distance (m) of a place (m): of the spheres about bodies,
/// and of obstacles, which may be as wide as the box, themselves.
fn is_clear<'a>(
    mut others: impl Iterator<Item = &'a Body>,
    place: &Vector3<f64>,
    distance: f64,
    periods: &[Option<f64>; 3],
) -> bool {
    others.all(|other| match other.is_obstacle() {
        true => other.distance(&(place - other.centre)) >= distance,
        false => {
            let apart = nearest_image(&other.centre, place, periods);
            apart.norm() >= distance + other.radius()
        }
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

/// Goes on with the present bodies, of which these are `new` at their places, and with the balance
/// and the budget of what is there. Collective.
fn go_on<const D: usize>(scene: &mut Scene<D>, case: &Case, new: &[usize]) -> Result<()> {
    let clock = scene.domain.clock.clone();
    let method = build::method(&scene.domain, case, &scene.state.bodies, scene.impact);
    let before = std::mem::replace(&mut scene.method, method);
    // A method without free bodies would keep the modes of those that have left.
    scene.domain.projection.set_modes(&[], &[], &[], &Sharing::default())?;
    scene.resume_after(Some(before))?;
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
