//! The snapshots of a scene ([`mics_run::snapshot`]): what they hold, written and taken.

use super::vti::{Writer, head};
use crate::Result;
use crate::grid::Coefficient;
use crate::particles::Body;
use crate::scene::{self, Scene};
use mics_run::snapshot::{Array, Snapshot};
use mics_run::vti::Head;
use nalgebra::Vector3;
use std::path::Path;

/// The arrays of a scene's snapshots, with their components, in their order.
fn listed<const D: usize>(scene: &Scene<D>) -> Vec<(&'static str, usize)> {
    let vorticity = if D == 2 { 1 } else { 3 };
    let mut arrays = vec![("velocity", 3), ("pressure", 1), ("vorticity", vorticity)];
    if D == 3 {
        arrays.push(("q", 1));
    }
    if !scene.state.bodies.is_empty() {
        arrays.push(("solid_fraction", 1));
    }
    if let Coefficient::Field(_) = scene.method.mixture().density {
        arrays.push(("density", 1));
    }
    arrays
}

/// Hands the arrays of [`listed`] to `take`, one after the other, as fields of their components.
/// Collective.
fn each<const D: usize>(
    scene: &mut Scene<D>,
    mut take: impl FnMut(&Scene<D>, &str, &[&[f64]]) -> Result<()>,
) -> Result<()> {
    scene.domain.boundaries.fill_velocity(&mut scene.state.u)?;
    let scene = &*scene;
    let grid = &scene.domain.grid;
    let bodies = &scene.state.bodies;
    let own = |field: &mut [f64], motion: &dyn Fn(&Body, &Vector3<f64>) -> f64| {
        for (body, overlaps) in bodies.iter().zip(scene.method.overlaps_by_body()) {
            let inside = overlaps.iter().filter(|o| o.is_inside());
            inside.for_each(|o| field[o.cell] = motion(body, &o.arm));
        }
    };
    let mut parts = scene.state.u.to_vec();
    for (axis, part) in parts.iter_mut().enumerate() {
        own(part, &|body, arm| body.velocity_at(arm)[axis]);
    }
    take(scene, "velocity", &slices(&parts))?;
    take(scene, "pressure", &[&scene.state.p])?;

    let slope = |c: usize, i: usize, axis: usize| {
        let u = &scene.state.u[i];
        (u[c + grid.stride[axis]] - u[c - grid.stride[axis]]) / (2.0 * grid.h[axis])
    };
    // (vector part, derivative's axis, of component): omega = d(of)/d(axis) - d(axis)/d(of).
    let planes: &[(usize, usize)] = if D == 2 { &[(0, 1)] } else { &[(1, 2), (2, 0), (0, 1)] };
    parts.resize(planes.len(), Vec::new());
    for (part, &(a, b)) in parts.iter_mut().zip(planes) {
        for c in grid.rows().flatten() {
            part[c] = slope(c, b, a) - slope(c, a, b);
        }
        own(part, &|body, _| 2.0 * body.spin[3 - a - b]);
    }
    take(scene, "vorticity", &slices(&parts))?;
    let mut field = parts.swap_remove(0);
    if D == 3 {
        // Q = -(du_i/dx_j du_j/dx_i)/2: positive where the flow turns more than it strains (Hunt,
        // Wray & Moin 1988).
        for c in grid.rows().flatten() {
            let pairs = (0..D).flat_map(|i| (0..D).map(move |j| (i, j)));
            field[c] = -0.5 * pairs.map(|(i, j)| slope(c, i, j) * slope(c, j, i)).sum::<f64>();
        }
        own(&mut field, &|body, _| body.spin.norm_squared());
        take(scene, "q", &[&field])?;
    }
    if !bodies.is_empty() {
        field.fill(0.0);
        scene.method.overlaps().for_each(|o| field[o.cell] += o.fraction);
        take(scene, "solid_fraction", &[&field])?;
    }
    if let Coefficient::Field(density) = &scene.method.mixture().density {
        take(scene, "density", &[density])?;
    }
    Ok(())
}

/// Fields as slices of their values.
pub(super) fn slices(fields: &[Vec<f64>]) -> Vec<&[f64]> {
    fields.iter().map(Vec::as_slice).collect()
}

/// Writes a scene's snapshot; every rank its own cells. Collective.
///
/// # Errors
/// When it cannot be written.
pub fn write<const D: usize>(scene: &mut Scene<D>, path: &Path) -> Result<()> {
    let head = head(&scene.domain.grid, scene.state.time, &listed(scene));
    let session = scene.domain.session.clone();
    let mut file = Writer::begin(&session, path, head)?;
    each(scene, |scene, name, parts| {
        file.put(&scene.domain.grid, name, parts);
        Ok(())
    })?;
    file.commit()
}

/// Bytes of the values of a scene's snapshot; computes it, so that its memory is in use as in a
/// run. Collective.
///
/// # Errors
/// When ranks cannot exchange their ghosts.
pub fn bytes<const D: usize>(scene: &mut Scene<D>) -> Result<f64> {
    each(scene, |_, _, _| Ok(()))?;
    let numbers: usize = listed(scene).iter().map(|(_, components)| components).sum();
    Ok((8 * numbers * scene.domain.grid.total_cells()) as f64)
}

/// Gathers the fields on rank 0 (elsewhere the arrays are empty). Collective.
pub fn take<const D: usize>(scene: &mut Scene<D>) -> Result<Snapshot> {
    let Head { time, cells, h, arrays: listed } =
        head(&scene.domain.grid, scene.state.time, &listed(scene));
    let mut arrays = Vec::with_capacity(listed.len());
    each(scene, |scene, name, parts| {
        let parts =
            parts.iter().map(|part| scene::gather(scene, part)).collect::<Result<Vec<_>>>()?;
        arrays.push(if parts.len() == 1 {
            Array::scalar(name, parts.concat())
        } else {
            Array::vector(name, parts)
        });
        Ok(())
    })?;
    Ok(Snapshot { time, cells, h, arrays })
}
