//! The budget of energy: exact flows, falls, contacts, and what the guard makes of a step that is
//! unstable.

use crate::rolling::on_a_floor;
use crate::support::{PERIODIC, SHARP, box_case, columns, mics, order, petsc, run};
use mics::scene::Scene;
use mics::state::EnergyBudget;
use std::f64::consts::PI;

/// Energy that the method takes of decaying vortices, over the start's, on so many cells a side.
fn vortices(n: usize) -> f64 {
    let petsc = petsc();
    let more = "[pressure]\ndivergence_limit = 1e-8";
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [n, n], 5e-3, PERIODIC, more));
    for c in scene.domain.grid.rows().flatten() {
        let [x, y] = scene.domain.grid.centre(c).map(|x| 2.0 * PI * x);
        (scene.state.u[0][c], scene.state.u[1][c]) = (x.sin() * y.cos(), -x.cos() * y.sin());
    }
    scene.start().unwrap();
    for _ in 0..n {
        scene.step(0.25 / n as f64).unwrap();
    }
    let e = scene.state.energy;
    let theory = 1.0 - (-16.0 * PI * PI * 5e-3 * 0.25f64).exp();
    assert!((1.0 - e.fluid / e.start - theory).abs() < 0.04 * theory, "{e:?} {theory}");
    assert_eq!(
        (
            e.work.boundaries,
            e.work.gravity,
            e.work.prescribed,
            e.losses.contacts,
            e.losses.friction
        ),
        (0.0, 0.0, 0.0, 0.0, 0.0)
    );
    e.losses.method.abs() / e.start
}

#[test]
fn decaying_vortices_viscous_loss_second_order() {
    let errors = [vortices(24), vortices(48)];
    println!("the method takes {errors:?} of the start");
    assert!(errors[1] < 2e-3 && order(errors[0], errors[1], 2.0) > 1.8, "{errors:?}");
}

#[test]
fn moving_wall_work_equals_viscous_loss() {
    let petsc = petsc();
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "{ moving_wall = [0.6, 0.0] }"];
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 0.5], [16, 8], 0.2, sides, ""));
    for c in scene.domain.grid.rows().flatten() {
        scene.state.u[0][c] = 1.2 * scene.domain.grid.centre(c)[1];
    }
    scene.start().unwrap();
    for _ in 0..10 {
        scene.step(2e-3).unwrap();
    }
    let (e, work) = (scene.state.energy, 0.02 * 0.2 * 1.2 * 1.2 * 0.5);
    assert!(
        (e.work.boundaries / work - 1.0).abs() < 1e-10
            && (e.losses.viscous / work - 1.0).abs() < 1e-10,
        "{e:?} {work}"
    );
    assert!(e.losses.method.abs() < 1e-10 * work, "{e:?}");
}

/// In the first step the wall does its work on a fluid at rest, at a shear that one layer of cells
/// later is half as much: by what there was after it alone, that step made more energy than was
/// given, and the run was refused.
#[test]
fn impulsively_started_wall_has_no_spurious_energy_gain() {
    for scheme in ["euler", "rk2", "rk3", "rkl2", "rkl3"] {
        let dir = tempfile::tempdir().unwrap();
        let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "{ moving_wall = [0.02, 0.0] }"];
        let time = format!("[output]\nfigures = false\n[time]\nend = 1.0\nscheme = \"{scheme}\"\n");
        let case = dir.path().join("case.toml");
        std::fs::write(&case, box_case([0.01, 0.012], [8, 24], 5e-5, sides, &time)).unwrap();
        run(&case, &dir.path().join("out"), &[]);
        let steps = columns(&dir.path().join("out/steps.csv"));
        let (given, lost) = (&steps["boundary_work"], &steps["method_loss"]);
        let last = given.len() - 1;
        println!(
            "{scheme}: {:.3} of the work in the first step, {:.4} in {last} steps",
            lost[1] / given[1],
            lost[last] / given[last]
        );
        // Explicit steps near their limit do make some, and Euler's the most.
        let most = if scheme == "euler" { 0.9 } else { 0.5 };
        assert!(
            lost[1].abs() < most * given[1] && lost[last].abs() < 0.03 * given[last],
            "{scheme}"
        );
    }
}

