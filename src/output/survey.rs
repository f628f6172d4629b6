//! Numbers of the whole box that measures take after a step: flow rate, drop of the pressure, what
//! bodies fill.
//!
//! ```text
//!   mean(U) over all faces along an axis = (1/V) ( integral of u over the fluid + sum_k V_k v_k )
//!              the mixture's, as the drive holds it
//!   superficial velocity                 = mean(U) - sum_k V_k v_k/V
//!   transport rate                       = sum_k V_k v_k/L
//!              through a cross-section, in the mean over the length L of the box
//! ```

use super::bed;
use crate::Result;
use crate::config::{Measure, MeasureKind};
use crate::drive::{box_volume, mean};
use crate::scene::Scene;

/// Value of a measure of the whole box in the state as it is; 0 for a measure of another kind.
/// Collective.
///
/// # Errors
/// When ranks cannot sum.
pub fn survey<const D: usize>(
    scene: &Scene<D>,
    m: &Measure,
    scratch: &mut Vec<f64>,
) -> Result<f64> {
    let domain = &scene.domain;
    let s = &scene.state;
    let grid = &domain.grid;
    let axis = m.axis();
    let volume = box_volume(grid);
    let carried = || s.bodies.iter().map(|b| b.volume() * b.velocity[axis]).sum::<f64>();
    Ok(match m.kind {
        MeasureKind::SuperficialVelocity => {
            mean(&domain.session, grid, axis, &s.faces)? - carried() / volume
        }
        MeasureKind::FlowRate => {
            mean(&domain.session, grid, axis, &s.faces)? * volume / grid.size[axis]
        }
        MeasureKind::PressureDrop => {
            pressure_drop(scene, axis)? + s.drive.map_or(0.0, |force| force[axis]) * grid.size[axis]
        }
        MeasureKind::DriveForce => s.drive.map_or(0.0, |force| force[axis]),
        MeasureKind::SolidFraction => solid_fraction(scene, m)?,
        MeasureKind::BedHeight => bed::height(scene, m, scratch)?,
        MeasureKind::BedShearStress => bed::shear_stress(scene, m, scratch)?,
        MeasureKind::Shields => bed::shields(scene, m, scratch)?,
        MeasureKind::BedloadRate => bed::load_rate(scene, m),
        MeasureKind::Einstein => bed::einstein(scene, m),
        MeasureKind::TransportRate => {
            let carried = s
                .bodies
                .iter()
                .filter(|b| m.group().any(|id| id == b.id))
                .map(|b| b.volume() * b.velocity[axis]);
            carried.sum::<f64>() / grid.size[axis]
        }
        MeasureKind::FluidEnergy => s.energy.fluid,
        MeasureKind::Dissipation | MeasureKind::DissipationTime => {
            s.energy.fluid / (domain.fluid.density * volume)
        }
        MeasureKind::BodyEnergy => s.energy.bodies,
        _ => 0.0,
    })
}

/// The mean pressure at the low side of the box along an axis, less that at the high one (Pa), each
/// on the line through two layers of cells; nothing along a periodic axis. Collective.
fn pressure_drop<const D: usize>(scene: &Scene<D>, axis: usize) -> Result<f64> {
    let grid = &scene.domain.grid;
    let p = &scene.state.p;
    if grid.periodic[axis] {
        return Ok(0.0);
    }
    let layer = grid.total_cells() / grid.cells[axis];
    let weight = |at: usize| match (at, grid.cells[axis] - 1 - at) {
        (0, _) => 1.5,
        (1, _) => -0.5,
        (_, 0) => -1.5,
        (_, 1) => 0.5,
        _ => 0.0,
    };
    let of_cell = |c: usize| weight(grid.global_cell(c)[axis]) * p[c];
    let mut sum = [grid.rows().flatten().map(of_cell).sum::<f64>() / layer as f64];
    scene.domain.session.sum(&mut sum)?;
    Ok(sum[0])
}

/// Solid fraction of a region: cells count whose centres lie in it. Collective.
fn solid_fraction<const D: usize>(scene: &Scene<D>, m: &Measure) -> Result<f64> {
    let grid = &scene.domain.grid;
    let within = |c: usize| match &m.region {
        None => true,
        Some(region) => {
            (0..D).all(|a| (region.min[a]..=region.max[a]).contains(&grid.centre(c)[a]))
        }
    };
    let cells = match &m.region {
        None => grid.rows().map(|row| row.len()).sum(),
        Some(_) => grid.rows().flatten().filter(|c| within(*c)).count(),
    };
    let filled = scene.method.overlaps().filter(|o| within(o.cell)).map(|o| o.fraction);
    let mut sums = [filled.sum::<f64>(), cells as f64];
    scene.domain.session.sum(&mut sums)?;
    Ok(if sums[1] > 0.0 { sums[0] / sums[1] } else { 0.0 })
}
