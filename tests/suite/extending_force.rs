//! Forces per volume that a library's user adds.

use crate::allocation::count;
use crate::modes::in_processes;
use crate::support::{PERIODIC, SHARP, box_case, case, order, petsc};
use mics::Result;
use mics::force::Force;
use mics::petsc::Session;
use mics::scene::Scene;
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The force of a Kolmogorov flow: `strength sin(k y)` (N/m3) along x, k = `wavenumber` (1/m).
struct Kolmogorov {
    strength: f64,
    wavenumber: f64,
}

impl Force for Kolmogorov {
    fn at(&self, place: &Vector3<f64>, _time: f64, _velocity: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(self.strength * (self.wavenumber * place.y).sin(), 0.0, 0.0)
    }
}

/// A force of any form.
struct Given<F>(F);

impl<F: Fn(&Vector3<f64>, f64, &Vector3<f64>) -> Vector3<f64> + Send + Sync> Force for Given<F> {
    fn at(&self, place: &Vector3<f64>, time: f64, velocity: &Vector3<f64>) -> Vector3<f64> {
        (self.0)(place, time, velocity)
    }
}

/// The scene of a case of this text, with a force.
fn forced(session: &Session, text: &str, force: impl Force + 'static) -> Result<Scene<2>> {
    Scene::extended(session, &case(text), None, vec![Arc::new(force)])
}

/// The steady flow is `F/(mu k^2) sin(k y)` (Meshalkin and Sinai 1961).
#[test]
fn external_force_kolmogorov_flow_second_order() {
    let petsc = petsc();
    let error = |cells: usize| {
        let text = box_case([1.0, 1.0], [8, cells], 0.1, PERIODIC, "");
        let force = Kolmogorov { strength: 2.0, wavenumber: TAU };
        let mut scene = forced(&petsc.session, &text, force).unwrap();
        // Ten times the time in which viscosity takes 1 - 1/e of a flow.
        let (end, dt) = (10.0 / (0.1 * TAU * TAU), 0.25 / (cells * cells) as f64);
        while scene.state.time < end {
            scene.step(dt).unwrap();
        }
        let grid = &scene.domain.grid;
        let largest = 2.0 / (0.1 * TAU * TAU);
        let off =
            |c: usize| (scene.state.u[0][c] / largest - (TAU * grid.centre(c)[1]).sin()).abs();
        grid.rows().flatten().map(off).fold(0.0, f64::max)
    };
    let [coarse, fine] = [8, 16].map(error);
    println!(
        "Kolmogorov flow: errors {coarse:.2e}, {fine:.2e}, order {:.2}",
        order(coarse, fine, 2.0)
    );
    assert!(fine < 0.02 && order(coarse, fine, 2.0) > 1.9, "{coarse} {fine}");
}

#[test]
fn external_time_dependent_force_second_order() {
    let petsc = petsc();
    let error = |steps: u32| {
        let text = box_case([1.0, 1.0], [8, 8], 0.1, PERIODIC, "");
        let force =
            Given(|_: &Vector3<f64>, t: f64, _: &Vector3<f64>| Vector3::new(t.cos(), 0.0, 0.0));
        let mut scene = forced(&petsc.session, &text, force).unwrap();
        (0..steps).for_each(|_| _ = scene.step(1.0 / f64::from(steps)).unwrap());
        let cell = scene.domain.grid.rows().flatten().next().unwrap();
        // Its work is all that the fluid has.
        let e = &scene.state.energy;
        assert!((e.work.drive - e.fluid).abs() < 1e-12, "{e:?}");
        (scene.state.u[0][cell] - 1f64.sin()).abs()
    };
    let [coarse, fine] = [10, 20].map(error);
    println!("a force cos(t): errors {coarse:.2e}, {fine:.2e}");
    assert!(order(coarse, fine, 2.0) > 1.95 && fine < 1e-3, "{coarse} {fine}");
}

/// A relaxation zone takes the velocity to what it asks for.
#[test]
fn external_velocity_dependent_force_reaches_target() {
    let petsc = petsc();
    let text = box_case([1.0, 1.0], [16, 8], 1e-3, PERIODIC, "");
    let sponge = |_: &Vector3<f64>, _: f64, u: &Vector3<f64>| 5.0 * (Vector3::x() - u);
    let mut scene = forced(&petsc.session, &text, Given(sponge)).unwrap();
    (0..200).for_each(|_| _ = scene.step(0.01).unwrap());
    let grid = &scene.domain.grid;
    let off = grid.rows().flatten().map(|c| (scene.state.u[0][c] - 1.0).abs()).fold(0.0, f64::max);
    assert!(off < 1e-4, "{off}");
}

