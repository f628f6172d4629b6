//! The pressure equation by itself: order across a density jump, and every density ratio solved.

use crate::support::{Petsc, box_case, order, petsc};
use mics::grid::Coefficient;
use mics::kernels::faces::{self, FaceCoefficient};
use mics::method::flow::Flow;
use mics::poisson::pressure::Accuracy;
use mics::scene::Scene;
use std::f64::consts::PI;

/// A box at rest whose mixture has the density `rho(x, y)`.
fn box_with_density(
    petsc: &Petsc,
    n: usize,
    sides: [&str; 4],
    limit: f64,
    rho: impl Fn(f64, f64) -> f64,
) -> Scene<2> {
    let more = format!("[pressure]\nsolver = \"multigrid\"\ndivergence_limit = {limit:e}");
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [n, n], 0.0, sides, &more));
    let mut density = scene.domain.grid.field();
    for c in scene.domain.grid.rows().flatten() {
        let [x, y] = scene.domain.grid.centre(c);
        density[c] = rho(x, y);
    }
    scene.domain.boundaries.fill_property(&mut density).unwrap();
    let (density, grid) = (Coefficient::Field(density), &scene.domain.grid);
    let Some(flow) = scene.method.downcast_mut::<Flow<2>>() else { panic!("there are no bodies") };
    flow.beta = FaceCoefficient::new(grid, &density);
    flow.beta.update(grid, &density);
    flow.mixture.density = density;
    scene.domain.projection.assemble(grid, &flow.beta).unwrap();
    scene
}

/// Largest errors of the potential away from the jump (two cells and more) for `phi = rho s(x)
/// cos(2 pi y)`, `s = sin(pi (x - 1/2))`: the flux `(1/rho) grad phi` is continuous across x = 1/2.
fn jump_error(n: usize, ratio: f64) -> f64 {
    let petsc = petsc();
    let sides = ["\"wall\"", "\"wall\"", "\"periodic\"", "\"periodic\""];
    let rho = |x: f64| if x < 0.5 { 1.0 } else { ratio };
    let mut scene = box_with_density(&petsc, n, sides, 1e-9, |x, _| rho(x));
    let grid = scene.domain.grid.clone();
    for axis in 0..2 {
        for c in grid.face_rows(axis).flatten() {
            let [mut x, mut y] = grid.centre(c);
            if axis == 0 {
                x -= 0.5 * grid.h[0]
            } else {
                y -= 0.5 * grid.h[1]
            }
            let (s, slope) = ((PI * (x - 0.5)).sin(), PI * (PI * (x - 0.5)).cos());
            scene.state.faces[axis][c] = if axis == 0 {
                slope * (2.0 * PI * y).cos()
            } else {
                -2.0 * PI * s * (2.0 * PI * y).sin()
            };
        }
    }
    let done = scene.domain.project(scene.method.beta(), &mut scene.state, 1.0).unwrap();
    assert!(done.divergence_max < 1e-9);
    let exact = |[x, y]: [f64; 2]| rho(x) * (PI * (x - 0.5)).sin() * (2.0 * PI * y).cos();
    let away =
        || grid.rows().flatten().filter(|&c| (grid.centre(c)[0] - 0.5).abs() > 2.0 * grid.h[0]);
    // The potential is known but for a constant, which the light side shows best.
    let light: Vec<f64> = away()
        .filter(|&c| grid.centre(c)[0] < 0.5)
        .map(|c| scene.state.p[c] - exact(grid.centre(c)))
        .collect();
    let constant = light.iter().sum::<f64>() / light.len() as f64;
    let error = |c: usize| {
        (scene.state.p[c] - constant - exact(grid.centre(c))).abs() / rho(grid.centre(c)[0])
    };
    away().map(error).fold(0.0, f64::max)
}

#[test]
fn poisson_density_jump_of_1000_second_order() {
    let e = [16, 32, 64, 128].map(|n| jump_error(n, 1000.0));
    let orders: Vec<f64> = e.windows(2).map(|w| order(w[0], w[1], 2.0)).collect();
    println!("errors {e:?}, orders {orders:.2?}");
    assert!(orders.iter().all(|o| *o >= 1.9), "{e:?} {orders:?}");
}

#[test]
fn poisson_density_ratios_1e_3_to_1e4_solved_to_d0() {
    for ratio in [1e-3, 1e-2, 0.1, 0.5, 2.65, 10.0, 100.0, 1e3, 1e4] {
        for sides in [["\"wall\""; 4], ["\"wall\"", "\"outflow\"", "\"periodic\"", "\"periodic\""]]
        {
            let petsc = petsc();
            let mut scene = box_with_density(&petsc, 64, sides, 1e-8, |x, y| {
                let inside = [(0.3, 0.4), (0.7, 0.55), (0.45, 0.75)]
                    .iter()
                    .any(|(a, b)| (x - a).hypot(y - b) < 0.12);
                if inside { ratio } else { 1.0 }
            });
            let grid = scene.domain.grid.clone();
            for axis in 0..2 {
                for c in grid.face_rows(axis).flatten() {
                    let [x, y] = grid.centre(c);
                    scene.state.faces[axis][c] = ((7.0 + axis as f64) * x).sin() * (11.0 * y).cos();
                }
            }
            scene.domain.boundaries.set_faces(&mut scene.state.faces);
            let (b, p, u) = (&scene.method.beta(), &mut scene.state.p, &mut scene.state.faces);
            let done = scene
                .domain
                .projection
                .project(&grid, &mut scene.domain.boundaries, b, 0.01, p, u, Accuracy::Full)
                .unwrap();
            let mut divergence = grid.field();
            faces::divergence(&grid, &scene.state.faces, &mut divergence);
            let largest = grid.rows().flatten().map(|c| divergence[c].abs()).fold(0.0, f64::max);
            assert!(done.divergence_max < 1e-8 && largest < 1e-8, "{ratio} {sides:?}: {largest:e}");
            assert_eq!(done.retries, 0, "{ratio} {sides:?}");
            assert!(done.outer <= 3, "{ratio} {sides:?}: {} iterations of C-HSMAC", done.outer);
        }
    }
}
