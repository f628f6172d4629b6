//! Direction of a measure of a force: along the stream, across it, or as the case gives it. A
//! torque is about z, or about the axis that the case gives.
//!
//! ```text
//!        lift          stream = fluid's velocity - the particle's, where they are told;
//!         ^                     without one along a prescribed swing, or past a free particle that
//!                               gravity pulls, or where a drive pushes
//!   ----> | o ----> drag        lift in 2D: the stream turned by +90 degrees; in 3D: along the
//!                               next axis (x -> y -> z -> x), less its
//!   stream                      part along the stream
//! ```

use super::measure::vector;
use super::{Case, Measure, MeasureKind, Motion};
use crate::config::fault::Fault;
use nalgebra::Vector3;

/// Unit direction of a measure; `None` without a force, or for a fit of Morison's formula.
pub(super) fn of(case: &Case, measure: &Measure) -> Result<Option<Vector3<f64>>, Fault> {
    if !measure.kind.has_direction() {
        return Ok(None);
    }
    if let Some(given) = &measure.direction {
        let given = vector(given)
            / if given.iter().all(|part| part.abs() <= 1.0) && vector(given).norm() > 0.1 {
                1.0
            } else {
                vector(given).amax()
            };
        let length = given.norm();
        // A direction that a run has written reads back unchanged.
        return Ok(Some(if (length - 1.0).abs() < 1e-12 { given } else { given / length }));
    }
    if measure.kind == MeasureKind::Torque {
        return Ok(Some(Vector3::z()));
    }
    let Some(stream) = stream(case, measure).try_normalize(1e-12) else {
        let example = if case.dimension() == 2 { "[1.0, 0.0]" } else { "[1.0, 0.0, 0.0]" };
        let message = format!(
            "nothing says which way the stream goes: give `direction`, as in direction = {example}"
        );
        return Err(Fault { key: "kind".to_owned(), message });
    };
    Ok(Some(if measure.kind.is_across() { across(&stream, case.dimension()) } else { stream }))
}

/// A vector along the stream past the particle that a measure is of, the first one of a group: by
/// velocities, an oscillation, gravity or the drive; zero where the case tells none of them.
fn stream(case: &Case, measure: &Measure) -> Vector3<f64> {
    let fluid = case.reference_velocity().map_or(Vector3::zeros(), |v| vector(&v));
    let id = measure
        .particles
        .as_ref()
        .and_then(|group| group.first())
        .unwrap_or(&measure.particle)
        .id();
    let Some(particle) = case.particle.get(id) else { return fluid };
    let (own, swing) = match &particle.motion {
        Motion::Prescribed(told) => {
            (Some(&told.velocity), told.oscillation.as_ref().map(|o| &o.amplitude))
        }
        Motion::Fixed | Motion::Free => (None, None),
    };
    let past = fluid - own.map_or(Vector3::zeros(), |v| vector(v));
    if past.norm() > 0.0 {
        return past;
    }
    if let Some(amplitude) = swing {
        return vector(amplitude);
    }
    let heavy = particle.density.unwrap_or(case.fluid.density) - case.fluid.density;
    match particle.motion {
        Motion::Free if !case.fluid.gravity.is_empty() => {
            -heavy.signum() * vector(&case.fluid.gravity)
        }
        _ => push(case).unwrap_or_default(),
    }
}

/// Force of the drive on the fluid (N/m3); `None` where there is none, or one that a step finds.
fn push(case: &Case) -> Option<Vector3<f64>> {
    case.drive.as_ref()?.push(case)
}

/// Gravity along the axes that are periodic, or along those that have sides.
fn gravity_along(case: &Case, periodic: bool) -> Vector3<f64> {
    let gravity = vector(&case.fluid.gravity);
    Vector3::from_fn(|a, _| {
        if a < case.dimension() && case.periodic(a) == periodic { gravity[a] } else { 0.0 }
    })
}