#[test]
fn falling_disc_energy_budget_closes() {
    let petsc = petsc();
    let more = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 0.25 }} }}\nposition = [0.5, 1.5]\n\
        density = 1.5\n{SHARP}"
    );
    let text = box_case([1.0, 2.0], [64, 128], 0.01, ["\"wall\""; 4], &more)
        .replace("viscosity = 0.01", "viscosity = 0.01\ngravity = [0.0, -1.0]");
    let mut scene: Scene<2> = petsc.scene(&text);
    for _ in 0..250 {
        scene.step(4e-3).unwrap();
    }
    let (e, body) = (scene.state.energy, &scene.state.bodies[0]);
    let potential = 0.5 * body.volume() * (1.5 - body.centre.y);
    println!("{e:?}");
    assert!((e.work.gravity / potential - 1.0).abs() < 0.01, "{} of {potential}", e.work.gravity);
    // The viscous loss in the cells at the wall is counted too high, the less the finer: -0.0132,
    // -0.0089, -0.0052, -0.0032 at 48, 64, 96, 128 cells a metre, whichever way it falls.
    assert!(
        e.losses.method > -0.6 / 64.0 * e.work.gravity && e.losses.method < 0.05 * e.work.gravity,
        "{e:?}"
    );
    assert!(
        e.losses.viscous > 0.1 * e.work.gravity
            && e.bodies > 0.05 * e.work.gravity
            && e.fluid > 0.05 * e.work.gravity,
        "{e:?}"
    );
}

#[test]
fn rebound_contact_loss_matches_restitution() {
    let petsc = petsc();
    for (wall, restitution) in [(SHARP, 0.5), (SHARP, 0.9)] {
        let more = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.25 }} }}\nposition = [0.5, 0.17]\n\
            velocity = [0.0, -1.0]\n\
             density = 1e4\n[contact]\nrestitution = {restitution}\n{wall}"
        );
        let mut scene: Scene<2> =
            petsc.scene(&box_case([1.0, 1.0], [32, 32], 1e-4, ["\"wall\""; 4], &more));
        for _ in 0..60 {
            scene.step(2e-3).unwrap();
        }
        let e = scene.state.energy;
        let lost = e.losses.contacts / e.start;
        assert!(
            (lost - (1.0 - restitution * restitution)).abs() < 0.02,
            "{wall} {restitution}: {lost} {e:?}"
        );
        assert!(
            e.losses.method.abs() < 5e-3 * e.start && e.losses.friction.abs() < 1e-9 * e.start,
            "{wall} {restitution}: {e:?}"
        );
        assert!(e.springs.abs() < 1e-9 * e.start, "they have parted: {e:?}");
    }
}

/// The work of a contact is that of the velocity at which it meets the body, not of the one that
/// gravity would have given it by the end of the step.
#[test]
fn rebound_in_gas_under_gravity_loses_nothing_by_contact() {
    let petsc = petsc();
    let more = "[[particle]]\nshape = { disc = { diameter = 0.02 } }\nposition = [0.0403, 0.03]\n\
        density = 2650.0\n[contact]\nrestitution = 1.0\n";
    let text = box_case([0.08, 0.06], [32, 24], 1.8e-5, ["\"wall\""; 4], more)
        .replace("density = 1.0\n", "density = 1.2\ngravity = [0.0, -9.81]\n");
    let mut scene: Scene<2> = petsc.scene(&text);
    let mut most = 0.0f64;
    while scene.state.time < 0.08 {
        scene.step(5e-4).unwrap();
        most = most.max(scene.state.energy.work.gravity);
    }
    let e = scene.state.energy;
    assert!(
        e.losses.contacts.abs() < 4e-3 * most && e.losses.method.abs() < 2e-3 * most,
        "{most}: {e:?}"
    );
}

/// The viscous loss between walls is that of the fluid between them: a channel of three or four
/// cells begins from rest, without a spurious energy gain.
#[test]
fn narrow_channel_from_rest_has_no_energy_gain() {
    let petsc = petsc();
    for (half, most) in [(0.0625, 0.2), (0.0833, 0.15), (0.07, 0.3)] {
        let wall = |low: f64, high: f64| {
            format!(
                "[[obstacle]]\npolygon = {{ points = [[0, {low}], [1, {low}], [1, {high}], \
                [0, {high}]] }}\n"
            )
        };
        let more = format!(
            "[drive]\nforce = [1.0, 0.0]\n{}{}",
            wall(-0.2, 0.5 - half),
            wall(0.5 + half, 1.2)
        );
        let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];
        let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [24, 24], 1.0, sides, &more));
        for _ in 0..60 {
            scene.step(5e-4).unwrap();
        }
        let e = scene.state.energy;
        let share = e.losses.method / e.work.drive;
        println!("{half}: {share:+.3}");
        assert!(share.abs() < most, "{half}: {share} {e:?}");
    }
}

