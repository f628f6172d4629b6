//! Paths of bodies across periods and in given motions, and how they turn.

use super::*;
use crate::geometry::{Disc, Nearest, Shape, SurfacePoint};
use mics_shapes::{Lattice, Part, Tile};

#[test]
fn path_unwraps_across_periodic_boundaries() {
    let freedom = Freedom { translation: [true; 3], rotation: [true; 3] };
    let mut body = Body::new(Arc::new(Disc { radius: 0.1 }), 1.0, 0.0, Vector3::new(0.4, 0.5, 0.0));
    body.motion = Motion::Free(freedom);
    body.velocity = Vector3::new(-0.7, 0.2, 0.0);
    for steps in 1..40 {
        if steps == 20 {
            body.velocity = -body.velocity;
        }
        body.advance(0.25, &Accelerations::default(), &[Some(1.0), None, None]);
        let gone = 0.25 * f64::from(if steps < 20 { steps } else { 38 - steps });
        let place = Vector3::new(0.4 - 0.7 * gone, 0.5 + 0.2 * gone, 0.0);
        assert!((body.path() - place).norm() < 1e-12, "{steps}: {:?} of {place:?}", body.path());
        assert!(
            (0.0..=1.0).contains(&body.centre.x)
                && (body.crossed.x - body.crossed.x.round()).abs() == 0.0
        );
    }
}

#[test]
fn oscillating_body_position_and_spin() {
    let origin = Vector3::new(0.4, 0.5, 0.0);
    let drift = Vector3::new(0.3, 0.0, 0.0);
    let amplitude = Vector3::new(-0.1, 0.02, 0.0);
    let path = Oscillation { origin, drift, amplitude, frequency: 2.0, time: 0.0 };
    let mut body = Body {
        velocity: path.velocity(),
        spin: Vector3::new(0.0, 0.0, 3.0),
        motion: Motion::Prescribed(Some(path)),
        ..Body::new(Arc::new(Disc { radius: 0.1 }), 1.0, 0.0, origin)
    };
    assert_eq!(body.velocity, drift + TAU * 2.0 * amplitude);
    let mut time = 0.0;
    let mut fastest = 0.0f64;
    for k in 0..1000 {
        let dt = 1e-3 * (1.0 + 0.5 * f64::from(k).sin());
        let before = body.velocity;
        body.advance(dt, &Accelerations::default(), &[Some(1.0), None, None]);
        time += dt;
        let phase = TAU * 2.0 * time;
        let place = origin + drift * time + amplitude * phase.sin();
        assert!(
            (body.centre.x - place.x.rem_euclid(1.0)).abs() < 1e-13
                && (body.centre.y - place.y).abs() < 1e-13
        );
        assert!((body.path() - place).norm() < 1e-13, "{:?} of {place:?}", body.path());
        assert!((body.velocity - drift - TAU * 2.0 * amplitude * phase.cos()).norm() < 1e-12);
        let Motion::Prescribed(Some(path)) = body.motion else { panic!() };
        // Backwards over half a step, up to the path's third derivative: |A| (2 pi f)^3 = 200
        // m/s3.
        assert!((path.acceleration() - (body.velocity - before) / dt).norm() < 0.51 * dt * 205.0);
        fastest = fastest.max(body.velocity.norm());
    }
    assert!((body.angle - 3.0 * time).abs() < 1e-12 && body.spin.z == 3.0);
    let bound = body.speed();
    assert!(fastest <= bound && fastest > 0.99 * bound, "{fastest} {bound}");
    assert_eq!(body.top_speed(), bound + 0.3);
}

/// A body of which only the inertia counts: its moments for a kilogram (m2).
#[derive(Debug)]
struct Inert([f64; 3]);

impl Shape for Inert {
    fn dimension(&self) -> usize {
        3
    }
    fn radius(&self) -> f64 {
        1.0
    }
    fn volume(&self) -> f64 {
        1.0
    }
    fn inertia(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::from(self.0))
    }
    fn thickness(&self) -> f64 {
        2.0
    }
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        Nearest { distance: point.norm() - 1.0, normal: point.normalize() }
    }
    fn surface(&self, _: f64) -> Vec<SurfacePoint> {
        Vec::new()
    }
    fn extent(&self, _: &Vector3<f64>) -> f64 {
        1.0
    }
    fn tile(&self, _: &Lattice, _: &mut dyn FnMut(&Tile)) {}
    fn parts(&self) -> &[Part] {
        &[]
    }
    fn triangles(&self, _: f64) -> Vec<[Vector3<f64>; 3]> {
        Vec::new()
    }
}

/// A racket that spins about its middle axis, very nearly, turns over again and again
/// (Dzhanibekov), and keeps energy and angular momentum.
#[test]
fn free_asymmetric_body_turns_over_and_keeps_energy() {
    for dt in [1e-3, 0.02, 0.3] {
        let mut body = Body::new(Arc::new(Inert([0.3, 0.2, 0.1])), 2.0, 0.0, Vector3::zeros());
        body.motion = Motion::Free(Freedom { translation: [true; 3], rotation: [true; 3] });
        body.spin = Vector3::new(1e-4, 1.0, 1e-4);
        let momentum = body.inertia().of(&body.spin);
        let energy = |body: &Body| 0.5 * body.spin.dot(&body.inertia().of(&body.spin));
        let start = energy(&body);
        let mut over = 0;
        let turns = 60.0;
        let mut last = 1.0;
        let mut rounded = 1e-15;
        for _ in 0..(turns * std::f64::consts::TAU / dt) as usize {
            body.advance(dt, &Accelerations::default(), &[None; 3]);
            let along = (body.orientation() * Vector3::y()).y;
            over += usize::from(along * last < 0.0 && along.abs() > 0.0);
            last = along;
            let gone = (body.inertia().of(&body.spin) - momentum).norm() / momentum.norm();
            // By some roundings, always alike, in each step.
            rounded += 10.0 * f64::EPSILON;
            assert!(gone < rounded, "{gone:e}");
        }
        let changed = (energy(&body) / start - 1.0).abs() / turns;
        println!("dt {dt}: turned over {over} times, energy changed by {changed:.1e} a turn");
        assert!(over >= 4 && changed < 1e-8, "{over} {changed:e}");
    }
}

/// A torque-free symmetric top precesses as in closed form: its axis about the angular momentum
/// at `|L|/I_1`.
#[test]
fn free_symmetric_body_precesses_at_its_rate() {
    let mut body = Body::new(Arc::new(Inert([0.2, 0.2, 0.3])), 1.0, 0.0, Vector3::zeros());
    body.motion = Motion::Free(Freedom { translation: [true; 3], rotation: [true; 3] });
    body.spin = Vector3::new(0.4, 0.0, 1.0);
    let momentum = body.inertia().of(&body.spin);
    let period = std::f64::consts::TAU * 0.2 / momentum.norm();
    let axis = body.orientation() * Vector3::z();
    for _ in 0..100 {
        body.advance(0.01 * period, &Accelerations::default(), &[None; 3]);
    }
    let end = body.orientation() * Vector3::z();
    assert!((end - axis).norm() < 1e-8, "{:e}", (end - axis).norm());
}
