//! The faces of the box, against exact flows.

use crate::support::{PERIODIC, SHARP, box_case, order, petsc};
use mics::scene::Scene;

/// Largest error of the velocity along x after `steps` steps of `dt`, against `exact(y)`.
fn channel_error(case: &str, steps: usize, dt: f64, exact: impl Fn(f64) -> f64) -> f64 {
    let petsc = petsc();
    let mut scene: Scene<2> = petsc.scene(case);
    for _ in 0..steps {
        scene.step(dt).unwrap();
    }
    let error = |c: usize| (scene.state.u[0][c] - exact(scene.domain.grid.centre(c)[1])).abs();
    scene.domain.grid.rows().flatten().map(error).fold(0.0, f64::max)
}

#[test]
fn parabolic_inflow_stays_parabolic_to_second_order() {
    let error = |n: usize| {
        let sides = ["{ inflow_parabola = [1.0, 0.0] }", "\"outflow\"", "\"wall\"", "\"wall\""];
        let dt = (0.4 / n as f64).min(4.0 / (n * n) as f64);
        channel_error(
            &box_case([2.0, 1.0], [2 * n, n], 0.05, sides, ""),
            (4.0 / dt) as usize,
            dt,
            |y| 4.0 * y * (1.0 - y),
        )
    };
    let e = [8, 16, 32].map(error);
    println!("{e:?}");
    assert!(order(e[1], e[2], 2.0) >= 1.8, "{e:?}");
}

#[test]
fn moving_wall_gives_exact_couette_flow() {
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "{ moving_wall = [2.0, 0.0] }"];
    let error =
        channel_error(&box_case([0.5, 1.0], [8, 16], 0.5, sides, ""), 4000, 2e-3, |y| 2.0 * y);
    assert!(error < 1e-9, "{error}");
    // From the start on, where the case begins with it.
    let begun = "[initial]\ncouette = \"y\"";
    let sides = ["\"periodic\"", "\"periodic\"", "{ moving_wall = [-1.0, 0.0] }", sides[3]];
    let text = box_case([0.5, 1.0], [8, 16], 0.5, sides, begun);
    let error = channel_error(&text, 3, 2e-3, |y| 3.0 * y - 1.0);
    assert!(error < 1e-12, "{error}");
}

#[test]
fn uniform_stream_along_slip_walls_and_inflow_profile() {
    let table = "{ inflow_profile = { at = [0.0, 1.0], velocity = [[1.0, 0.0], [1.0, 0.0]] } }";
    for west in ["{ inflow = [1.0, 0.0] }", table] {
        let sides = [west, "\"outflow\"", "\"slip\"", "\"slip\""];
        let error =
            channel_error(&box_case([2.0, 1.0], [16, 8], 0.01, sides, ""), 50, 0.03, |_| 1.0);
        assert!(error < 1e-12, "{error}");
    }
}

/// Disturbance energy near the outflow after a vortex has left, over the vortex's own.
fn left_behind(length: f64, n: usize) -> f64 {
    let petsc = petsc();
    let sides = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];
    let cells = [(length * n as f64) as usize, 2 * n];
    let mut scene: Scene<2> = petsc.scene(&box_case([length, 2.0], cells, 1e-3, sides, ""));
    let disturbance = |scene: &Scene<2>| {
        let energy = |c: usize| (scene.state.u[0][c] - 1.0).powi(2) + scene.state.u[1][c].powi(2);
        let inside =
            scene.domain.grid.rows().flatten().filter(|&c| scene.domain.grid.centre(c)[0] < 2.0);
        inside.map(energy).sum::<f64>()
    };
    for c in scene.domain.grid.rows().flatten() {
        let [x, y] = scene.domain.grid.centre(c);
        let (dx, dy) = (x - 1.0, y - 1.0);
        let swirl = 0.5 * (0.5 - 0.5 * (dx * dx + dy * dy) / 0.04).exp() / 0.2;
        scene.state.u[0][c] = 1.0 - swirl * dy;
        scene.state.u[1][c] = swirl * dx;
    }
    scene.start().unwrap();
    let before = disturbance(&scene);
    let dt = 0.3 / n as f64;
    for _ in 0..(2.5 / dt) as usize {
        scene.step(dt).unwrap();
    }
    disturbance(&scene) / before
}