/// In a closed box the pressure holds a uniform force: a body there has its buoyancy, and no fluid
/// moves.
#[test]
fn external_force_gives_buoyancy_and_closes_momentum_balance() {
    let petsc = petsc();
    let body = |motion: &str| {
        format!(
            "{SHARP}[[particle]]\nshape.disc.diameter = 0.3\nposition = [0.52, 0.47]\n\
             density = 1.5\nmotion = {motion}\n"
        )
    };
    let uniform =
        || Given(|_: &Vector3<f64>, _: f64, _: &Vector3<f64>| Vector3::new(3.0, -1.0, 0.0));
    let text = box_case([1.0, 1.0], [32, 32], 0.05, ["\"wall\""; 4], &body("\"fixed\""));
    let mut scene = forced(&petsc.session, &text, uniform()).unwrap();
    (0..200).for_each(|_| _ = scene.step(0.004).unwrap());
    let found = scene.state.exchange[0].momentum / scene.state.bodies[0].volume();
    let (_, speed) = scene.energy_and_speed().unwrap();
    println!("buoyancy {found:?} of (-3, 1) N/m3, fluid at {speed:.1e} m/s");
    assert!((found - Vector3::new(-3.0, 1.0, 0.0)).norm() < 0.015 && speed < 5e-3, "{found:?}");

    let free = "{ free = {} }\n[contact]\nfriction = 0.0";
    let text = box_case([1.0, 1.0], [32, 32], 0.05, PERIODIC, &body(free));
    let swirl = Given(|x: &Vector3<f64>, t: f64, _: &Vector3<f64>| {
        Vector3::new((TAU * x.y).sin() + t, (TAU * x.x).cos(), 0.0)
    });
    let mut scene = forced(&petsc.session, &text, swirl).unwrap();
    for _ in 0..60 {
        scene.step(0.004).unwrap();
        let balance = scene.state.balance.unwrap();
        assert!(balance.error.norm() < 1e-12, "{balance:?}");
    }
    let e = &scene.state.energy;
    println!(
        "energy: drive {:.3e} method {:.3e} fluid {:.3e}",
        e.work.drive, e.losses.method, e.fluid
    );
    assert!(e.work.drive > 0.0 && e.losses.method.abs() < 0.05 * e.work.drive, "{e:?}");
}

#[test]
fn external_force_with_mixing_is_refused() {
    let petsc = petsc();
    let more = "[coupling]\nwall = \"mixing\"\n[[particle]]\nshape.disc.diameter = 0.3\n\
                position = [0.5, 0.5]\nmotion = \"fixed\"\n";
    let text = box_case([1.0, 1.0], [16, 16], 0.1, PERIODIC, more);
    let force = Kolmogorov { strength: 2.0, wavenumber: TAU };
    let refused = forced(&petsc.session, &text, force).err().unwrap();
    assert!(refused.to_string().contains("coupling.wall"), "{refused}");
}

/// A free disc beside a fixed one.
const DISCS: &str = "[contact]\nfriction = 0.3\n\
     [[particle]]\nshape.disc.diameter = 0.35\nposition = [0.3, 0.4]\ndensity = 1.2\n\
     [[particle]]\nshape.disc.diameter = 0.35\nposition = [0.72, 0.6]\nmotion = \"fixed\"\n";

fn swept(session: &Session, bodies: &str) -> Scene<2> {
    let sides = ["\"periodic\"", "\"periodic\"", "{ moving_wall = [1.0, 0.0] }", "\"wall\""];
    let text = box_case([1.0, 1.0], [24, 24], 0.05, sides, bodies);
    forced(session, &text, Kolmogorov { strength: 2.0, wavenumber: TAU }).unwrap()
}

#[test]
fn step_with_external_force_allocates_nothing() {
    let petsc = petsc();
    for bodies in ["", DISCS] {
        let mut scene = swept(&petsc.session, bodies);
        scene.step(1e-3).unwrap();
        let before = count();
        (0..5).for_each(|_| _ = scene.step(1e-3).unwrap());
        assert_eq!(count() - before, 0);
    }
}

#[test]
fn external_force_agrees_on_any_number_of_ranks() {
    let test = "extending_force::external_force_agrees_on_any_number_of_ranks";
    let said = in_processes(test, &[(1, ""), (2, ""), (4, "")], |session| {
        let mut scene = swept(session, DISCS);
        (0..10).for_each(|_| _ = scene.step(2e-3).unwrap());
        let (e, free) = (&scene.state.energy, &scene.state.bodies[0]);
        if session.rank() == 0 {
            println!(
                "state {:?}",
                [e.work.drive, e.fluid, e.work.boundaries, free.velocity.x, free.spin.z]
            );
        }
    });
    let state = |said: &String| -> Vec<f64> {
        let line = said.lines().find_map(|line| line.split("state [").nth(1)).unwrap();
        line.trim_end_matches(']').split(", ").map(|x| x.parse().unwrap()).collect()
    };
    let states: Vec<Vec<f64>> = said.iter().map(state).collect();
    println!("{states:?}");
    for (one, many) in states.iter().skip(1).flat_map(|many| states[0].iter().zip(many)) {
        assert!((one - many).abs() < 1e-6 * one.abs(), "{states:?}");
    }
}
