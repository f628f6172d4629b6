//! Numbers of a bed under a stream along an axis, gravity across it.
//!
//! ```text
//!   bed height    h_b: where the solid fraction of layers falls to a threshold
//!   shear stress  tau = f (H - h_b) + tau_top - rho H dU/dt
//!              f: force of the drive, H: height of the box, tau_top: shear of the side above on
//!              the fluid, U: mean velocity that a drive over time holds (the balance of momentum
//!              of the flow over the bed, periodic along the stream; Kidanemariam & Uhlmann 2014)
//!                 tau = (sum_k F_k - F_side)/A       A: plan area, F_k: force on bodies over it,
//!              F_side: force of the side below on the fluid (the total stress on a rough bed,
//!              Nikora et al. 2007)
//!   load rate     q = sum_k V_k v_k/A
//!   Shields       tau/((rho_s - rho) g d)            Shields 1936
//!   Einstein      q/sqrt((rho_s/rho - 1) g d^3)      Einstein 1942
//! ```
//! Forces are those of the fluid without buoyancy, that in the mean gradient of the pressure by the
//! drive included. The density and the diameter of grains, rho_s and d, are means over them.

use crate::Result;
use crate::config::{Measure, MeasureKind};
use crate::domain::Domain;
use crate::particles::Body;
use crate::scene::Scene;
use nalgebra::Vector3;

/// The axis across a bed: gravity's, first among the axes that have sides.
fn upright<const D: usize>(domain: &Domain<D>) -> usize {
    let gravity = domain.fluid.gravity;
    let sided =
        Vector3::from_fn(|a, _| if a < D && !domain.grid.periodic[a] { gravity[a] } else { 0.0 });
    if sided == Vector3::zeros() { gravity.iamax() } else { sided.iamax() }
}

/// Whether a point (m) lies in the measure's region as seen from above, across the axis `up`.
fn is_over<const D: usize>(m: &Measure, up: usize, point: impl Fn(usize) -> f64) -> bool {
    let Some(region) = &m.region else { return true };
    (0..D).filter(|a| *a != up).all(|a| (region.min[a]..=region.max[a]).contains(&point(a)))
}

/// The force of the low (`side` 0) or high (1) side of the box across the axis `up` on the fluid
/// along the measure's axis (N), and the area of that side (m2), in the measure's region.
/// Collective.
fn side<const D: usize>(scene: &Scene<D>, m: &Measure, up: usize, side: usize) -> Result<[f64; 2]> {
    let domain = &scene.domain;
    let grid = &domain.grid;
    let u = &scene.state.u[m.axis()];
    let area = grid.cell_volume() / grid.h[up];
    let mut sums = [0.0; 2];
    for cell in grid.boundary_cells(up, side) {
        if is_over::<D>(m, up, |a| grid.centre(cell)[a]) {
            let ghost = if side == 0 { cell - grid.stride[up] } else { cell + grid.stride[up] };
            sums[0] += area * domain.fluid.viscosity * (u[ghost] - u[cell]) / grid.h[up];
            sums[1] += area;
        }
    }
    domain.session.sum(&mut sums)?;
    Ok(sums)
}

/// The plan area of the box (m2; m in 2D).
fn plan_area<const D: usize>(domain: &Domain<D>) -> f64 {
    let up = upright(domain);
    (0..D).filter(|a| *a != up).map(|a| domain.grid.size[a]).product()
}

/// The grains that a measure is of.
fn grains<'a, const D: usize>(
    scene: &'a Scene<D>,
    m: &'a Measure,
) -> impl Iterator<Item = &'a Body> {
    scene.state.bodies.iter().filter(|body| m.group().any(|id| id == body.id))
}

/// A mean over the grains that a measure is of.
fn mean<const D: usize>(scene: &Scene<D>, m: &Measure, of: impl Fn(&Body) -> f64) -> f64 {
    grains(scene, m).map(of).sum::<f64>() / grains(scene, m).count() as f64
}

/// The submerged density of the grains over the fluid's, s - 1, times gravity (m/s2), and their
/// diameter (m).
fn submerged<const D: usize>(scene: &Scene<D>, m: &Measure) -> [f64; 2] {
    let fluid = &scene.domain.fluid;
    let density = mean(scene, m, |grain| grain.density);
    let diameter = mean(scene, m, |grain| grain.shape().diameter());
    [(density / fluid.density - 1.0) * fluid.gravity.norm(), diameter]
}