#[test]
fn vortex_leaves_outflow_without_reflection() {
    let (short, long) = (left_behind(2.0, 24), left_behind(5.0, 24));
    println!("left behind: {short:.2e}, with the outflow far away {long:.2e}");
    assert!((short - long).abs() < 0.01, "{short} against {long}");
}

#[test]
fn mixing_momentum_loss_of_periodic_flow() {
    let petsc = petsc();
    let body = "[coupling]\nwall = \"mixing\"\n[[particle]]\n\
        shape = { disc = { diameter = 0.3 } }\nposition = [0.43, 0.52]\nmotion = \"fixed\"\n\
                [[particle]]\nshape = { disc = { diameter = 0.2 } }\nposition = [0.95, 0.98]\n\
                motion = { prescribed = { velocity = [0.3, 0.1], spin = 2.0 } }\n\
                [initial]\nvelocity = [1.0, 0.2]\n[pressure]\ndivergence_limit = 1.0e-9";
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [32, 32], 0.01, PERIODIC, body));
    let momentum = |scene: &Scene<2>| {
        [0, 1].map(|a| {
            scene.domain.grid.rows().flatten().map(|c| scene.state.u[a][c]).sum::<f64>()
                * scene.domain.grid.cell_volume()
        })
    };
    for _ in 0..20 {
        let before = momentum(&scene);
        scene.step(5e-3).unwrap();
        let after = momentum(&scene);
        let force: Vec<_> = scene.state.exchange.iter().map(|e| e.momentum).collect();
        for a in 0..2 {
            let lost = (before[a] - after[a]) / 5e-3;
            let taken = force[0][a] + force[1][a];
            assert!((lost - taken).abs() < 1e-9, "lost {lost}, taken {taken}");
        }
    }
}

#[test]
fn stream_between_two_outflows_decays_as_from_reservoir() {
    // Bernoulli at the side where it comes in: rho L dU/dt = -rho U^2/2, so that U = U_0/(1 + U_0
    // t/(2 L)).
    let sides = ["\"outflow\"", "\"outflow\"", "\"slip\"", "\"slip\""];
    let error = |steps: usize, towards: f64| {
        let initial = format!("[initial]\nvelocity = [{towards:?}, 0.0]\n");
        let petsc = petsc();
        let mut scene: Scene<2> = petsc.scene(&box_case([2.0, 0.5], [32, 8], 0.0, sides, &initial));
        for _ in 0..steps {
            scene.step(2.0 / steps as f64).unwrap();
        }
        let exact = towards / (1.0 + 2.0 / 4.0);
        let s = &scene.state;
        // Faces and cells alike, everywhere.
        let cells = scene
            .domain
            .grid
            .rows()
            .flatten()
            .map(|c| (s.u[0][c] - exact).abs())
            .fold(0.0, f64::max);
        let faces = scene
            .domain
            .grid
            .face_rows(0)
            .flatten()
            .map(|f| (s.faces[0][f] - exact).abs())
            .fold(0.0, f64::max);
        cells.max(faces)
    };
    // The inflow is known by the last step's velocity: of first order in time.
    let e = [100, 200, 400].map(|steps| error(steps, 1.0));
    assert!(e[2] < 1e-3 && order(e[1], e[2], 2.0) > 0.9, "{e:?}");
    assert!((error(200, -1.0) - e[1]).abs() < 1e-12);
}

