//! Sharp surfaces and the time step: on one grid, so that what halved steps change is error of time
//! alone.

use crate::support::{PERIODIC, SHARP, box_case, columns, order, petsc, run};
use mics::scene::Scene;
use std::f64::consts::TAU;

const SIDES: [&str; 4] = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];

/// State and forces at the end of a run of one time unit.
struct End {
    /// Velocities of the cells outside (m/s).
    fluid: Vec<f64>,
    /// Force on the disc at the end, and its impulse (N, N s).
    force: [f64; 2],
    impulse: [f64; 2],
    /// Velocity of the disc (m/s).
    velocity: [f64; 2],
}

/// A disc of 8 cells a diameter, in units of the diameter, in a liquid of the kinematic viscosity
/// `nu`, over `steps` equal steps to time 1.
fn disc_in_a_box(motion: &str, nu: f64, scheme: &str, steps: usize) -> End {
    let petsc = petsc();
    let more = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 1.0 }} }}\nposition = [1.93, 2.04]\n\
        {motion}\n{SHARP}\
         [time]\nend = 1.0\nscheme = \"{scheme}\"\n[pressure]\ndivergence_limit = 1.0e-9"
    );
    let text = box_case([4.0, 4.0], [32, 32], nu, SIDES, &more)
        .replace("viscosity", "gravity = [0.2, -1.0]\nviscosity");
    let mut scene: Scene<2> = petsc.scene(&text);
    let dt = 1.0 / steps as f64;
    let (mut force, mut before, mut impulse) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    for _ in 0..steps {
        scene.step(dt).unwrap();
        let now = scene.state.exchange[0].momentum;
        (before, force) = (force, [now.x, now.y]);
        impulse = [0, 1].map(|a| impulse[a] + dt * now[a]);
    }
    let disc = &scene.state.bodies[0];
    let outside = |c: &usize| {
        let [x, y] = scene.domain.grid.centre(*c);
        (x - disc.centre.x).hypot(y - disc.centre.y) > disc.radius()
    };
    End {
        fluid: scene
            .domain
            .grid
            .rows()
            .flatten()
            .filter(outside)
            .flat_map(|c| [scene.state.u[0][c], scene.state.u[1][c]])
            .collect(),
        // Forces are means over a step.
        force: [0, 1].map(|a| 1.5 * force[a] - 0.5 * before[a]),
        impulse,
        velocity: [disc.velocity.x, disc.velocity.y],
    }
}

/// Sets off from rest without a jerk, `x = x0 + A (2 pi f t - sin(2 pi f t))` obliquely to the
/// grid.
fn swing(amplitude: f64, frequency: f64) -> String {
    let (v, a) = (TAU * frequency * amplitude, -amplitude);
    format!(
        "motion = \
        {{ prescribed = {{ velocity = [{v:?}, {:?}], oscillation = {{ amplitude = [{a:?}, {:?}], \
        frequency = {frequency:?} }} }} }}",
        0.4 * v,
        0.4 * a
    )
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

/// A disc that moves by less than a tenth of a cell: its wall cuts all the time the same cells, so
/// that nothing but the scheme sets the order. The flow itself, printed only, has a small part of
/// first order: the faces' history.
#[test]
fn oscillating_disc_force_and_impulse_second_order_in_time() {
    // By rkl2 at this viscosity 80 steps take five stages, and 260 would be needed for two.
    for (scheme, nu, steps) in [("rk2", 0.02, 10), ("rk3", 0.02, 10), ("rkl2", 1.0, 80)] {
        let ends = [1, 2, 4, 8].map(|n| disc_in_a_box(&swing(0.001, 1.0), nu, scheme, n * steps));
        let orders = |of: &dyn Fn(&End) -> &[f64]| {
            let d: Vec<f64> = ends.windows(2).map(|w| distance(of(&w[0]), of(&w[1]))).collect();
            [order(d[0], d[1], 2.0), order(d[1], d[2], 2.0)]
        };
        let (fluid, force, impulse) =
            (orders(&|e| &e.fluid), orders(&|e| &e.force), orders(&|e| &e.impulse));
        println!(
            "{scheme}: observed orders of the flow {fluid:.2?}, force {force:.2?}, impulse \
            {impulse:.2?}"
        );
        for [first, second] in [force, impulse] {
            assert!(first > 1.6 && second > 1.9, "{scheme}: {force:?} {impulse:?}");
        }
    }
}

/// Cells that change sides do so at the end of a step: an error of first order, in few cells at a
/// time.
#[test]
fn disc_crossing_cells_depends_weakly_on_step_length() {
    let moved = swing(0.25, 0.3);
    for (scheme, nu) in [("rk2", 0.02), ("rkl2", 0.5)] {
        let [a, b] = [40, 160].map(|steps| disc_in_a_box(&moved, nu, scheme, steps));
        let change = distance(&a.impulse, &b.impulse) / distance(&b.impulse, &[0.0; 2]);
        println!("{scheme}, moved by 0.3 d: impulse changes by {:.3} %", 100.0 * change);
        assert!(change < 2.5e-3, "{change}");
        let [a, b] = [40, 160].map(|steps| disc_in_a_box("density = 1.5", nu, scheme, steps));
        let change = distance(&a.velocity, &b.velocity) / distance(&b.velocity, &[0.0; 2]);
        println!("{scheme}, let go: velocity changes by {:.3} %", 100.0 * change);
        assert!(change < if scheme == "rk2" { 1e-3 } else { 2e-3 }, "{change}");
    }
}

/// A steady flow must not depend on the step: the faces would leak by what they have of the
/// pressure beyond the cells.
#[test]
fn lattice_drag_in_creeping_flow_does_not_depend_on_the_step() {
    let petsc = petsc();
    let drag = |longest: f64| {
        let more = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.75 }} }}\nposition = [0.5, 0.5]\n\
            motion = \"fixed\"\n{SHARP}\
             [drive]\nmean_velocity = {{ axis = \"x\", value = 0.01 }}\n[time]\nend = 1.0\n\
                 scheme = \"rkl2\"\n\
             [pressure]\ndivergence_limit = 1.0e-9"
        );
        let mut scene: Scene<2> =
            petsc.scene(&box_case([1.0, 1.0], [16, 16], 1.0, PERIODIC, &more));
        let mut dt = 5e-4;
        while scene.state.time < 2.0 {
            scene.step(dt).unwrap();
            dt = longest.min(1.1 * dt);
        }
        scene.state.drive.unwrap().x
    };
    // rk2 would be stable up to 9.8e-4.
    let [short, middle, long] = [8e-4, 5e-3, 0.015].map(drag);
    println!("drag {short:.5}, {middle:.5}, {long:.5}");
    assert!((middle / short - 1.0).abs() < 2e-3 && (long / short - 1.0).abs() < 4e-3);
}