/// The volume rate of grains per width (m2/s; the same in 2D).
pub fn load_rate<const D: usize>(scene: &Scene<D>, m: &Measure) -> f64 {
    let carried = grains(scene, m).map(|grain| grain.volume() * grain.velocity[m.axis()]);
    carried.sum::<f64>() / plan_area(&scene.domain)
}

/// Einstein's number of the grains.
pub fn einstein<const D: usize>(scene: &Scene<D>, m: &Measure) -> f64 {
    let [submerged, diameter] = submerged(scene, m);
    load_rate(scene, m) / (submerged * diameter.powi(3)).sqrt()
}

/// The Shields number of the grains. Collective.
pub fn shields<const D: usize>(
    scene: &Scene<D>,
    m: &Measure,
    layers: &mut Vec<f64>,
) -> Result<f64> {
    let [submerged, diameter] = submerged(scene, m);
    Ok(shear_stress(scene, m, layers)? / (scene.domain.fluid.density * submerged * diameter))
}

/// The shear stress on the bed (Pa). Collective.
pub fn shear_stress<const D: usize>(
    scene: &Scene<D>,
    m: &Measure,
    layers: &mut Vec<f64>,
) -> Result<f64> {
    let domain = &scene.domain;
    let s = &scene.state;
    let axis = m.axis();
    let up = upright(domain);
    let below = usize::from(domain.fluid.gravity[up] > 0.0);
    // The particles of a Shields number are grains, and not the bed.
    let listed = m.particles.is_some() && m.kind == MeasureKind::BedShearStress;
    if !listed && m.region.is_none() && domain.grid.periodic[axis] {
        let depth = domain.grid.size[up] - height_across(scene, m, up, layers)?;
        let [above, area] = side(scene, m, up, 1 - below)?;
        let drive = s.drive.map_or(0.0, |force| force[axis]);
        let held = if s.dt > 0.0 { domain.varying.held_acceleration(s.time, s.dt) } else { 0.0 };
        let accelerated = domain.fluid.density * domain.grid.size[up] * held;
        let above = if area > 0.0 { above / area } else { 0.0 };
        return Ok(drive * depth + above - accelerated);
    }
    let counts = |body: &Body| {
        let asked = !listed || m.group().any(|id| id == body.id);
        asked && is_over::<D>(m, up, |a| body.centre[a])
    };
    let bodies = s.bodies.iter().zip(&s.exchange).filter(|(body, _)| counts(body));
    let force: f64 = bodies.map(|(_, e)| e.momentum[axis]).sum();
    let [side, area] = side(scene, m, up, below)?;
    let side = if listed { 0.0 } else { side };
    Ok((force - side) / if area > 0.0 { area } else { plan_area(domain) })
}

/// The highest place, above the low end of the box against gravity, at which the solid fraction of
/// a layer of cells passes the measure's threshold (m), on the straight line between the middles of
/// two layers. Collective.
pub fn height<const D: usize>(scene: &Scene<D>, m: &Measure, layers: &mut Vec<f64>) -> Result<f64> {
    height_across(scene, m, m.axis(), layers)
}

/// The height of the bed over the low end of an axis. Collective.
fn height_across<const D: usize>(
    scene: &Scene<D>,
    m: &Measure,
    axis: usize,
    layers: &mut Vec<f64>,
) -> Result<f64> {
    let grid = &scene.domain.grid;
    layers.clear();
    layers.resize(grid.cells[axis], 0.0);
    let share = grid.cells[axis] as f64 / grid.total_cells() as f64;
    for o in scene.method.overlaps() {
        layers[grid.global_cell(o.cell)[axis]] += share * o.fraction;
    }
    scene.domain.session.sum(layers)?;
    if scene.domain.fluid.gravity[axis] > 0.0 {
        layers.reverse();
    }
    let h = grid.h[axis];
    let least = m.threshold.unwrap_or_default();
    let Some(top) = layers.iter().rposition(|fraction| *fraction >= least) else { return Ok(0.0) };
    let above = layers.get(top + 1).copied().unwrap_or(0.0);
    Ok(((top as f64 + 0.5 + (layers[top] - least) / (layers[top] - above)) * h)
        .min(grid.size[axis]))
}