#[test]
fn mirrored_stream_has_the_same_energy_budget() {
    let spent = |towards: f64| {
        let (inflow, at) = (format!("{{ inflow = [{towards:?}, 0.0] }}"), 0.6 + 0.3 * towards);
        let ends = if towards > 0.0 { [&inflow, "\"outflow\""] } else { ["\"outflow\"", &inflow] };
        let disc = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.307 }} }}\n\
            position = [{at:?}, 0.45]\nmotion = \"fixed\"\n"
        );
        let case =
            box_case([1.2, 1.0], [36, 30], 5e-4, [ends[0], ends[1], "\"wall\"", "\"wall\""], &disc);
        let petsc = petsc();
        let mut scene: Scene<2> = petsc.scene(&case);
        for _ in 0..20 {
            scene.step(0.005).unwrap();
        }
        let e = scene.state.energy;
        [e.losses.viscous, e.losses.method, e.work.boundaries].map(|part| part / e.fluid)
    };
    let [east, west] = [1.0, -1.0].map(spent);
    assert!(east.iter().zip(&west).all(|(a, b)| (a - b).abs() < 1e-8), "{east:?} {west:?}");
}

/// A fluidised column's floor: the stream that comes in lifts a disc by less than its weight, and
/// the inflow carries the rest as a grate does.
#[test]
fn heavy_disc_rests_on_inflow_boundary() {
    let petsc = petsc();
    for density in [2.65, 7.8] {
        let sides = ["\"slip\"", "\"slip\"", "{ inflow = [0.0, 0.2] }", "\"outflow\""];
        let disc = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 1.0 }} }}\nposition = [2.037, 1.5]\n\
            density = {density:?}\n\
             [contact]\nrestitution = 0.5\nfriction = 0.4\n"
        );
        let case = box_case([4.0, 4.0], [32, 32], 0.02, sides, &disc)
            .replace("viscosity = 0.02", "viscosity = 0.02\ngravity = [0.0, -10.0]");
        let mut scene: Scene<2> = petsc.scene(&case);
        for _ in 0..1500 {
            scene.step(0.01).unwrap();
        }
        let (body, exchange) = (&scene.state.bodies[0], &scene.state.exchange[0]);
        let weight = (density - 1.0) * 10.0 * std::f64::consts::PI / 4.0;
        let (lifted, carried) = (exchange.momentum.y / weight, exchange.contact.y / weight);
        println!(
            "s = {density}: at {:.5} m, the stream lifts {lifted:.4} of its weight, the inflow \
            carries {carried:.4}",
            body.centre.y
        );
        assert!((body.centre.y / 0.5 - 1.0).abs() < 2e-3, "s = {density}: {} m", body.centre.y);
        assert!(
            (lifted + carried - 1.0).abs() < 5e-3 && carried > 0.2,
            "s = {density}: {lifted} + {carried}"
        );
    }
}

/// A body beside an outflow: the profile continued into it read beyond the box what it had set
/// itself, and grew without bound in gaps of a fifth of a spacing and less. The flow is that around
/// one which is further in, give or take what the outflow does to it.
#[test]
fn body_that_touches_an_outflow_keeps_flow_calm() {
    let petsc = petsc();
    let stream = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"wall\"", "\"slip\""];
    let energy = |gap: f64, cells: f64| {
        // 0.4 spacings off the middle of a cell.
        let (h, d) = (0.04, 0.04 * cells);
        let disc = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = {d:?} }} }}\nposition = [{:?}, 0.516]\n\
            motion = \"fixed\"\n{SHARP}",
            2.0 - 0.5 * d - gap * h
        );
        let mut scene: Scene<2> = petsc.scene(&box_case([2.0, 1.0], [50, 25], 0.01, stream, &disc));
        for _ in 0..120 {
            scene.step(0.008).unwrap();
        }
        scene.state.energy.fluid
    };
    for cells in [4.0, 7.2, 12.0] {
        let calm = energy(3.0, cells);
        for gap in [0.0, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0] {
            let there = energy(gap, cells);
            println!(
                "{cells} cells, {gap} spacings from the outflow: {there:.4} J, {calm:.4} J further \
                in"
            );
            assert!(
                (there / calm - 1.0).abs() < 0.05,
                "{cells} cells, {gap} spacings: {there} J, {calm} J further in"
            );
        }
    }
}
