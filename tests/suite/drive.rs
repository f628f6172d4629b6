//! What moves the fluid besides its borders: exact channel flow, a mean velocity that is held in every step, and what bodies feel.

use crate::support::{box_case, order, petsc};
use mics::drive::{box_volume, mean};
use mics::scene::Scene;
use nalgebra::Vector3;
use std::f64::consts::PI;

const PERIODIC: [&str; 4] = ["\"periodic\""; 4];
const CHANNEL: [&str; 4] = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];

/// Kinematic viscosity and the force over density of a channel 1 m high whose mean velocity is 1 m/s.
const NU: f64 = 0.05;
const PUSH: f64 = 12.0 * NU;

fn disc(place: [f64; 2], density: f64, more: &str) -> String {
    format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 0.6 }} }}\nposition = {place:?}\ndensity = {density:?}\n{more}\n"
    )
}

/// The largest error of the velocity, and the force found (N/m3), of a channel of so many cells once it is steady.
fn channel(cells: usize, drive: &str, gravity: &str) -> (f64, f64) {
    let petsc = petsc();
    let text = box_case([1.0, 1.0], [8, cells], 2.0 * NU, CHANNEL, &format!("[drive]\n{drive}"));
    let text = text.replace("density = 1.0", "density = 2.0").replace("viscosity", &format!("{gravity}\nviscosity"));
    let mut scene: Scene<2> = petsc.scene(&text);
    let dt = 0.15 / (NU * (cells * cells) as f64);
    for _ in 0..(16.0 / dt) as usize {
        scene.step(dt).unwrap();
    }
    let exact = |y: f64| 6.0 * y * (1.0 - y);
    let grid = &scene.domain.grid;
    let error = grid.rows().flatten().map(|c| (scene.state.u[0][c] - exact(grid.centre(c)[1])).abs());
    (error.fold(0.0, f64::max), scene.state.drive.unwrap().x)
}

#[test]
fn a_channel_by_a_force_by_a_slope_and_by_its_flow_rate_is_poiseuilles_to_second_order() {
    let slope = format!("gravity = [{PUSH:?}, -9.81]");
    for (drive, gravity) in [
        (format!("force = [{:?}, 0.0]", 2.0 * PUSH), ""),
        ("gravity = true".to_owned(), slope.as_str()),
        ("mean_velocity = { axis = \"x\", value = 1.0 }".to_owned(), ""),
    ] {
        let [coarse, fine] = [8, 16].map(|cells| channel(cells, &drive, gravity));
        let order = order(coarse.0, fine.0, 2.0);
        println!("{drive}: {:.2e}, {:.2e} m/s, order {order:.3}; force {:.5} N/m3", coarse.0, fine.0, fine.1);
        assert!(fine.0 < 6e-3 && (1.9..2.1).contains(&order), "{drive}: {coarse:?}, {fine:?}");
        assert!((fine.1 / (2.0 * PUSH) - 1.0).abs() < 9e-3, "{drive}: {} N/m3", fine.1);
    }
}

/// Two discs, one heavy and one light, that fall and meet in a periodic box with this drive and wall.
fn pair(drive: &str, wall: &str) -> Scene<2> {
    let bodies = disc([1.03, 1.02], 3.0, "velocity = [0.0, -0.4]") + &disc([1.13, 0.32], 0.5, "velocity = [0.0, 0.4]");
    let more = format!("[drive]\n{drive}\n[coupling]\nwall = \"{wall}\"\n{bodies}[contact]\n[pressure]\ndivergence_limit = 1e-6\n");
    let text = box_case([2.0, 2.0], [32, 32], 0.05, PERIODIC, &more);
    petsc().scene(&text.replace("viscosity", "gravity = [0.0, -1.0]\nviscosity"))
}

#[test]
fn a_mean_velocity_is_held_in_every_step_among_bodies_that_move_and_meet() {
    for wall in ["sharp", "mixing"] {
        let mut scene = pair("mean_velocity = { axis = \"y\", value = 0.2 }", wall);
        let mut touched = false;
        for _ in 0..60 {
            scene.step(0.01).unwrap();
            let held = mean(&scene.domain.session, &scene.domain.grid, 1, &scene.state.faces).unwrap();
            assert!((held - 0.2).abs() < 1e-13, "{wall}: {held} m/s after {} steps", scene.state.steps);
            let error = scene.state.balance.unwrap().error.amax();
            assert!(error < 1e-12, "{wall}: {error} kg m/s are missing");
            touched |= scene.state.exchange[0].contact.norm() > 0.0;
        }
        assert!(touched, "{wall}: they never met");
        let e = scene.state.energy;
        // The mixing takes a fourth of the energy where it cuts cells.
        let taken = if wall == "sharp" { 0.05 } else { 0.3 };
        assert!(e.drive != 0.0 && e.method.abs() < taken * e.scale(), "{wall}: {e:?}");
    }
}

