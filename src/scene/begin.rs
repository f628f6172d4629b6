//! A scene that begins where another run ended.

use super::Scene;
use super::insertion::{ids, keep_only};
use crate::config::{Case, Motion};
use crate::method::energy;
use crate::state::{Balance, State};
use crate::{Error, Result};
use mics_run::vti;

/// Goes on from the `state` in which a run of the case `before` ended: with all that lasts,
/// where grid, walls, bodies and the fluid's density are the same. Returns whether they are; if
/// not, nothing is changed. Collective.
///
/// # Errors
/// When bodies are elsewhere than the case has them.
pub fn go_on_from<const D: usize>(
    scene: &mut Scene<D>,
    case: &Case,
    before: &Case,
    state: State<D>,
) -> Result<bool> {
    let method = |case: &Case| (case.coupling.wall, super::build::extrapolates(case));
    let grid =
        |case: &Case| (case.domain.clone(), (0..D).map(|a| case.periodic(a)).collect::<Vec<_>>());
    let density = |case: &Case| case.fluid.density;
    let rests = |case: &Case| case.obstacle.iter().all(|o| o.motion == Motion::Fixed);
    let same = method(case) == method(before)
        && case.obstacle == before.obstacle
        && rests(case)
        && grid(case) == grid(before)
        && density(case) == density(before);
    let alike = state.surfaces.is_some() == scene.state.surfaces.is_some();
    if !same || !alike || state.bodies.len() != scene.state.bodies.len() {
        return Ok(false);
    }
    // They are numbered anew, in the order of their numbers there, and stay in the order of the
    // state.
    let mut there = ids(&state.bodies);
    let mut here = ids(&scene.state.bodies);
    there.sort_unstable();
    here.sort_unstable();
    let order = ids(&state.bodies).into_iter().map(|id| here[there.partition_point(|n| *n < id)]);
    keep_only(scene, case, &order.collect::<Vec<_>>())?;
    let fresh = std::mem::replace(&mut scene.state, state);
    let s = &mut scene.state;
    s.time = 0.0;
    s.steps = 0;
    s.substeps = 0;
    let bodies = std::mem::replace(&mut s.bodies, fresh.bodies);
    // Under other forces, or with other weights, the bodies begin anew from where they are.
    let forces = |case: &Case| (case.fluid.gravity.clone(), case.drive.clone());
    let weigh_alike = s.bodies.iter().zip(&bodies).all(|(body, ended)| body.mass() == ended.mass());
    let mut begin = Vec::new();
    if forces(case) != forces(before) || !weigh_alike {
        begin.extend(s.bodies.iter().map(|body| body.id));
        s.drive = fresh.drive;
    }
    for (body, ended) in s.bodies.iter_mut().zip(&bodies) {
        if (body.centre - ended.centre).norm() > 1e-9 * body.radius() {
            return Err(Error::Usage(format!(
                "initial.from: {} is elsewhere in that run's newest checkpoint than in its \
                particles.csv: bring it to its end with --resume",
                body.called()
            )));
        }
        body.angle = ended.angle;
        body.orientation = ended.orientation;
    }
    if scene.method.contacts().is_none_or(|contacts| contacts.setup().check(&s.touching).is_err()) {
        s.touching = fresh.touching;
    }
    s.waiting = fresh.waiting;
    s.balance = fresh.balance.map(|_| Balance::default());
    scene.resume()?;
    scene.method.begin_bodies(&mut scene.domain, &mut scene.state, &begin)?;
    scene.method.start_balance(&mut scene.domain, &mut scene.state)?;
    energy::start(&mut scene.domain, &mut scene.state, &mut *scene.method)?;
    Ok(true)
}

/// Takes a velocity that is read, on whatever grid, interpolated to this one's cells, and makes
/// a consistent start of it. Collective.
///
/// # Errors
/// When it cannot be read, or the first projection fails.
pub fn start_from<const D: usize>(scene: &mut Scene<D>, velocity: &vti::ArrayRows) -> Result<()> {
    let taken = interpolate(scene, velocity);
    scene.domain.session.agree(taken)?;
    scene.start()
}

/// The velocity of this rank's cells between the nearest cells of another grid.
fn interpolate<const D: usize>(scene: &mut Scene<D>, velocity: &vti::ArrayRows) -> Result<()> {
    let grid = &scene.domain.grid;
    let cells = velocity.head.cells;
    let h = velocity.head.h;
    // Along an axis, the two cells beside a place and the share of the upper one; across a
    // period the first follows the last.
    let between = |a: usize, place: f64| {
        let n = cells[a] as i64;
        let at = place / h[a] - 0.5;
        let low = at.floor() as i64;
        let share = at - at.floor();
        let periodic = grid.periodic[a];
        let cell = |i: i64| if periodic { i.rem_euclid(n) } else { i.clamp(0, n - 1) } as usize;
        [(cell(low), 1.0 - share), (cell(low + 1), share)]
    };
    let across = |a: usize, place: &[f64; D]| {
        if a < D { between(a, place[a]) } else { [(0, 1.0), (0, 0.0)] }
    };
    let mut values = Vec::new();
    for row in grid.rows() {
        scene.state.u.iter_mut().for_each(|u| u[row.clone()].fill(0.0));
        let place = grid.centre(row.start);
        let along_y = across(1, &place);
        let along_z = across(2, &place);
        let beside = along_z
            .iter()
            .flat_map(|(k, wz)| along_y.iter().map(move |(j, wy)| (j + cells[1] * k, wy * wz)));
        for (number, weight) in beside.filter(|(_, weight)| *weight > 0.0) {
            velocity.read(number, &mut values)?;
            for c in row.clone() {
                for (i, share) in between(0, grid.centre(c)[0]) {
                    for (axis, u) in scene.state.u.iter_mut().enumerate() {
                        u[c] += weight
                            * share
                            * values.get(velocity.components * i + axis).copied().unwrap_or(0.0);
                    }
                }
            }
        }
    }
    Ok(())
}
