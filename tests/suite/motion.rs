//! Free particles: what gravity, fluid and contacts make of them, and what they give back.

use crate::support::{
    MIXING, PERIODIC, Petsc, SHARP, box_case, columns, mics, petsc, run, shipped,
};
use mics::scene::Scene;

pub const WALLS: [&str; 4] = ["\"wall\"", "\"wall\"", "\"wall\"", "\"wall\""];

pub fn disc(diameter: f64, place: [f64; 2], density: f64, more: &str) -> String {
    format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = {diameter:?} }} }}\nposition = {place:?}\n\
        density = {density:?}\n{more}\n"
    )
}

/// A disc of eight cells a diameter, let go in a box ten diameters wide, over the ten steps after
/// the first.
#[test]
fn disc_of_density_ratio_10000_falls_freely() {
    let petsc = petsc();
    let more =
        format!("{SHARP}{}[pressure]\ndivergence_limit = 1.0e-6", disc(1.0, [5.03, 5.02], 1e4, ""));
    let text = box_case([10.0, 10.0], [80, 80], 1e-5, WALLS, &more)
        .replace("viscosity", "gravity = [0.0, -1.0]\nviscosity");
    let mut scene: Scene<2> = petsc.scene(&text);
    let dt = 0.02;
    let speed = |scene: &Scene<2>| -scene.state.bodies[0].velocity.y;
    assert!(scene.step(dt).unwrap().divergence_max < 1e-6);
    let first = speed(&scene);
    for _ in 0..10 {
        assert!(scene.step(dt).unwrap().divergence_max < 1e-6);
    }
    let a = (speed(&scene) - first) / (10.0 * dt);
    assert!((a - 1.0).abs() < 1e-3, "{a}");
}

/// Discs that collide in a periodic box with a fixed one, in a stream, with such a wall.
pub fn collisions(petsc: &Petsc, wall: &str) -> Scene<2> {
    let more = [
        wall.to_string(),
        disc(0.2, [0.05, 0.5], 2.65, "velocity = [1.0, 0.2]\nspin = 5.0"),
        disc(0.15, [0.35, 0.52], 50.0, "velocity = [-1.0, 0.0]"),
        disc(0.15, [0.5, 0.25], 0.5, "velocity = [0.0, 0.5]"),
        disc(0.18, [0.75, 0.75], 1.0, "motion = \"fixed\""),
        "[contact]\nnormal_stiffness = 2.0e3\nfriction = 0.4\nrestitution = 0.7\n".into(),
        "[initial]\nvelocity = [0.3, 0.2]\nperturbation = 0.3\n[pressure]\n\
        divergence_limit = 1.0e-8"
            .into(),
    ]
    .concat();
    let text = box_case([1.0, 1.0], [48, 48], 0.002, PERIODIC, &more)
        .replace("viscosity", "gravity = [0.3, -1.0]\nviscosity");
    petsc.scene(&text)
}

#[test]
fn disc_carried_at_the_speed_of_stream_feels_no_force() {
    let petsc = petsc();
    for (wall, density) in [(MIXING, 1.0), (MIXING, 2.65), (SHARP, 1.0), (SHARP, 2.65)] {
        let more = disc(0.25, [0.3, 0.5], density, "velocity = [1.0, 0.4]")
            + wall
            + "[initial]\nvelocity = [1.0, 0.4]\n[pressure]\ndivergence_limit = 1.0e-9";
        let mut scene: Scene<2> =
            petsc.scene(&box_case([1.0, 1.0], [32, 32], 0.01, PERIODIC, &more));
        for _ in 0..60 {
            scene.step(0.01).unwrap();
            let coupling = &scene.state;
            let force = coupling.exchange[0].momentum.norm();
            assert!(force < 1e-6 * 1.16 * 0.25, "{force} at density {density}: {wall}");
        }
    }
}

