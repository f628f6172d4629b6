//! Sharp walls and the time step: on one grid, so that what halved steps change is error of time alone.

use crate::support::{SHARP, box_case, order, petsc};
use mics::scene::Scene;
use std::f64::consts::TAU;

const SIDES: [&str; 4] = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];

/// What a run of one time unit ends with.
struct End {
    /// Velocities of the cells outside (m/s).
    fluid: Vec<f64>,
    /// Force on the disc at the end, and its impulse (N, N s).
    force: [f64; 2],
    impulse: [f64; 2],
    /// Velocity of the disc (m/s).
    velocity: [f64; 2],
}

/// A disc of 8 cells a diameter, in units of the diameter, over `steps` equal steps to time 1.
fn disc_in_a_box(motion: &str, scheme: &str, steps: usize) -> End {
    let petsc = petsc();
    let more = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 1.0 }} }}\nposition = [1.93, 2.04]\n{motion}\n{SHARP}\
         [time]\nend = 1.0\nscheme = \"{scheme}\"\n[pressure]\ndivergence_limit = 1.0e-9"
    );
    let text =
        box_case([4.0, 4.0], [32, 32], 0.02, SIDES, &more).replace("viscosity", "gravity = [0.2, -1.0]\nviscosity");
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

/// Sets off from rest without a jerk, `x = x0 + A (2 pi f t - sin(2 pi f t))` obliquely to the grid.
fn swing(amplitude: f64, frequency: f64) -> String {
    let (v, a) = (TAU * frequency * amplitude, -amplitude);
    format!(
        "motion = {{ prescribed = {{ velocity = [{v:?}, {:?}], oscillation = {{ amplitude = [{a:?}, {:?}], frequency = {frequency:?} }} }} }}",
        0.4 * v,
        0.4 * a
    )
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

/// A disc that moves by less than a tenth of a cell: its wall cuts all the time the same cells, so that nothing but the
/// scheme sets the order. The flow itself, printed only, has a small part of first order: the faces' history.
#[test]
fn the_force_on_a_disc_that_swings_and_its_impulse_are_of_second_order_in_time() {
    for scheme in ["rk2", "rk3"] {
        let ends = [10, 20, 40, 80].map(|steps| disc_in_a_box(&swing(0.001, 1.0), scheme, steps));
        let orders = |of: &dyn Fn(&End) -> &[f64]| {
            let d: Vec<f64> = ends.windows(2).map(|w| distance(of(&w[0]), of(&w[1]))).collect();
            [order(d[0], d[1], 2.0), order(d[1], d[2], 2.0)]
        };
        let (fluid, force, impulse) = (orders(&|e| &e.fluid), orders(&|e| &e.force), orders(&|e| &e.impulse));
        println!("{scheme}: observed orders of the flow {fluid:.2?}, force {force:.2?}, impulse {impulse:.2?}");
        assert!(force.iter().chain(&impulse).all(|o| *o > 1.9), "{scheme}: {force:?} {impulse:?}");
    }
}

/// Cells that change sides do so at the end of a step: an error of first order, in few cells at a time.
#[test]
fn a_disc_that_crosses_cells_feels_the_length_of_the_steps_by_less_than_a_part_in_a_thousand() {
    let moved = swing(0.25, 0.3);
    let [a, b] = [40, 160].map(|steps| disc_in_a_box(&moved, "rk2", steps));
    let change = distance(&a.impulse, &b.impulse) / distance(&b.impulse, &[0.0; 2]);
    println!("moved by 0.3 d: impulse changes by {:.3} %", 100.0 * change);
    assert!(change < 1e-3, "{change}");
    let [a, b] = [40, 160].map(|steps| disc_in_a_box("density = 1.5", "rk2", steps));
    let change = distance(&a.velocity, &b.velocity) / distance(&b.velocity, &[0.0; 2]);
    println!("let go: velocity changes by {:.3} %", 100.0 * change);
    assert!(change < 1e-3, "{change}");
}
