//! The plane in which a figure shows a 3D flow, and what of the flow lies in it.
//!
//! ```text
//!   across z: x to the right, y up      across y: x to the right, z up
//!   across x: y to the right, z up
//! ```

use mics_run::config::{Case, Motion, Section};
use mics_run::snapshot::{Array, Snapshot};

/// The axes to the right and up in a plane across `axis`.
pub fn axes(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

/// Sign of the vorticity along `axis` seen in the plane across it, where counterclockwise is
/// positive.
pub fn sense(axis: usize) -> f64 {
    if axis == 1 { -1.0 } else { 1.0 }
}

/// Where the figures of a case cut its flow: where it says; else along gravity, or the stream where
/// there is none, through the body that moves and is nearest to the middle of all that do, as they
/// lie with their centres at `place` (m).
pub fn sections(case: &Case, place: impl Fn(usize) -> [f64; 3]) -> Vec<Section> {
    if case.dimension() == 2 {
        return vec![Section::Z(0.0)];
    }
    if !case.output.planes.is_empty() {
        return case.output.planes.clone();
    }
    let axis = if leading(case) == Some(2) { 1 } else { 2 };
    let moves = |id: &usize| case.particle[*id].motion != Motion::Fixed;
    let all: Vec<usize> = (0..case.particle.len()).collect();
    let bodies: Vec<usize> =
        if all.iter().any(moves) { all.iter().copied().filter(moves).collect() } else { all };
    let mean = bodies.iter().map(|id| place(*id)[axis]).sum::<f64>() / bodies.len() as f64;
    let nearest = bodies
        .iter()
        .map(|id| place(*id)[axis])
        .min_by(|a, b| (a - mean).abs().total_cmp(&(b - mean).abs()));
    vec![Section::across(axis, nearest.unwrap_or(0.5 * case.domain.size[axis]))]
}

/// The axis along which most happens: gravity's where it moves something, else that of the stream,
/// else of a particle that is moved.
pub fn leading(case: &Case) -> Option<usize> {
    let largest = |v: &[f64]| {
        let sizes = v.iter().map(|c| c.abs()).enumerate().filter(|(_, size)| *size > 0.0);
        sizes.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(axis, _)| axis)
    };
    let told = case.particle.iter().find_map(|p| match &p.motion {
        Motion::Prescribed(told) => largest(&told.velocity)
            .or_else(|| told.oscillation.as_ref().and_then(|o| largest(&o.amplitude))),
        _ => None,
    });
    let pulled = upright(case).filter(|_| case.particle.iter().any(|p| p.is_free()));
    pulled.or_else(|| case.reference_velocity().and_then(|v| largest(&v))).or(told)
}

/// The layer of cells in which a plane lies: its axis, its number, and the coordinate of its middle
/// (m).
pub fn layer(section: Section, snapshot: &Snapshot) -> (usize, usize, f64) {
    let (axis, at) = section.place();
    let n = snapshot.cells[axis];
    let h = snapshot.h[axis];
    let cell = ((at / h) as usize).min(n - 1);
    (axis, cell, (cell as f64 + 0.5) * h)
}

/// A component of an array in a layer of cells across `axis`, the plane's first axis fastest.
pub fn component(array: &Array, cells: [usize; 3], axis: usize, cell: usize, k: usize) -> Vec<f64> {
    let [nx, ny, _] = cells;
    let strides = [1, nx, nx * ny];
    let [a, b] = axes(axis);
    let at = |i: usize, j: usize| cell * strides[axis] + i * strides[a] + j * strides[b];
    let k = k.min(array.components - 1);
    let rows = (0..cells[b]).flat_map(|j| (0..cells[a]).map(move |i| (i, j)));
    rows.map(|(i, j)| array.values[at(i, j) * array.components + k]).collect()
}

/// The axis that gravity acts along most; none without gravity.
pub fn upright(case: &Case) -> Option<usize> {
    let gravity = case.fluid.gravity.iter().map(|g| g.abs()).enumerate();
    gravity.filter(|(_, g)| *g > 0.0).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(axis, _)| axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mics_run::config::written;

    fn case(more: &str) -> Case {
        let body = |x: f64| {
            format!(
                "[[particle]]\nshape = {{ sphere = {{ diameter = 0.2 }} }}\n\
                position = [{x}, 0.3, 0.4]\ndensity = 3.0\n"
            )
        };
        written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 1.0, 1.5], cells = [8, 8, 12] \
            }}\n\
            boundary = {{ west = \"slip\", east = \"slip\", south = \"slip\", north = \"slip\", \
            bottom = \"slip\", top = \"slip\" }}\n\
            {more}\n{}{}",
            body(0.2),
            body(0.6)
        ))
        .unwrap()
    }

    #[test]
    fn default_plane_along_gravity_or_stream_through_body() {
        // They have moved since the start.
        let place = |id: usize| [0.2 + 0.4 * id as f64, 0.35 + 0.1 * id as f64, 0.65];
        let fluid =
            |gravity: &str| format!("fluid = {{ density = 2.0, viscosity = 0.1{gravity} }}");
        let of = |more: &str| sections(&case(more), place);
        assert_eq!(of(&fluid(", gravity = [0.0, 0.0, -9.81]")), [Section::Y(0.35)]);
        assert_eq!(of(&fluid(", gravity = [0.0, -9.81, 0.0]")), [Section::Z(0.65)]);
        let along_z = format!("{}\ninitial.velocity = [0.0, 0.0, 1.0]", fluid(""));
        assert_eq!(of(&along_z), [Section::Y(0.35)]);
        let asked = format!("{}\noutput.planes = [{{ x = 0.3 }}, {{ z = 0.1 }}]", fluid(""));
        assert_eq!(of(&asked), [Section::X(0.3), Section::Z(0.1)]);
        assert_eq!("x = 0.3".parse(), Ok(Section::X(0.3)));
        assert!("w=0.3".parse::<Section>().unwrap_err().contains("z=0.02"));
    }

    #[test]
    fn section_layer_across_any_axis() {
        let cells = [2, 3, 4];
        let values = (0..24).flat_map(|c| [f64::from(c), -f64::from(c)]).collect();
        let array = Array { name: "a".into(), components: 2, values };
        assert_eq!(component(&array, cells, 2, 1, 0), [6.0, 7.0, 8.0, 9.0, 10.0, 11.0]);
        assert_eq!(
            component(&array, cells, 1, 2, 1),
            [-4.0, -5.0, -10.0, -11.0, -16.0, -17.0, -22.0, -23.0]
        );
        assert_eq!(component(&array, cells, 0, 1, 0)[..4], [1.0, 3.0, 5.0, 7.0]);
    }
}
