//! The vortex of Taylor and Green, as a case begins with it.

use crate::support::{PERIODIC, box_case, petsc};
use mics::scene::Scene;
use std::f64::consts::TAU;

/// The fluid's energy over that of the start after steps to the time `end` at the Courant number
/// `courant`, and how many these were.
fn kept<const D: usize>(text: &str, end: f64, courant: f64) -> (f64, usize) {
    let petsc = petsc();
    let mut scene: Scene<D> = petsc.scene(text);
    let (start, _) = scene.energy_and_speed().unwrap();
    let dt = scene.limits().unwrap().step_for(courant);
    let steps = (end / dt).ceil();
    (0..steps as usize).for_each(|_| _ = scene.step(end / steps).unwrap());
    (scene.energy_and_speed().unwrap().0 / start, steps as usize)
}

/// In two dimensions it only decays, `exp(-2 nu (kx^2 + ky^2) t)` of its energy: on 96^2 cells
/// within 3e-6 in steps of a Courant number of 0.5, 2e-5 in short ones, of which central diffusion
/// has the most.
#[test]
fn vortex_energy_decay_in_2d_in_square_and_oblong_boxes() {
    for size in [[TAU, TAU], [TAU, 2.0 * TAU]] {
        let more = "[initial]\ntaylor_green = 1.0\n[time]\nend = 2.0\ncfl = 0.5\nscheme = \"rk2\"";
        let text = box_case(size, [96, 96], 0.01, PERIODIC, more);
        let (found, steps) = kept::<2>(&text, 2.0, 0.5);
        let waves: f64 = size.iter().map(|l| (TAU / l).powi(2)).sum();
        let exact = (-2.0 * 0.01 * waves * 2.0_f64).exp();
        println!("{size:?}: {found:.6} in {steps} steps, exact {exact:.6}");
        assert!((found / exact - 1.0).abs() < 1e-4);
    }
}

/// Re = 100. The energy at t = 1 is 0.939851 of that of the start, extrapolated from 32^3, 64^3 and
/// 128^3 cells in small steps, of order 2. Of its error in 22 steps nine tenths were the start
/// without a pressure and what faces had of it beyond the cells.
#[test]
fn vortex_energy_in_3d_with_long_steps() {
    let side = "\"periodic\"";
    let case = |n: usize, scheme: &str| {
        let more =
            format!("[initial]\ntaylor_green = 1.0\n[time]\nend = 1.0\nscheme = \"{scheme}\"");
        box_case([TAU, TAU], [n, n], 0.01, PERIODIC, &more)
            .replace(&format!("{:?}", [TAU, TAU]), &format!("{:?}", [TAU; 3]))
            .replace(&format!("{:?}", [n, n]), &format!("{:?}", [n; 3]))
            .replace("[boundary]", &format!("[boundary]\nbottom = {side}\ntop = {side}"))
    };
    for (scheme, courant, most) in [("rk2", 0.5, 23), ("rk3", 0.7, 16)] {
        let (found, steps) = kept::<3>(&case(64, scheme), 1.0, courant);
        println!("{scheme}: {found:.6} in {steps} steps, off by {:.1e}", found / 0.939851 - 1.0);
        assert!((found / 0.939851 - 1.0).abs() < 1e-4 && steps <= most, "{steps}");
    }
}