/// Drag where the Courant number binds the step: a disc of 8 cells in a stream at a Reynolds number
/// of 100, Courant numbers of about 0.1 and 0.9. Where faces went by the last pressure for the
/// whole step, it had 1.6 % more drag at 0.9.
#[test]
fn disc_drag_in_stream_does_not_depend_on_the_step() {
    let petsc = petsc();
    let drag = |longest: f64| {
        let more = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.25 }} }}\nposition = [0.7, 0.5]\n\
            motion = \"fixed\"\n{SHARP}\
             [time]\nend = 4.0\nscheme = \"rkl3\"\n[pressure]\ndivergence_limit = 1.0e-7"
        );
        let sides = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];
        let mut scene: Scene<2> =
            petsc.scene(&box_case([2.0, 1.0], [64, 32], 0.0025, sides, &more));
        let (mut dt, mut force) = (1e-3, 0.0);
        while scene.state.time < 4.0 {
            scene.step(dt).unwrap();
            force = scene.state.exchange[0].momentum.x;
            dt = longest.min(1.1 * dt);
        }
        force
    };
    let [short, long] = [1.6e-3, 1.35e-2].map(drag);
    println!("force {short:.5}, {long:.5}");
    assert!((long / short - 1.0).abs() < 3e-3, "{short} {long}");
}

/// The velocity imposed at a wall has a part that oscillates: with ten stages, which nothing but a
/// fixed disc would forbid, the drag at this place goes to and fro by some thousandths for ever.
#[test]
fn fixed_disc_drag_steady_in_longest_steps() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (dir.path().join("case.toml"), dir.path().join("run"));
    let more = "[[particle]]\nshape = { disc = { diameter = 0.5 } }\nposition = [0.5113, 0.5113]\n\
        motion = \"fixed\"\n\
                [drive]\nforce = [1.0, 0.0]\n[time]\nend = 1.5\n[output]\nfigures = false\n\
                particles = { every = 1 }\n";
    let text = box_case([1.0, 1.0], [32, 32], 1.0, PERIODIC, more);
    std::fs::write(&case, text).unwrap();
    run(&case, &out, &[]);
    let rows = columns(&out.join("particles.csv"));
    let late: Vec<f64> = rows["time"]
        .iter()
        .zip(&rows["fluid_fx"])
        .filter(|(t, _)| **t > 1.0)
        .map(|(_, drag)| *drag)
        .collect();
    let (least, most) =
        late.iter().fold((f64::INFINITY, 0.0f64), |(l, m), drag| (l.min(*drag), m.max(*drag)));
    println!("{} steps, drag {least:.6} to {most:.6}", late.len());
    assert!(late.len() > 20 && most / least - 1.0 < 1e-3, "{least} to {most}");
}
