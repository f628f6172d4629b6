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

/// Acceleration over gravity of a disc of `n` cells a diameter let go in a box ten diameters wide,
/// over `steps` steps after the first.
fn let_go(n: usize, ratio: f64, steps: usize) -> f64 {
    let petsc = petsc();
    let more = format!(
        "{MIXING}{}[pressure]\ndivergence_limit = 1.0e-6",
        disc(1.0, [5.03, 5.02], ratio, "")
    );
    let text = box_case([10.0, 10.0], [10 * n, 10 * n], 1e-5, WALLS, &more)
        .replace("viscosity", "gravity = [0.0, -1.0]\nviscosity");
    let mut scene: Scene<2> = petsc.scene(&text);
    let dt = 0.02;
    let speed = |scene: &Scene<2>| -scene.state.bodies[0].velocity.y;
    assert!(scene.step(dt).unwrap().divergence_max < 1e-6);
    let first = speed(&scene);
    for _ in 0..steps {
        assert!(scene.step(dt).unwrap().divergence_max < 1e-6, "D0 at a density ratio of {ratio}");
    }
    (speed(&scene) - first) / (steps as f64 * dt)
}

#[test]
fn disc_of_density_ratio_10000_falls_freely() {
    let a = let_go(8, 1e4, 10);
    assert!((a - 1.0).abs() < 1e-3, "{a}");
}

