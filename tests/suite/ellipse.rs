//! Ellipses held in a stream and free.

use crate::allocation::count;
use crate::ellipse_shape::ellipse;
use crate::modes::in_processes;
use crate::support::{PERIODIC, Petsc, STREAM, box_case, case, petsc};
use mics::geometry::{Disc, Shape};
use mics::particles::{Body, Freedom, Motion};
use mics::petsc::Session;
use mics::scene::Scene;
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

pub const PLANE: Motion =
    Motion::Free(Freedom { translation: [true, true, false], rotation: [false, false, true] });

pub fn body(shape: impl Shape + 'static, density: f64, place: [f64; 2], angle: f64) -> Body {
    let mut body = Body::new(Arc::new(shape), density, 0.01, Vector3::new(place[0], place[1], 0.0));
    body.orientation = UnitQuaternion::from_scaled_axis(Vector3::z() * angle);
    body.angle = angle;
    body
}

pub fn scene_of(session: &Session, text: &str, bodies: Vec<Body>) -> Scene<2> {
    Scene::with_bodies(session, &case(text), bodies).unwrap_or_else(|e| panic!("{e}"))
}

fn scene(petsc: &Petsc, text: &str, bodies: Vec<Body>) -> Scene<2> {
    scene_of(&petsc.session, text, bodies)
}

pub fn first(scene: &Scene<2>) -> &Body {
    &scene.state.bodies[0]
}

/// Force and torque on a body held in a stream at a Reynolds number of 40 a diameter of 0.25, after
/// a second.
pub fn held(petsc: &Petsc, body: Body, more: &str) -> (Vector3<f64>, f64) {
    let more =
        format!("[initial]\nvelocity = [1.0, 0.0]\n[pressure]\ndivergence_limit = 1.0e-8\n{more}");
    let text = box_case([2.0, 1.0], [64, 32], 0.25 / 40.0, STREAM, &more);
    let mut scene = scene(petsc, &text, vec![body]);
    for _ in 0..100 {
        scene.step(0.01).unwrap();
    }
    let exchange = scene.state.exchange[0];
    (exchange.momentum, exchange.momentum_torque.z)
}

#[test]
fn ellipse_of_equal_axes_has_force_of_disc() {
    let (petsc, place) = (petsc(), [0.61, 0.47]);
    let (disc, _) = held(&petsc, body(Disc { radius: 0.125 }, 1.0, place, 0.0), "");
    let (ellipse, _) = held(&petsc, body(ellipse(0.125, 0.125), 1.0, place, 0.7), "");
    let apart = (ellipse - disc).norm() / disc.norm();
    println!("{:.6} {:.6} N/m, an ellipse's {apart:.1e} from it", disc.x, disc.y);
    assert!(apart < 1e-5, "{disc} {ellipse}");
}

#[test]
fn inclined_ellipse_and_mirror_image_have_opposite_lift() {
    let petsc = petsc();
    for (name, more) in [("sharp", ""), ("mixing", "[coupling]\nwall = \"mixing\"")] {
        // Turned back by half a radian its front, on the left, is up.
        let [up, down] = [-0.5, 0.5].map(|angle| {
            let ellipse = ellipse(0.2, 0.1);
            held(&petsc, body(ellipse, 1.0, [0.6, 0.5], angle), more)
        });
        println!("{name}: drag {:.5}, lift {:.5}, torque {:.6}", up.0.x, up.0.y, up.1);
        // Pressure takes hold at the front: it lifts that, clockwise.
        assert!(up.0.x > 0.0 && up.0.y > 0.3 * up.0.x && up.1 < 0.0, "{name}: {up:?}");
        let mirrored = Vector3::new(down.0.x, -down.0.y, 0.0);
        assert!((up.0 - mirrored).norm() < 1e-7 * up.0.norm(), "{name}: {up:?} {down:?}");
        assert!((up.1 + down.1).abs() < 1e-7 * up.1.abs(), "{name}: {up:?} {down:?}");
    }
}

/// Added inertia of an ellipse that turns (added mass of one that moves along its own axes)
/// suddenly in a fluid at rest, over the potential flow's: `pi rho (a^2 - b^2)^2/8`, `pi rho b^2`
/// along a, `pi rho a^2` along b.
fn added(petsc: &Petsc, angle: f64, density: f64, cells: usize) -> [f64; 3] {
    let ellipse = ellipse(1.0, 0.5);
    let (along, across) =
        (Vector3::new(angle.cos(), angle.sin(), 0.0), Vector3::new(-angle.sin(), angle.cos(), 0.0));
    let start = body(ellipse, density, [10.03, 10.01], angle);
    let (mass, inertia) = (start.mass(), start.inertia().about(2));
    let more = "[pressure]\ndivergence_limit = 1.0e-10";
    let text = box_case([20.0, 20.0], [20 * cells, 20 * cells], 1e-9, ["\"slip\""; 4], more);
    [
        (Vector3::z(), inertia, PI * 0.75f64.powi(2) / 8.0),
        (along, mass, PI * 0.25),
        (across, mass, PI),
    ]
    .map(|(direction, own, theory)| {
        let mut still = start.clone();
        still.motion = PLANE;
        let mut scene = scene(petsc, &text, vec![still.clone()]);
        let turns = direction.z != 0.0;
        if turns {
            still.spin = direction;
        } else {
            still.velocity = direction;
        }
        scene.state.bodies[0] = still;
        scene.resume().unwrap();
        scene.step(1e-6).unwrap();
        let kept = if turns {
            first(&scene).spin.dot(&direction)
        } else {
            first(&scene).velocity.dot(&direction)
        };
        own * (1.0 / kept - 1.0) / theory
    })
}

