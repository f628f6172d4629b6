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
    let text =
        box_case([10.0, 10.0], [80, 80], 1e-5, WALLS, &more).replace("viscosity", "gravity = [0.0, -1.0]\nviscosity");
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
        println!(
            "s = {ratio}: {:+.2} %, {:+.2} % with short steps",
            100.0 * (a / theory - 1.0),
            100.0 * (b / theory - 1.0)
        );
    }
}

#[test]
fn what_the_fluid_loses_the_particles_get_in_a_periodic_box_with_collisions() {
    let petsc = petsc();
    let more = [
        SHARP.to_string(),
        disc(0.2, [0.05, 0.5], 2.65, "velocity = [1.0, 0.2]\nspin = 5.0"),
        disc(0.15, [0.35, 0.52], 50.0, "velocity = [-1.0, 0.0]"),
        disc(0.15, [0.5, 0.25], 0.5, "velocity = [0.0, 0.5]"),
        disc(0.18, [0.75, 0.75], 1.0, "motion = \"fixed\""),
        "[contact]\nnormal_stiffness = 2.0e3\nfriction = 0.4\nrestitution = 0.7\n".into(),
        "[initial]\nvelocity = [0.3, 0.2]\nperturbation = 0.3\n[pressure]\ndivergence_limit = 1.0e-8".into(),
    ]
    .concat();
    let text =
        box_case([1.0, 1.0], [48, 48], 0.002, PERIODIC, &more).replace("viscosity", "gravity = [0.3, -1.0]\nviscosity");
    let mut scene: Scene<2> = petsc.scene(&text);
    let (mut touched, mut traded, mut missing) = (false, 0.0f64, 0.0f64);
    for _ in 0..120 {
        let dt = 0.5 * scene.limits().unwrap().tightest().1.min(8e-3);
        scene.step(dt).unwrap();
        touched |= scene.substeps > 1;
        let audit = scene.audit.as_ref().unwrap();
        println!("{} {:e} {}", scene.steps, audit.error.norm(), scene.substeps);
        missing = missing.max(audit.error.norm());
        traded = traded.max(audit.momentum.norm());
    }
    println!("missing {missing:e} of {traded:e}");
    assert!(touched && missing < 1e-8 * traded, "{missing:e} of {traded:e}");
}