#[test]
fn mixing_disc_set_off_stably_for_all_density_ratios() {
    for ratio in [0.001, 0.01, 0.1, 0.5, 2.65, 10.0, 100.0, 1e3, 1e4] {
        let (a, theory) = (let_go(16, ratio, 11), (ratio - 1.0) / (ratio + 1.0));
        println!(
            "s = {ratio}: a/g {a:.4}, (s-1)/(s+1) {theory:.4}, {:+.2} %",
            100.0 * (a / theory - 1.0)
        );
        // The mixing carries all touched cells along, so that the body is too large, the more the
        // lighter it is.
        let allowed = if ratio >= 10.0 {
            0.06
        } else if ratio > 1.0 {
            0.08
        } else {
            0.6
        };
        assert!((a / theory - 1.0).abs() < allowed, "s = {ratio}: {a} against {theory}");
    }
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
fn mixing_momentum_exchange_conserved_in_periodic_collisions() {
    let petsc = petsc();
    let mut scene = collisions(&petsc, MIXING);
    let (mut touched, mut traded, mut missing) = (false, 0.0f64, 0.0f64);
    for _ in 0..120 {
        let dt = 0.5 * scene.limits().unwrap().tightest().1.min(8e-3);
        scene.step(dt).unwrap();
        touched |= scene.state.substeps > 1;
        let audit = scene.state.balance.as_ref().unwrap();
        let scale = audit.momentum.norm().max(0.1);
        traded = traded.max(audit.momentum.norm());
        missing = missing.max(audit.error.amax());
        assert!(audit.error.amax() < 1e-8 * scale, "{:?} of {:?}", audit.error, audit.momentum);
        assert!(audit.angular_error < 1e-8 * scale, "{}", audit.angular_error);
    }
    println!("momentum up to {traded:.2}, missing in a step {missing:.1e}");
    assert!(touched && traded > 0.3, "they collide, and momentum moves: {traded}");
}

#[test]
fn mixing_disc_carried_at_the_speed_of_stream_feels_no_force() {
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
    for wall in ["mixing", "sharp"] {
        let text = format!(
            "name = \"t\"\n[coupling]\nwall = \"{wall}\"\n[domain]\nsize = [1.0, 1.0, 1.2]\n\
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
            // What wall shear misses of the angular momentum, sharp surfaces tell.
            let turned = wall == "sharp" || audit.angular_error < 1e-12;
            assert!(audit.error.amax() < 1e-12 && turned, "{wall}: {audit:?}");
        }
        let bodies = scene.state.bodies;
        assert!(
            touched && bodies[0].centre.z > 0.19 && bodies[1].spin.y.abs() > 0.01,
            "{bodies:?}"
        );
    }
}

#[test]
fn settling_sphere_momentum_balance() {
    let petsc = petsc();
    let sides: String = ["west", "east", "south", "north", "bottom", "top"]
        .map(|s| format!("{s} = \"periodic\"\n"))
        .concat();
    for wall in ["mixing", "sharp"] {
        let text = format!(
            "name = \"t\"\n[coupling]\nwall = \"{wall}\"\n[domain]\nsize = [1.0, 1.0, 1.0]\n\
            cells = [20, 20, 20]\n[fluid]\ndensity = 1.0\nviscosity = 0.02\n\
         gravity = [0.0, 0.0, -1.0]\n[boundary]\n{sides}[[particle]]\n\
         shape = {{ sphere = {{ diameter = 0.4 }} }}\n\
         position = [0.5, 0.52, 0.1]\ndensity = 3.0\nspin = [0.0, 2.0, 1.0]\n[time]\nend = 1.0\n\
         [pressure]\ndivergence_limit = 1.0e-8"
        );
        let mut scene: Scene<3> = petsc.scene(&text);
        for _ in 0..20 {
            assert!(scene.step(0.01).unwrap().divergence_max < 1e-8);
            let audit = scene.state.balance.as_ref().unwrap();
            // What wall shear misses of the angular momentum, sharp surfaces tell.
            let turned = wall == "sharp" || audit.angular_error < 1e-12;
            assert!(audit.error.amax() < 1e-12 && turned, "{wall}: {audit:?}");
        }
        let body = &scene.state.bodies[0];
        assert!(body.velocity.z < -0.05 && body.velocity.x.abs() < 0.02, "{body:?}");
        assert!(body.orientation.angle() > 0.05, "it turns: {body:?}");
    }
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
            said.contains("particle 0 has run into particle 1") && said.contains("[contact]"),
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
    for choice in [
        "\"qsi\"",
        "\"polygon\"",
        "\"literal\"",
        "\"boundary\"",
        "\"cells\"",
        "mix_pressure = true",
        "viscosity = 0.0",
    ] {
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
    let force_on = |wall: &str, how: &str| {
        let more =
            disc(0.25, [0.5, 0.5], 2.65, how) + &disc(0.2, [0.2, 0.2], 2.0, "") + wall + stream;
        let text = box_case([1.0, 1.0], [32, 32], 0.01, PERIODIC, &more)
            .replace("viscosity", "gravity = [0.5, -1.0]\nviscosity");
        let mut scene: Scene<2> = petsc.scene(&text);
        for _ in 0..15 {
            scene.step(0.005).unwrap();
            let audit = scene.state.balance.as_ref().unwrap();
            assert!(audit.error.amax() < 1e-12, "{wall} {how}: {:?}", audit.error);
        }
        scene.state.exchange[0].momentum
    };
    for wall in [MIXING, SHARP] {
        let [held, locked] = ["motion = \"fixed\"", "locked = [\"x\", \"y\", \"rotation\"]"]
            .map(|how| force_on(wall, how));
        assert!(
            (held - locked).norm() < 1e-9 * held.norm() && held.x > 0.1,
            "{wall}: {held} {locked}"
        );
    }
}

#[test]
fn mixture_density_stays_positive_for_pressed_light_particles() {
    let petsc = petsc();
    let law = "[contact]\nnormal_stiffness = 0.5\n";
    let accelerations = "motion = { prescribed = { velocity = [0.0, -0.2] } }";
    for wall in [MIXING, SHARP] {
        let more = [
            disc(0.25, [0.5, 0.126], 0.01, ""),
            disc(0.25, [0.5, 0.378], 0.01, ""),
            disc(0.25, [0.5, 0.632], 0.01, accelerations),
            law.into(),
            wall.into(),
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
        assert!(
            (bodies[1].centre - bodies[0].centre).norm() < 0.25,
            "{wall}: they overlap: {bodies:?}"
        );
        // Two fractions that add up to more than a whole would make the mixture lighter than the
        // lightest.
        assert!(least > 0.0099, "{wall}: {least} kg/m3");
    }
}

#[test]
fn prescribed_particle_hitting_a_body_stops_run() {
    let petsc = petsc();
    let other = disc(0.2, [0.7, 0.5], 1.0, "motion = \"fixed\"");
    for (wall, other, says) in [
        (MIXING, &other[..], "has run into particle 1"),
        (MIXING, "", "has reached the boundary"),
        (SHARP, &other, "has run into particle 1"),
        (SHARP, "", "has reached the boundary"),
    ] {
        let more = [
            &disc(0.2, [0.4, 0.5], 1.0, "motion = { prescribed = { velocity = [1.0, 0.0] } }"),
            other,
            &disc(0.2, [0.4, 0.2], 1.0, ""),
            "[contact]\nnormal_stiffness = 100.0\n",
            wall,
        ]
        .concat();
        let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [32, 32], 0.01, WALLS, &more));
        let error = (0..80).find_map(|_| scene.step(0.01).err()).expect("they meet").to_string();
        assert!(error.contains("particle 0") && error.contains(says), "{wall}: {error}");
    }
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