#[test]
fn a_mixture_that_is_held_gathers_no_momentum_and_one_that_is_not_does() {
    for wall in ["sharp", "mixing"] {
        let mut scene = pair("hold_mixture = true", wall);
        scene.step(0.01).unwrap();
        let before = scene.state.balance.unwrap().momentum;
        for _ in 0..60 {
            scene.step(0.01).unwrap();
        }
        let gathered = (scene.state.balance.unwrap().momentum - before).amax();
        assert!(gathered < 1e-12, "{wall}: {gathered} kg m/s");
        let weight = (2.0 - 0.5) * PI * 0.09;
        let force = scene.state.drive.unwrap();
        assert!((force - Vector3::new(0.0, weight / 4.0, 0.0)).norm() < 1e-12, "{wall}: {force} N/m3");
    }
}

#[test]
fn what_a_fixed_body_feels_is_what_the_drive_gives() {
    let petsc = petsc();
    let (area, force) = (0.25 * PI * 0.36, 0.5);
    for wall in ["sharp", "mixing"] {
        let body = disc([1.03, 1.02], 1.0, "motion = \"fixed\"");
        let steady = |drive: &str| {
            let more = format!("[drive]\n{drive}\n[coupling]\nwall = \"{wall}\"\n{body}[pressure]\ndivergence_limit = 1e-7\n");
            let text = box_case([2.0, 2.0], [20, 20], 1.0, PERIODIC, &more);
            let mut scene: Scene<2> = petsc.scene(&text.replace("viscosity", "gravity = [0.5, 0.0]\nviscosity"));
            for _ in 0..2000 {
                scene.step(2e-3).unwrap();
            }
            let mean = mean(&scene.domain.session, &scene.domain.grid, 0, &scene.state.faces).unwrap();
            (scene.state.exchange[0].momentum.x, mean, scene.state.drive.unwrap().x, box_volume(&scene.domain.grid))
        };
        // On the fluid alone, the body has what the fluid has got; as a gradient of the pressure, its own volume's as well.
        let (on_fluid, flow, _, volume) = steady("force = [0.5, 0.0]");
        assert!((on_fluid / (force * (volume - area)) - 1.0).abs() < 5e-3, "{wall}: {on_fluid} N");
        let (on_all, flow_of_slope, _, _) = steady("gravity = true");
        assert!((on_all / (force * volume) - 1.0).abs() < 5e-3, "{wall}: {on_all} N");
        // The mixing shares a force on the fluid out in the cells that it cuts.
        let tolerance = if wall == "sharp" { 1e-9 } else { 0.02 };
        assert!((flow / flow_of_slope - 1.0).abs() < tolerance, "{wall}: {flow} and {flow_of_slope} m/s");
        let (_, held, found, _) = steady(&format!("mean_velocity = {{ axis = \"x\", value = {flow_of_slope:?} }}"));
        assert!((held - flow_of_slope).abs() < 1e-13 && (found / force - 1.0).abs() < 5e-3, "{wall}: {found} N/m3");
    }
}

#[test]
fn a_body_of_the_fluids_density_goes_with_a_fluid_that_a_slope_sets_off() {
    for (wall, tolerance) in [("sharp", 0.015), ("mixing", 1e-9)] {
        let more = format!("[drive]\ngravity = true\n[coupling]\nwall = \"{wall}\"\n{}", disc([1.03, 1.02], 1.0, ""));
        let text = box_case([2.0, 2.0], [32, 32], 0.05, PERIODIC, &more);
        let mut scene: Scene<2> = petsc().scene(&text.replace("viscosity", "gravity = [0.5, 0.25]\nviscosity"));
        for _ in 0..20 {
            scene.step(0.02).unwrap();
        }
        let velocity = scene.state.bodies[0].velocity / 0.4;
        let off = (velocity - Vector3::new(0.5, 0.25, 0.0)).amax();
        assert!(off < tolerance * 0.5, "{wall}: {velocity} m/s2");
    }
}
