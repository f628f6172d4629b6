//! The rules of the sides of the box: pairs, axes, profiles, and what comes in goes out.

use super::*;
use crate::config::fault::{AXES, increasing, short};

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
            Side::Inflow(inflow) => velocity(&key, "inflow", inflow, dimension)?,
            Side::InflowParabola(peak) => velocity(&key, "inflow_parabola", peak, dimension)?,
            Side::InflowHalfParabola(top) => {
                velocity(&key, "inflow_half_parabola", top, dimension)?
            }
            Side::InflowLog(LogProfile { velocity, roughness, .. }) => {
                let key = format!("{key}.inflow_log");
                vector(&format!("{key}.velocity"), velocity, dimension, "m/s")?;
                positive(&format!("{key}.roughness"), *roughness, "m")?;
            }
            Side::InflowProfile(points) => {
                profile(&format!("{key}.inflow_profile"), points, dimension)?
            }
        }
    }
    balance(case)
}

/// Checks the velocity of an inflow of a kind.
fn velocity(side: &str, kind: &str, inflow: &Inflow, dimension: usize) -> Check {
    let key = match inflow {
        Inflow::Steady(_) => format!("{side}.{kind}"),
        Inflow::Varying(_) => format!("{side}.{kind}.velocity"),
    };
    vector(&key, inflow.velocity(), dimension, "m/s")
}

/// Refuses inflows without an outflow, unless as much goes out by their velocities as comes in, at
/// all times.
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
    let through = || {
        let sides = case.sides().enumerate();
        sides.filter(|(number, (_, side))| side.flux(*number, &case.domain) != 0.0)
    };
    let table = through().next().and_then(|(_, (_, side))| side.over_time());
    let other = through().find(|(_, (_, side))| side.over_time() != table);
    let other = other.map_or("", |(_, (name, _))| name);
    ensure!(
        other.is_empty(),
        format!("boundary.{other}"),
        "inflow without outflow, and another table over_time than the other inflows have: what \
        comes in would not go out at all times; give all inflows the same over_time, or set a side \
        to \"outflow\""
    );
    Ok(())
}

/// Part by which the inflow and the outflow of a box may differ: rounding.
const BALANCED: f64 = 1e-12;

/// Checks a profile of an inflow.
fn profile(key: &str, profile: &Profile, dimension: usize) -> Check {
    let points = profile.at.len();
    let velocities = profile.velocity.len();
    increasing(&format!("{key}.at"), &profile.at, "coordinates", "m")?;
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