#[test]
fn settling_disc_has_published_speed() {
    let dir = tempfile::tempdir().unwrap();
    let sharp = ["--set", "coupling.wall=\"sharp\"", "--set", "output.figures=false"];
    let summary = run(&shipped("cases/settling-disc/case.toml"), dir.path(), &sharp);
    let speed = summary["measures"]["largest_speed"].as_f64().unwrap();
    println!("largest speed {speed:.3} cm/s, reference 5.575");
    assert!((speed / 5.575 - 1.0).abs() < 0.01, "{speed}");
}

#[test]
fn momentum_balance_closes_for_spheres_resting_on_walls() {
    let petsc = petsc();
    let sphere = |place: [f64; 3], density: f64| {
        format!(
            "[[particle]]\nshape = {{ sphere = {{ diameter = 0.4 }} }}\nposition = {place:?}\n\
            density = {density:?}\n"
        )
    };
    let text = format!(
        "name = \"t\"\n[coupling]\nwall = \"sharp\"\n[domain]\nsize = [1.0, 1.0, 1.2]\n\
        cells = [15, 15, 18]\n[fluid]\ndensity = 1.0\nviscosity = 0.05\n\
     gravity = [0.0, 0.0, -1.0]\n[boundary]\nwest = \"periodic\"\neast = \"periodic\"\n\
         south = \"wall\"\nnorth = \"wall\"\n\
     bottom = \"wall\"\ntop = \"slip\"\n{}{}[contact]\nnormal_stiffness = 2.0e3\n\
         exponent = 1.5\nfriction = 0.4\n\
     [time]\nend = 1.0\n[pressure]\ndivergence_limit = 1.0e-8",
        sphere([0.5, 0.5, 0.2], 2.65),
        sphere([0.55, 0.5, 0.62], 7.8),
    );
    let mut scene: Scene<3> = petsc.scene(&text);
    let mut touched = false;
    for _ in 0..60 {
        scene.step(0.01).unwrap();
        touched |= scene.state.substeps > 1;
        let audit = scene.state.balance.as_ref().unwrap();
        assert!(audit.error.amax() < 1e-12, "{audit:?}");
    }
    let bodies = scene.state.bodies;
    assert!(touched && bodies[0].centre.z > 0.19 && bodies[1].spin.y.abs() > 0.01, "{bodies:?}");
}

#[test]
fn touch_without_contact_table_stops_run() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let discs = disc(0.2, [0.3, 0.5], 2.0, "velocity = [1.0, 0.0]")
        + &disc(0.2, [0.6, 0.5], 2.0, "velocity = [-1.0, 0.0]");
    for (name, wall) in [("mixing", MIXING), ("sharp", SHARP)] {
        std::fs::write(
            &case,
            box_case([1.0, 1.0], [32, 32], 0.01, PERIODIC, &(discs.clone() + wall)),
        )
        .unwrap();
        let out = dir.path().join(name);
        let output =
            mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--quiet"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{name}: {said}");
        assert!(
            said.contains("particle 1 has run into particle 0") && said.contains("[contact]"),
            "{name}: {said}"
        );
        assert!(columns(&out.join("particles.csv"))["vx"].len() > 4);
    }
}

#[test]
fn mics_2003_preset_moves_heavy_particle() {
    let dir = tempfile::tempdir().unwrap();
    let set =
        ["preset=\"mics-2003\"", "time.end=0.1", "output.figures=false", "particle.0.density=2.65"];
    let words: Vec<&str> = set.iter().flat_map(|s| ["--set", *s]).collect();
    run(&shipped("cases/settling-disc/case.toml"), dir.path(), &words);
    let case = std::fs::read_to_string(dir.path().join("case.toml")).unwrap();
    for choice in ["\"qsi\"", "\"mixing\"", "viscosity = 0.0"] {
        assert!(case.contains(choice), "{choice} in {case}");
    }
    let speed = columns(&dir.path().join("particles.csv"))["vy"].last().copied().unwrap();
    assert!((-40.0..-15.0).contains(&speed), "{speed} cm/s");
}