#[test]
fn free_ellipse_has_added_inertia_of_potential_flow() {
    let petsc = petsc();
    for angle in [0.0, 0.3, 0.785] {
        for density in [0.01, 1.0, 100.0] {
            let [turning, along, across] = added(&petsc, angle, density, 8);
            println!(
                "angle {angle}, density {density}: turning {turning:.4}, along {along:.4}, across \
                {across:.4}"
            );
            assert!((turning - 1.0).abs() < 0.05, "{turning}");
            assert!((along - 1.0).abs() < 0.05 && (across - 1.0).abs() < 0.05, "{along} {across}");
        }
    }
    let fine = added(&petsc, 0.3, 1.0, 16);
    println!("16 cells a half axis: {fine:.4?}");
}

/// Two ellipses and a disc in a periodic box, one of them held.
fn trio(session: &Session, more: &str) -> Scene<2> {
    let more = format!(
        "[initial]\nvelocity = [0.3, 0.2]\nperturbation = 0.3\n[pressure]\n\
        divergence_limit = 1.0e-9\n{more}"
    );
    let text = box_case([1.0, 1.0], [48, 48], 0.002, PERIODIC, &more)
        .replace("viscosity", "gravity = [0.3, -1.0]\nviscosity");
    let mut bodies = vec![
        body(ellipse(0.15, 0.08), 2.65, [0.05, 0.5], 0.4),
        body(ellipse(0.13, 0.06), 0.3, [0.45, 0.3], -1.1),
        body(Disc { radius: 0.09 }, 1.0, [0.75, 0.8], 0.0),
    ];
    bodies[0].motion = PLANE;
    (bodies[0].velocity, bodies[0].spin) = (Vector3::new(0.5, 0.2, 0.0), Vector3::z() * 5.0);
    bodies[1].motion = PLANE;
    scene_of(session, &text, bodies)
}

#[test]
fn step_with_ellipses_allocates_nothing() {
    let petsc = petsc();
    for more in ["", "[coupling]\nwall = \"mixing\""] {
        let mut scene = trio(&petsc.session, more);
        scene.step(2e-3).unwrap();
        let before = count();
        for _ in 0..5 {
            scene.step(2e-3).unwrap();
        }
        assert_eq!(count() - before, 0, "{more}");
    }
}

#[test]
fn ellipse_motion_agrees_on_any_number_of_ranks() {
    let kinds = [(1, ""), (2, ""), (4, "")];
    let said =
        in_processes("ellipse::ellipse_motion_agrees_on_any_number_of_ranks", &kinds, |session| {
            let mut scene = trio(session, "");
            for _ in 0..10 {
                scene.step(2e-3).unwrap();
            }
            if session.rank() == 0 {
                let bodies = scene.state.bodies;
                println!(
                    "state {:?}",
                    bodies
                        .iter()
                        .flat_map(|b| [b.centre.x, b.velocity.y, b.spin.z])
                        .collect::<Vec<_>>()
                );
            }
        });
    let states: Vec<Vec<f64>> = said
        .iter()
        .map(|said| {
            let line = said.lines().find_map(|line| line.split("state [").nth(1)).unwrap();
            line.trim_end_matches(']').split(", ").map(|x| x.parse().unwrap()).collect()
        })
        .collect();
    for state in &states {
        for (a, b) in state.iter().zip(&states[0]) {
            assert!((a - b).abs() < 1e-7, "{states:?}");
        }
    }
}

#[test]
fn unsupported_options_for_ellipses_are_refused() {
    let petsc = petsc();
    let flat = |more: &str| case(&box_case([1.0, 1.0], [32, 32], 0.01, PERIODIC, more));
    let flat_body = || vec![body(ellipse(0.2, 0.1), 1.0, [0.5, 0.5], 0.0)];
    for (case, bodies, why) in [
        (flat(""), vec![body(ellipse(0.2, 0.1), 1.0, [1.5, 0.5], 0.0)], "outside the box"),
        (
            flat(""),
            vec![body(mics::geometry::Sphere { radius: 0.1 }, 1.0, [0.5, 0.5], 0.0)],
            "3 dimensions",
        ),
        (case(&box_case([1.0, 1.0], [6, 32], 0.01, PERIODIC, "")), flat_body(), "cells at least"),
    ] {
        let error =
            Scene::<2>::with_bodies(&petsc.session, &case, bodies).err().unwrap().to_string();
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn ellipses_pass_and_stop_at_contact() {
    let petsc = petsc();
    let text = box_case([1.0, 1.0], [64, 64], 0.01, PERIODIC, "");
    // Long sides face each other: their circles overlap, they do not.
    let pair = |apart: f64| {
        let mut bodies =
            [0.3, 0.3 + apart].map(|x| body(ellipse(0.2, 0.06), 1.0, [x, 0.5], FRAC_PI_2));
        bodies[0].motion = Motion::Prescribed(None);
        bodies[0].velocity = Vector3::new(0.2, 0.0, 0.0);
        bodies.to_vec()
    };
    let mut scene = scene(&petsc, &text, pair(0.17));
    for _ in 0..48 {
        scene.step(0.004).unwrap();
    }
    let met = (0..20)
        .find_map(|_| scene.step(0.004).err())
        .expect("the gap is 0.012 m, and the way 0.016 m");
    assert!(met.to_string().contains("particle 0 has run into particle 1"), "{met}");
}
