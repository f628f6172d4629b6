//! Sharp walls: where they are, and what they do to particles.

use crate::support::{PERIODIC, box_case, petsc};
use mics::scene::Scene;
use std::f64::consts::PI;

const WALLS: [&str; 4] = ["\"wall\"", "\"wall\"", "\"wall\"", "\"wall\""];
const SHARP: &str = "[coupling]\nwall = \"sharp\"\n";

fn disc(diameter: f64, place: [f64; 2], density: f64, more: &str) -> String {
    format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = {diameter:?} }} }}\nposition = {place:?}\ndensity = {density:?}\n{more}\n"
    )
}

/// Acceleration over gravity of a disc of 8 cells a diameter let go in a box ten diameters wide, over `steps` steps of
/// `dt` (s) after the first.
fn let_go(ratio: f64, dt: f64, steps: usize) -> f64 {
    let petsc = petsc();
    let more = format!("{SHARP}{}[pressure]\ndivergence_limit = 1.0e-6", disc(1.0, [5.03, 5.02], ratio, ""));
    let text = box_case([10.0, 10.0], [80, 80], 1e-5, WALLS, &more)
        .replace("viscosity", "gravity = [0.0, -1.0]\nviscosity");
    let mut scene: Scene<2> = petsc.scene(&text);
    let speed = |scene: &Scene<2>| -scene.coupling.as_ref().unwrap().bodies()[0].velocity.y;
    assert!(scene.step(dt).unwrap().divergence_max < 1e-6);
    let first = speed(&scene);
    println!("first {}", first / dt);
    for _ in 0..steps {
        assert!(scene.step(dt).unwrap().divergence_max < 1e-6, "D0 at a density ratio of {ratio}");
    }
    (speed(&scene) - first) / (steps as f64 * dt)
}

#[test]
fn discs_of_every_density_are_set_off_with_their_added_mass_whatever_the_step() {
    for ratio in [0.001, 0.01, 0.1, 0.5, 2.65, 10.0, 100.0, 1e3, 1e4] {
        let theory = (ratio - 1.0) / (ratio + 1.0);
        let (a, b) = (let_go(ratio, 0.02, 10), let_go(ratio, 0.005, 40));
        println!("s = {ratio}: {:+.2} %, {:+.2} % with short steps", 100.0 * (a / theory - 1.0), 100.0 * (b / theory - 1.0));
    }
}
