//! The rules of the sides of the box: pairs, axes, profiles, and what comes in goes out.

use super::*;
use crate::config::fault::{AXES, finite, short};

/// Checks the conditions at the sides of the box.
pub(super) fn boundary(case: &Case) -> Check {
    let dimension = case.dimension();
    for (number, name) in SIDES.into_iter().enumerate() {
        let key = format!("boundary.{name}");
        let axis = number / 2;
        let opposite = SIDES[number ^ 1];
        let Some(side) = case.boundary.side(number) else {
            ensure!(axis >= dimension, key, "missing: a 3D case needs bottom and top as well");
            continue;
        };
        ensure!(
            axis < dimension,
            key,
            "is for 3D only, and domain.size has two numbers: remove it"
        );
        match side {
            Side::Periodic => {
                let paired = case.boundary.side(number ^ 1) == Some(&Side::Periodic);
                let cure = format!("set both {name} and {opposite} to \"periodic\", or neither");
                ensure!(paired, key, "{name} is periodic and {opposite} is not: {cure}");
            }
            Side::Outflow | Side::Wall | Side::Slip => {}
            Side::MovingWall(velocity) => {
                let key = format!("{key}.moving_wall");
                vector(&key, velocity, dimension, "m/s")?;
                let normal = velocity[axis];
                let x = AXES[axis];
                let key = format!("{key}.{axis}");
                ensure!(
                    normal == 0.0,
                    key,
                    "a wall moves in its own plane: set {x} to 0.0 m/s, not {normal:?}"
                );
            }
            Side::Inflow(velocity) => vector(&format!("{key}.inflow"), velocity, dimension, "m/s")?,
            Side::InflowParabola(velocity) => {
                vector(&format!("{key}.inflow_parabola"), velocity, dimension, "m/s")?
            }
            Side::InflowProfile(points) => {
                profile(&format!("{key}.inflow_profile"), points, dimension)?
            }
        }
    }
    balance(case)
}

/// Refuses inflows without an outflow, unless as much goes out by their velocities as comes in.
fn balance(case: &Case) -> Check {
    let mut sides = case.sides().map(|(_, side)| side).enumerate();
    if case.sides().any(|(_, side)| *side == Side::Outflow) {
        return Ok(());
    }
    let Some((number, _)) = sides.find(|(_, side)| !side.inflow().is_empty()) else {
        return Ok(());
    };
    let fluxes =
        || case.sides().enumerate().map(|(number, (_, side))| side.flux(number, &case.domain));
    let [enters, leaves] =
        [1.0, -1.0].map(|sign| fluxes().map(|flux| (sign * flux).max(0.0)).sum::<f64>());
    let unit = if case.dimension() == 2 { "m2/s" } else { "m3/s" };
    let name = SIDES[number];
    let opposite = SIDES[number ^ 1];
    ensure!(
        (enters - leaves).abs() <= BALANCED * enters.max(leaves),
        format!("boundary.{name}"),
        "inflow without outflow: by the velocities that are given {} {unit} come in and {} {unit} \
        go out; make these balance, or set {opposite} = \"outflow\"",
        short(enters),
        short(leaves)
    );
    Ok(())
}

/// Part by which the inflow and the outflow of a box may differ: rounding.
const BALANCED: f64 = 1e-12;

/// Checks a profile of an inflow.
fn profile(key: &str, profile: &Profile, dimension: usize) -> Check {
    let points = profile.at.len();
    let velocities = profile.velocity.len();
    let key_at = format!("{key}.at");
    finite(&key_at, &profile.at, "m")?;
    ensure!(points >= 2, key_at, "needs at least 2 coordinates (m), not {points}");
    let increasing = profile.at.is_sorted_by(|a, b| a < b);
    ensure!(increasing, key_at, "the coordinates (m) must increase from each to the next");
    let key = format!("{key}.velocity");
    ensure!(
        velocities == points,
        key,
        "needs {points} velocities, one for each in `at`, not {velocities}"
    );
    let check = |(i, velocity): (usize, &Vec<f64>)| {
        vector(&format!("{key}.{i}"), velocity, dimension, "m/s")
    };
    profile.velocity.iter().enumerate().try_for_each(check)
}