/// An impact's pressure lasts for one step, and works on an inflow in that step alone, whichever it
/// is.
#[test]
fn impact_near_inflow_energy_does_not_depend_on_the_step() {
    let petsc = petsc();
    let sides = ["{ inflow = [0.2, 0.0] }", "\"outflow\"", "\"wall\"", "\"wall\""];
    let budgets: Vec<_> = [0.9, 0.908, 0.916, 0.924]
        .into_iter()
        .map(|x| {
            let more = format!(
                "[[particle]]\nshape = {{ disc = {{ diameter = 0.2 }} }}\nposition = [0.6, 0.5]\n\
             motion = {{ prescribed = {{ velocity = [0.3, 0.0] }} }}\n\
             [[particle]]\nshape = {{ disc = {{ diameter = 0.2 }} }}\nposition = [{x:?}, 0.5]\n\
             density = 7.85\n\
             [contact]\nrestitution = 0.5\n{SHARP}"
            );
            let mut scene: Scene<2> =
                petsc.scene(&box_case([2.0, 1.0], [80, 40], 4e-4, sides, &more));
            for _ in 0..120 {
                scene.step(0.015).unwrap();
            }
            scene.state.energy
        })
        .collect();
    let spread = |of: &dyn Fn(&EnergyBudget) -> f64| {
        let all = || budgets.iter().map(of);
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    let given = budgets[0].work.prescribed;
    let (boundaries, method) = (spread(&|e| e.work.boundaries), spread(&|e| e.losses.method));
    assert!(
        boundaries < 0.02 * given && method < 0.03 * given,
        "{boundaries} and {method} of {given}: {budgets:?}"
    );
}

#[test]
fn sliding_disc_loses_a_third_of_energy_to_friction() {
    let petsc = petsc();
    let mut scene: Scene<2> = petsc.scene(&on_a_floor::<2>(SHARP, 0.25, [0.0, -4.0], 1.0));
    for _ in 0..120 {
        scene.step(4e-3).unwrap();
    }
    let (e, body) = (scene.state.energy, &scene.state.bodies[0]);
    let start = 0.5 * body.mass();
    assert!(
        (e.losses.friction / start * 3.0 - 1.0).abs() < 0.05,
        "{} of {start}: {e:?}",
        e.losses.friction
    );
}

/// The momentum-interpolation correction has to fade by viscosity too: in a flow that hardly moves
/// nothing else takes it.
#[test]
fn settling_sphere_in_creeping_flow_has_no_energy_gain() {
    let petsc = petsc();
    let sides = ["west", "east", "south", "north", "bottom", "top"]
        .map(|side| format!("{side} = \"wall\"\n"))
        .concat();
    let mut scene: Scene<3> = petsc.scene(&format!(
        "name = \"creep\"\n[domain]\nsize = [2.0, 2.0, 2.0]\ncells = [16, 16, 16]\n[fluid]\n\
        density = 1.0\nviscosity = 1.0\n\
         gravity = [0.0, -1.0, 0.0]\n[boundary]\n{sides}[[particle]]\n\
         shape = {{ sphere = {{ diameter = 1.0 }} }}\n\
         position = [1.03, 1.2, 1.0]\ndensity = 1.5\n{SHARP}[time]\nend = 9.0\n[pressure]\n\
         divergence_limit = 1e-5\n"
    ));
    for _ in 0..700 {
        scene.step(2e-3).unwrap();
    }
    let e = scene.state.energy;
    println!("{e:?}");
    assert!(
        e.losses.method.abs() < 0.05 * e.work.gravity
            && (e.losses.viscous / e.work.gravity - 1.0).abs() < 0.1,
        "{e:?}"
    );
}

#[test]
fn disc_in_creeping_flow_has_steady_speed_and_no_energy_gain() {
    let petsc = petsc();
    let more = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 1.0 }} }}\nposition = [2.0, 0.75]\n\
        density = 1.15\n{SHARP}\
         [pressure]\ndivergence_limit = 1e-9"
    );
    let sides = ["\"slip\"", "\"slip\"", "\"wall\"", "\"slip\""];
    let text = box_case([4.0, 3.0], [32, 24], 1.0, sides, &more)
        .replace("viscosity = 1.0", "viscosity = 1.0\ngravity = [0.0, -1e-4]");
    let mut scene: Scene<2> = petsc.scene(&text);
    let mut speeds = Vec::new();
    for k in 0..2000 {
        scene.step(3e-3).unwrap();
        if k % 500 == 499 {
            speeds.push(scene.state.bodies[0].velocity.y);
        }
    }
    let e = scene.state.energy;
    let spread = speeds.iter().fold(0.0f64, |most, v| most.max((v / speeds[0] - 1.0).abs()));
    assert!(speeds[0] < -1e-7 && spread < 2e-3, "{speeds:?}");
    assert!(
        e.losses.method.abs() < 0.2 * e.work.gravity && e.losses.viscous > 0.5 * e.work.gravity,
        "{e:?}"
    );
}