/// Axis of a measure of the whole box: the given one; for a bed that of gravity, first among the
/// axes that have sides; for others that of the drive or the stream.
pub(super) fn axis(case: &Case, measure: &Measure) -> Result<usize, Fault> {
    let sided = gravity_along(case, false);
    let across = if sided != Vector3::zeros() { sided } else { gravity_along(case, true) };
    if let Some(axis) = measure.axis {
        let stands = measure.kind.is_along_bed() && axis.index() == across.iamax();
        let message = "gravity is along it: give an axis along the bed".into();
        let fault = Fault { key: "axis".to_owned(), message };
        return if stands { Err(fault) } else { Ok(axis.index()) };
    }
    if !measure.kind.has_axis() {
        return Ok(0);
    }
    let along = if measure.kind == MeasureKind::BedHeight {
        across
    } else {
        push(case).or_else(|| case.reference_velocity().map(|v| vector(&v))).unwrap_or_default()
    };
    let why = "nothing says along which axis: give `axis`, as in axis = \"x\"";
    let fault = || Fault { key: "kind".to_owned(), message: why.into() };
    if along == Vector3::zeros() { Err(fault()) } else { Ok(along.iamax()) }
}

fn across(stream: &Vector3<f64>, dimension: usize) -> Vector3<f64> {
    if dimension == 2 {
        return Vector3::new(-stream.y, stream.x, 0.0);
    }
    let mut next = Vector3::zeros();
    next[(stream.iamax() + 1) % 3] = 1.0;
    (next - next.dot(stream) * stream).normalize()
}

#[cfg(test)]
mod tests {
    use crate::config::written;

    /// The directions of drag, lift and force of a case with these sides, in 2D or 3D, and this
    /// about its particle.
    fn directions(size: &str, more: &str, measure: &str) -> Result<Vec<[f64; 3]>, String> {
        let flat = size.matches(',').count() == 1;
        let (shape, place) =
            if flat { ("disc", "[0.5, 0.5]") } else { ("sphere", "[0.5, 0.5, 0.5]") };
        let kinds = ["drag_coefficient", "lift_coefficient", "strouhal", "force"];
        let kinds = kinds
            .map(|kind| format!("[[measure]]\nname = \"{kind}\"\nkind = \"{kind}\"\n{measure}\n"));
        let speed =
            |kind: String| if kind.contains("\"force\"") { kind } else { kind + "speed = 1.0\n" };
        let (boundary, particle) = more.split_once('|').unwrap_or((more, ""));
        let case = written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = {size}, cells = {} }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1{} }}\nboundary = {{ {boundary} }}\n\
            [[particle]]\nshape = {{ {shape} = {{ diameter = 0.2 }} }}\nposition = {place}\n\
            density = 5.0\n{particle}\n{}",
            if flat { "[8, 8]" } else { "[8, 8, 8]" },
            if particle.contains("free") {
                format!(", gravity = {}", if flat { "[0.0, -9.81]" } else { "[0.0, 0.0, -9.81]" })
            } else {
                String::new()
            },
            kinds.map(speed).concat()
        ))?;
        Ok(case.measure.iter().map(|m| m.direction().unwrap().into()).collect())
    }

    const BOX: &str = "west = \"slip\", east = \"slip\", south = \"slip\", north = \"slip\"";

    #[test]
    fn drag_and_lift_directions_for_every_stream_axis() {
        let upward = "west = \"slip\", east = \"slip\", south = { inflow = [0.0, 2.0] }, north = \
            \"outflow\"";
        let found = directions("[1.0, 1.0]", &format!("{upward}|motion = \"fixed\""), "").unwrap();
        assert_eq!(found, [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let along_z = format!(
            "{BOX}, bottom = {{ inflow = [0.0, 0.0, 2.0] }}, top = \"outflow\"|motion = \"fixed\""
        );
        let found = directions("[1.0, 1.0, 1.0]", &along_z, "").unwrap();
        assert_eq!(found[..2], [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
        let chosen =
            directions("[1.0, 1.0, 1.0]", &along_z, "direction = [0.0, -3.0, 4.0]").unwrap();
        assert_eq!(chosen, [[0.0, -0.6, 0.8]; 4]);
    }

    #[test]
    fn drag_direction_without_stream() {
        let moved = format!("{BOX}|motion = {{ prescribed = {{ velocity = [0.0, -1.0] }} }}");
        assert_eq!(directions("[1.0, 1.0]", &moved, "").unwrap()[0], [0.0, 1.0, 0.0]);
        let sinks = format!("{BOX}, bottom = \"slip\", top = \"slip\"|motion = \"free\"");
        assert_eq!(directions("[1.0, 1.0, 1.0]", &sinks, "").unwrap()[0], [0.0, 0.0, 1.0]);
        let said = directions("[1.0, 1.0]", &format!("{BOX}|motion = \"fixed\""), "").unwrap_err();
        assert!(
            said.contains("measure.0.kind") && said.contains("direction = [1.0, 0.0]"),
            "{said}"
        );
    }
}
