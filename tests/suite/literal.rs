//! Eq. (19) as the paper prints it, against sums written out by hand.

use crate::support::{PERIODIC, box_case, petsc};
use mics::method::Kind;
use mics::scene::Scene;
use nalgebra::Vector3;

/// Cells along each side of the box of 1 m.
const N: usize = 32;
const H: f64 = 1.0 / N as f64;
const RADIUS: f64 = 0.13;
/// Off the grid's symmetries.
const CENTRE: [f64; 2] = [0.513, 0.481];
const VISCOSITY: f64 = 0.07;
/// Rate of the stagnation flow u = (A x, -A y) about the box's middle (1/s).
const RATE: f64 = 1.3;

/// The fraction of the disc in a cell, by 400 strips of exact length.
fn fraction(i: usize, j: usize) -> f64 {
    const STRIPS: usize = 400;
    let low = [i as f64 * H - CENTRE[0], j as f64 * H - CENTRE[1]];
    let strip = |k: usize| {
        let y = low[1] + (k as f64 + 0.5) * H / STRIPS as f64;
        let half = (RADIUS * RADIUS - y * y).max(0.0).sqrt();
        (half.min(low[0] + H) - (-half).max(low[0])).max(0.0)
    };
    (0..STRIPS).map(strip).sum::<f64>() / (STRIPS as f64 * H)
}

struct Sums {
    convective: Vector3<f64>,
    pressure: Vector3<f64>,
    viscous: Vector3<f64>,
    torque: Vector3<f64>,
}

/// The three parts of (19) and the moment of (18) in a stagnation flow, cell by cell: `-u.grad u =
/// -A^2 (x, y)`, the gradient of the pressure at cells, and `div( mu e )/rho` with `e = diag(2A,
/// -2A)`, so that only the gradient of the mixture's mu counts.
fn by_hand(density: f64, inner_viscosity: f64, pressure: &dyn Fn(usize, usize) -> f64) -> Sums {
    let alpha = |i: usize, j: usize| fraction(i, j);
    let mu = |i: usize, j: usize| VISCOSITY + alpha(i, j) * (inner_viscosity - VISCOSITY);
    let zero = Vector3::zeros;
    let mut sums = Sums { convective: zero(), pressure: zero(), viscous: zero(), torque: zero() };
    for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
        let alpha = alpha(i, j);
        if alpha < 1e-9 {
            continue;
        }
        let rho = 1.0 + alpha * (density - 1.0);
        let centre = Vector3::new((i as f64 + 0.5) * H, (j as f64 + 0.5) * H, 0.0);
        let convective = -RATE * RATE * (centre - Vector3::new(0.5, 0.5, 0.0));
        let slope = |f: &dyn Fn(usize, usize) -> f64| {
            Vector3::new(f(i + 1, j) - f(i - 1, j), f(i, j + 1) - f(i, j - 1), 0.0) / (2.0 * H)
        };
        let (grad_p, grad_mu) = (slope(pressure), slope(&mu));
        let viscous = 2.0 * RATE / rho * Vector3::new(grad_mu.x, -grad_mu.y, 0.0);
        let share = alpha * H * H * density;
        sums.convective += share * convective;
        sums.pressure -= share / rho * grad_p;
        sums.viscous += share * viscous;
        if alpha < 1.0 - 1e-9 {
            let arm = centre - Vector3::new(CENTRE[0], CENTRE[1], 0.0);
            sums.torque += arm.cross(&(share * (convective - grad_p / rho + viscous)));
        }
    }
    sums
}

#[test]
fn literal_force_of_eq_19_equals_sum_over_cells() {
    let petsc = petsc();
    for density in [1.0, 1.2, 2.65, 1000.0] {
        let more = format!(
            "preset = \"mics-2003\"\ncoupling.fraction = \"exact\"\ncoupling.mix_pressure = false\n\
             time = {{ end = 1.0, advection = \"upwind5\" }}\n\
                 pressure.divergence_limit = 1e-9\n\
             [[particle]]\nshape = {{ disc = {{ diameter = {:?} }} }}\nposition = {CENTRE:?}\n\
             density = {density:?}\n\
             viscosity = 0.01",
            2.0 * RADIUS
        );
        // Top-level keys come before the tables.
        let (keys, tables) = more.split_once("[[particle]]").unwrap();
        let text =
            box_case([1.0, 1.0], [N, N], VISCOSITY, PERIODIC, "[time]").replace("[time]\n", "");
        let text = text.replacen('\n', &format!("\n{keys}\n"), 1) + "[[particle]]" + tables;
        let mut scene: Scene<2> = petsc.scene(&text);
        for c in scene.domain.grid.rows().flatten() {
            let at = scene.domain.grid.centre(c);
            let u = [RATE * (at[0] - 0.5), -RATE * (at[1] - 0.5)];
            for axis in 0..2 {
                let to_face = 0.5 * scene.domain.grid.h[axis] * u[axis] / (at[axis] - 0.5);
                scene.state.u[axis][c] = u[axis];
                scene.state.faces[axis][c] = u[axis] - to_face;
            }
        }
        scene.step(1e-4).unwrap();
        let values = scene.gather(&scene.state.p).unwrap();
        let hand = by_hand(density, 0.01, &|i, j| values[j * N + i]);
        assert_eq!(scene.method.kind(), Kind::Mixing);
        let found = scene.state.exchange[0];
        let scale = hand.convective.norm() + hand.pressure.norm() + hand.viscous.norm();
        for (name, found, hand) in [
            ("convective", found.convective, hand.convective),
            ("pressure", found.pressure, hand.pressure),
            ("viscous", found.viscous, hand.viscous),
            ("torque", found.literal_torque, hand.torque),
        ] {
            println!("s = {density}, {name}: {found:?} by hand {hand:?}");
            assert!(
                (found - hand).norm() < 2e-4 * scale,
                "s = {density}, {name}: {found:?}, by hand {hand:?}"
            );
        }
    }
}