/// The flow in the pocket between a body that may move and two walls stays in the
/// momentum-interpolation correction unless viscosity takes it fast enough; it grew, in the
/// pocket's own time, until it had more energy than all work had given.
#[test]
fn disc_spinning_slowly_in_corner_has_no_energy_gain() {
    let petsc = petsc();
    for gap in [0.3, 0.786] {
        let centre = 32.0 - gap - 4.193;
        let more = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 8.386 }} }}\nposition = [{centre}, {}]\n\
             motion = {{ prescribed = {{ velocity = [0.0, 0.0], spin = 1e-3 }} }}\n\
             {SHARP}[pressure]\ndivergence_limit = 1e-6",
            32.0 - 0.786 - 4.193
        );
        let text = box_case([32.0, 32.0], [32, 32], 1.0, ["\"wall\""; 4], &more);
        let mut scene: Scene<2> = petsc.scene(&text);
        for _ in 0..1100 {
            scene.step(0.9).unwrap();
        }
        let e = scene.state.energy;
        println!("{gap}: {e:?}");
        assert!(e.losses.method.abs() < 0.2 * e.work.prescribed, "{e:?}");
    }
}

/// The tangential damper of the paper's law, as printed, drives what it should slow: friction makes
/// energy, and nothing holds it but the guard.
#[test]
fn spurious_energy_gain_ends_run_with_moving_walls_and_bodies() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (dir.path().join("case.toml"), dir.path().join("run"));
    let text = on_a_floor::<2>(SHARP, 0.5, [0.0, -4.0], 0.01)
        .replace("north = \"slip\"", "north = { moving_wall = [0.01, 0.0] }")
        .replace("[contact]\n", "[contact]\ntangential_damping = \"printed\"\n")
        .replace("restitution = 0.2", "restitution = 0.01")
        + "\n[[particle]]\nshape = { disc = { diameter = 0.5 } }\nposition = [3.0, 1.5]\n\
            motion = { prescribed = { spin = 0.1 } }\n";
    std::fs::write(&case, text).unwrap();
    let output = mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--quiet"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("energy balance violated") && said.contains("particle 0 the fastest"),
        "{said}"
    );
    assert!(said.contains("gained, mostly by friction"), "{said}");
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("\"failed\""), "{summary}");
}

/// Viscosity takes much in few steps when two meet; what it took before, eight steps apart, says
/// nothing of that.
#[test]
fn approaching_discs_in_long_steps_have_no_energy_gain() {
    let petsc = petsc();
    let disc = |x: f64, y: f64, u: f64, v: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.2 }} }}\nposition = [{x:?}, {y:?}]\n\
            density = 2.5\nvelocity = [{u:?}, {v:?}]\n"
        )
    };
    let bodies = disc(0.45, 0.514, 1.0, 0.216) + &disc(0.75, 0.5, -1.0, -0.077);
    let more = format!(
        "{bodies}{SHARP}[contact]\nrestitution = 0.8\nfriction = 0.3\n[pressure]\n\
        divergence_limit = 1e-6\n"
    );
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];
    let mut scene: Scene<2> = petsc.scene(&box_case([1.5, 1.0], [48, 32], 0.02, sides, &more));
    let (start, mut least) = (scene.state.energy.start, 0.0f64);
    while scene.state.time < 0.6 {
        scene.step(0.4 * 0.2 / 8.0).unwrap();
        least = least.min(scene.state.energy.losses.method / start);
    }
    println!("least {least}, at the end {}", scene.state.energy.losses.method / start);
    assert!(
        least > -1e-3 && scene.state.energy.losses.contacts > 0.01 * start,
        "{least}: {:?}",
        scene.state.energy
    );
}

/// The momentum-interpolation correction in the corners of a closed box has to fade, also where
/// cells are longer one way.
#[test]
fn flow_around_resting_body_decays_in_cells_of_any_aspect_ratio() {
    let fades = |left: f64| assert!(left < 1e-8, "{left:e} of the energy is left");
    for height in [0.5, 0.8] {
        let petsc = petsc();
        let more = "[initial]\nperturbation = 1e-3\n[pressure]\ndivergence_limit = 1e-8\n\
            [[particle]]\nposition = [0.47, 0.22]\n\
                    shape = { disc = { diameter = 0.15 } }\n\
                    motion = { prescribed = { velocity = [0.0, 0.0] } }\n";
        let mut scene: Scene<2> =
            petsc.scene(&box_case([1.0, height], [24, 24], 1.0, ["\"wall\""; 4], more));
        let start = scene.state.energy.start;
        for _ in 0..600 {
            scene.step(5e-4).unwrap();
        }
        fades(scene.state.energy.fluid / start);
    }
}