#[test]
fn locked_direction_keeps_its_velocity() {
    let petsc = petsc();
    for wall in [MIXING, SHARP] {
        let more =
            disc(0.25, [0.5, 0.5], 2.65, "velocity = [0.1, 0.0]\nlocked = [\"x\", \"rotation\"]")
                + wall;
        let text = box_case([1.0, 1.0], [32, 32], 0.01, WALLS, &more)
            .replace("viscosity", "gravity = [0.5, -1.0]\nviscosity");
        let mut scene: Scene<2> = petsc.scene(&text);
        for _ in 0..20 {
            scene.step(0.005).unwrap();
        }
        let body = &scene.state.bodies[0];
        assert_eq!((body.velocity.x, body.spin.z), (0.1, 0.0), "{wall}");
        assert!(body.velocity.y < -0.01, "{wall}");
    }
}

#[test]
fn force_on_held_particle_closes_momentum_balance() {
    let petsc = petsc();
    let stream = "[initial]\nvelocity = [1.0, 0.3]\n[pressure]\ndivergence_limit = 1.0e-9";
    let force_on = |how: &str| {
        let more =
            disc(0.25, [0.5, 0.5], 2.65, how) + &disc(0.2, [0.2, 0.2], 2.0, "") + SHARP + stream;
        let text = box_case([1.0, 1.0], [32, 32], 0.01, PERIODIC, &more)
            .replace("viscosity", "gravity = [0.5, -1.0]\nviscosity");
        let mut scene: Scene<2> = petsc.scene(&text);
        for _ in 0..15 {
            scene.step(0.005).unwrap();
            let audit = scene.state.balance.as_ref().unwrap();
            assert!(audit.error.amax() < 1e-12, "{how}: {:?}", audit.error);
        }
        scene.state.exchange[0].momentum
    };
    let [held, locked] =
        ["motion = \"fixed\"", "locked = [\"x\", \"y\", \"rotation\"]"].map(force_on);
    assert!((held - locked).norm() < 1e-9 * held.norm() && held.x > 0.1, "{held} {locked}");
}

#[test]
fn mixture_density_stays_positive_for_pressed_light_particles() {
    let petsc = petsc();
    let law = "[contact]\nnormal_stiffness = 0.5\n";
    let accelerations = "motion = { prescribed = { velocity = [0.0, -0.2] } }";
    let more = [
        disc(0.25, [0.5, 0.126], 0.01, ""),
        disc(0.25, [0.5, 0.378], 0.01, ""),
        disc(0.25, [0.5, 0.632], 0.01, accelerations),
        law.into(),
        MIXING.into(),
    ]
    .concat();
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [32, 32], 1e-4, WALLS, &more));
    let mut least = f64::INFINITY;
    for _ in 0..60 {
        scene.step(0.002).unwrap();
        least = scene
            .domain
            .grid
            .rows()
            .flatten()
            .map(|c| scene.method.mixture().density.at(c))
            .fold(least, f64::min);
    }
    let bodies = scene.state.bodies;
    assert!((bodies[1].centre - bodies[0].centre).norm() < 0.25, "they overlap: {bodies:?}");
    // Two fractions that add up to more than a whole would make the mixture lighter than the
    // lightest.
    assert!(least > 0.0099, "{least} kg/m3");
}

#[test]
fn particle_smaller_than_a_cell_moves_with_it() {
    let petsc = petsc();
    for wall in [MIXING, SHARP] {
        let more = disc(0.03, [0.03, 0.53], 2.0, "") + wall;
        let text = box_case([1.0, 1.0], [16, 16], 0.01, PERIODIC, &more)
            .replace("viscosity", "gravity = [0.0, -1.0]\nviscosity");
        let mut scene: Scene<2> = petsc.scene(&text);
        for _ in 0..10 {
            scene.step(0.005).unwrap();
        }
        assert!(scene.state.bodies[0].velocity.y < -1e-4, "{wall}");
    }
}
