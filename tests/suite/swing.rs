//! Particles that swing as told.

use crate::motion::{WALLS, disc};
use crate::support::{MIXING, PERIODIC, SHARP, box_case, columns, mics, petsc, run};
use mics::scene::Scene;

const SWING: &str = "motion = \
    { prescribed = { velocity = [0.3, 0.0], oscillation = { amplitude = [-0.05, 0.02], frequency = \
        1.5 } } }";

#[test]
fn oscillating_particle_path_and_momentum_force() {
    let petsc = petsc();
    let rate = std::f64::consts::TAU * 1.5;
    let more = MIXING.to_string()
        + &disc(0.25, [0.95, 0.5], 1.0, SWING)
        + "[pressure]\ndivergence_limit = 1.0e-9";
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [32, 32], 0.01, PERIODIC, &more));
    // The momentum of all but the particle.
    let around = |scene: &Scene<2>| {
        let grid = &scene.domain.grid;
        let all = |a: usize| {
            grid.rows()
                .flatten()
                .map(|c| scene.method.mixture().density.at(c) * scene.state.u[a][c])
                .sum::<f64>()
        };
        let body = &scene.state.bodies[0];
        [0, 1].map(|a| all(a) * grid.cell_volume() - body.mass() * body.velocity[a])
    };
    for k in 0..40 {
        let dt = if k % 2 == 0 { 0.004 } else { 0.003 };
        let before = around(&scene);
        scene.step(dt).unwrap();
        let (after, coupling) = (around(&scene), &scene.state);
        let (body, force) = (&coupling.bodies[0], coupling.exchange[0].momentum);
        let (sine, cosine) = (rate * scene.state.time).sin_cos();
        let place =
            [(0.95 + 0.3 * scene.state.time - 0.05 * sine).rem_euclid(1.0), 0.5 + 0.02 * sine];
        let velocity = [0.3 - 0.05 * rate * cosine, 0.02 * rate * cosine];
        for a in 0..2 {
            assert!((body.centre[a] - place[a]).abs() < 1e-14, "{:?} {place:?}", body.centre);
            assert!(
                (body.velocity[a] - velocity[a]).abs() < 1e-14,
                "{:?} {velocity:?}",
                body.velocity
            );
            let missing = after[a] - before[a] + dt * force[a];
            assert!(missing.abs() < 1e-14, "step {k}: {missing:e} of {:e}", dt * force[a]);
        }
    }
    let limits = scene.limits().unwrap();
    assert!(limits.courant_rate >= 32.0 * (0.3 + rate * 0.05f64.hypot(0.02)), "{limits:?}");
}

#[test]
fn oscillating_particle_among_free_ones_closes_balance() {
    let petsc = petsc();
    let more = [
        disc(0.2, [0.3, 0.5], 3.0, SWING),
        disc(0.2, [0.52, 0.5], 2.0, ""),
        "[contact]\nnormal_stiffness = 2.0e3\n".into(),
        SHARP.into(),
        "[pressure]\ndivergence_limit = 1.0e-9".into(),
    ]
    .concat();
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [32, 32], 0.01, PERIODIC, &more));
    let (mut touched, rate) = (false, std::f64::consts::TAU * 1.5);
    for _ in 0..150 {
        scene.step(0.004).unwrap();
        touched |= scene.state.substeps > 1;
        let body = scene.state.bodies.iter().find(|body| body.id == 0).unwrap();
        let place =
            (0.3 + 0.3 * scene.state.time - 0.05 * (rate * scene.state.time).sin()).rem_euclid(1.0);
        assert!((body.centre.x - place).abs() < 1e-12, "{} {place}", body.centre.x);
        let audit = scene.state.balance.as_ref().unwrap();
        assert!(audit.error.amax() < 1e-12, "{:?}", audit.error);
    }
    assert!(touched, "they meet");
}

#[test]
fn run_and_check_output_of_oscillating_particle() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let more =
        disc(0.2, [0.4, 0.5], 1.0, SWING) + SHARP + "[output]\nfigures = false\n[time]\nend = 0.1";
    std::fs::write(&case, box_case([1.0, 1.0], [32, 32], 0.01, WALLS, &more)).unwrap();
    let checked = mics(&["check", case.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&checked.stdout);
    assert!(said.contains("to and fro by [-0.05, 0.02] m at 1.5 1/s (0.5075 m/s)"), "{said}");
    let out = dir.path().join("out");
    run(&case, &out, &[]);
    let again = dir.path().join("again");
    run(&out.join("case.toml"), &again, &[]);
    let [rows, repeated] = [out, again].map(|folder| columns(&folder.join("particles.csv")));
    let rate = std::f64::consts::TAU * 1.5;
    for (t, v) in rows["time"].iter().zip(&rows["vx"]) {
        assert!((v - 0.3 + 0.05 * rate * (rate * t).cos()).abs() < 1e-14, "{v} at {t} s");
    }
    assert_eq!((&rows["x"], &rows["fluid_fx"]), (&repeated["x"], &repeated["fluid_fx"]));
}
