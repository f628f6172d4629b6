//! Paths of bodies across periods and in given motions.

use super::*;
use crate::geometry::Disc;

#[test]
fn path_unwraps_across_periodic_boundaries() {
    let freedom = Freedom { translation: [true; 3], rotation: [true; 3] };
    let mut body = Body::new(Arc::new(Disc { radius: 0.1 }), 1.0, 0.0, Vector3::new(0.4, 0.5, 0.0));
    (body.motion, body.velocity) = (Motion::Free(freedom), Vector3::new(-0.7, 0.2, 0.0));
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
    let (origin, drift, amplitude) =
        (Vector3::new(0.4, 0.5, 0.0), Vector3::new(0.3, 0.0, 0.0), Vector3::new(-0.1, 0.02, 0.0));
    let path = Oscillation { origin, drift, amplitude, frequency: 2.0, time: 0.0 };
    let mut body = Body {
        velocity: path.velocity(),
        spin: Vector3::new(0.0, 0.0, 3.0),
        motion: Motion::Prescribed(Some(path)),
        ..Body::new(Arc::new(Disc { radius: 0.1 }), 1.0, 0.0, origin)
    };
    assert_eq!(body.velocity, drift + TAU * 2.0 * amplitude);
    let (mut time, mut fastest) = (0.0, 0.0f64);
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
