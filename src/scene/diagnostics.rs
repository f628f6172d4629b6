//! Diagnostics of a scene's fields: the energy, values that are not finite, whole fields.

use super::Scene;
use crate::error::NotFinite;
use crate::grid::{Coefficient, largest, simd, total};
use crate::method::energy;
use crate::{Error, Result};

/// Kinetic energy (J; per metre of depth in 2D) and speed of all ranks.
pub(super) struct Energies {
    /// Kinetic energy of all cells, those inside bodies included.
    pub all_cells: f64,
    /// Kinetic energy inside the bodies, where the density is one number.
    pub inside: f64,
    /// The largest speed of the fluid, of cells outside the bodies (m/s).
    pub largest_speed: f64,
}

/// Kinetic energy of all cells and inside the bodies, and the largest speed. Collective.
///
/// # Errors
/// As [`Scene::energy_and_speed`].
pub(super) fn energies<const D: usize>(scene: &mut Scene<D>) -> Result<Energies> {
    let inside = energy::inside(&scene.domain, &scene.state.u, &*scene.method);
    let within = take_inside(scene);
    let (sum, most) = squares(scene);
    let sum = sum + within;
    put_inside_back(scene);
    let mut sums = [sum * (0.5 * scene.domain.grid.cell_volume()), inside];
    let mut fastest = [most];
    scene.domain.session.sum_and_max(&mut sums, &mut fastest)?;
    let [all_cells, inside] = sums;
    if !all_cells.is_finite() {
        return Err(name_what_is_lost(scene)?);
    }
    Ok(Energies { all_cells, inside, largest_speed: fastest[0].sqrt() })
}

/// Sets the velocity of the cells inside the bodies to zero, keeps what it was, and returns the
/// sum of density times its square.
fn take_inside<const D: usize>(scene: &mut Scene<D>) -> f64 {
    let Scene { method, state, inside, .. } = scene;
    let density = &method.mixture().density;
    let mut sum = 0.0;
    inside.clear();
    for o in method.overlaps().filter(|o| o.is_inside()) {
        let u: [f64; D] = std::array::from_fn(|a| std::mem::take(&mut state.u[a][o.cell]));
        sum += density.at(o.cell) * u.iter().map(|u| u * u).sum::<f64>();
        inside.push((o.cell, u));
    }
    // Bodies move on, and a step allocates nothing.
    if inside.capacity() < inside.len() + inside.len() / 4 {
        inside.reserve(inside.len());
    }
    sum
}

/// Undoes `take_inside`, last cells first: one that two bodies fill was taken out twice.
fn put_inside_back<const D: usize>(scene: &mut Scene<D>) {
    while let Some((cell, u)) = scene.inside.pop() {
        (0..D).for_each(|a| scene.state.u[a][cell] = u[a]);
    }
}

/// Over this rank's cells, the sum of density times squared velocity and the largest squared
/// velocity.
fn squares<const D: usize>(scene: &Scene<D>) -> (f64, f64) {
    let grid = &scene.domain.grid;
    let u = &scene.state.u;
    let mixture = scene.method.mixture();
    simd(
        #[inline(always)]
        || {
            let mut sum = 0.0;
            let mut most = 0.0f64;
            for row in grid.rows() {
                let u: [&[f64]; D] = std::array::from_fn(|a| &u[a][row.clone()]);
                sum += match &mixture.density {
                    Coefficient::Uniform(rho) => {
                        let squares = total(
                            row.len(),
                            #[inline(always)]
                            |i| square(&u, i),
                        );
                        rho * squares
                    }
                    Coefficient::Field(rho) => {
                        let rho = &rho[row.clone()];
                        total(
                            row.len(),
                            #[inline(always)]
                            |i| rho[i] * square(&u, i),
                        )
                    }
                };
                let in_row = largest(
                    row.len(),
                    #[inline(always)]
                    |i| square(&u, i),
                );
                most = most.max(in_row);
            }
            (sum, most)
        },
    )
}

/// Squared velocity of a cell of a row, by the components there.
#[inline(always)]
fn square<const D: usize>(u: &[&[f64]; D], i: usize) -> f64 {
    let mut sum = 0.0;
    for u in u {
        sum += u[i] * u[i];
    }
    sum
}

/// The error for a value that is not finite, with the first cell that holds one; without one,
/// the first particle. Collective.
pub fn name_what_is_lost<const D: usize>(scene: &Scene<D>) -> Result<Error> {
    let fields: Vec<&[f64]> =
        scene.state.u.iter().chain([&scene.state.p]).map(Vec::as_slice).collect();
    let found = (0..fields.len()).find_map(|k| {
        scene.domain.grid.rows().flatten().find(|&c| !fields[k][c].is_finite()).map(|c| (k, c))
    });
    // The highest rank that found one speaks for all.
    let rank = scene.domain.session.rank() as f64;
    let mut speaker = [if found.is_some() { rank } else { -1.0 }];
    scene.domain.session.max(&mut speaker)?;
    let mut place = [0.0; 7];
    if let Some((field, c)) = found.filter(|_| speaker[0] == rank) {
        place[0] = field as f64;
        for a in 0..D {
            place[1 + a] = scene.domain.grid.global_cell(c)[a] as f64;
            place[4 + a] = scene.domain.grid.centre(c)[a];
        }
    }
    scene.domain.session.sum(&mut place)?;
    if speaker[0] < 0.0 {
        let lost = scene.state.bodies.iter().find(|body| !body.is_finite());
        let lost = lost.map_or(NotFinite::Energy, |body| NotFinite::Particle(body.id));
        return Ok(Error::NotFinite(lost));
    }
    let names =
        ["the velocity along x", "the velocity along y", "the velocity along z", "the pressure"];
    Ok(Error::NotFinite(NotFinite::Cell {
        field: if place[0] as usize == D { names[3] } else { names[place[0] as usize] },
        cell: place[1..1 + D].iter().map(|i| *i as usize).collect(),
        at: place[4..4 + D].to_vec(),
    }))
}

/// The owned cells of all ranks, x fastest, on rank 0 (empty elsewhere). Collective.
pub fn gather<const D: usize>(scene: &Scene<D>, field: &[f64]) -> Result<Vec<f64>> {
    let grid = &scene.domain.grid;
    let mut bytes: Vec<f64> =
        (0..D).flat_map(|a| [grid.start[a] as f64, grid.local[a] as f64]).collect();
    grid.rows().for_each(|row| bytes.extend_from_slice(&field[row]));
    let mut whole =
        if scene.domain.session.rank() == 0 { vec![0.0; grid.total_cells()] } else { Vec::new() };
    scene.domain.session.gather(&bytes, |_, part| {
        let (head, values) = part.split_at(2 * D);
        let (start, local): ([usize; D], [usize; D]) = (
            std::array::from_fn(|a| head[2 * a] as usize),
            std::array::from_fn(|a| head[2 * a + 1] as usize),
        );
        for (k, row) in values.chunks_exact(local[0]).enumerate() {
            let mut rest = k;
            let mut at = start[0];
            let mut stride = grid.cells[0];
            for a in 1..D {
                at += (start[a] + rest % local[a]) * stride;
                rest /= local[a];
                stride *= grid.cells[a];
            }
            whole[at..at + local[0]].copy_from_slice(row);
        }
    })?;
    Ok(whole)
}
