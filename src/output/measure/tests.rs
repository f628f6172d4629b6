//! Tests of the measures that cases have.

use super::kinds::frequency;
use super::*;
use crate::config::{When, Which, written};
use crate::contact::Impulse;
use crate::particles::{Motion, Oscillation};
use nalgebra::Vector3;
use std::f64::consts::PI;

#[test]
fn strouhal_frequency_of_noisy_sine() {
    let signal = |t: f64| 0.3 + (2.0 * PI * 1.7 * t).sin() + 0.03 * (2.0 * PI * 61.0 * t).sin();
    let samples: Vec<_> = (0..5000).map(|k| k as f64 * 2e-3).map(|t| (t, signal(t))).collect();
    assert!((frequency(&samples, 0.3).unwrap() - 1.7).abs() < 0.01);
    assert_eq!(frequency(&samples[..100], 0.3), None);
}

fn disc() -> Body {
    let shape = std::sync::Arc::new(crate::geometry::Disc { radius: 0.1 });
    let mut body = Body::new(shape, 2.0, 0.1, Vector3::new(0.5, 8.0, 0.0));
    body.spin.z = 0.5;
    body
}

const TOUCHED: BodyOutcome = BodyOutcome {
    impulse: Impulse { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) },
    touched: true,
    damping: 0.0,
};

fn at<'a>(time: f64, exchange: &'a [Exchange], bodies: &'a [Body]) -> Sample<'a> {
    let touches = exchange.first().is_some_and(|e| e.contact != Vector3::zeros());
    let contacts: &[BodyOutcome] = if touches { &[TOUCHED] } else { &[] };
    Sample { time, exchange, bodies, max_speed: 0.0, deepest: 1e-3 * time, contacts }
}

fn pushed(momentum: Vector3<f64>) -> Exchange {
    Exchange { momentum, ..Exchange::default() }
}

/// The measures of these kinds, from 1 s on, of a disc of 0.2 m in a fluid of 2 kg/m3.
fn of_kinds(kinds: &[&str]) -> Vec<Series> {
    with_keys(kinds, "speed = 3.0")
}

/// The measures of these kinds with these further keys, of the same disc and fluid.
fn with_keys(kinds: &[&str], keys: &str) -> Vec<Series> {
    let measure = |kind: &&str| {
        format!("[[measure]]\nname = \"{kind}\"\nkind = \"{kind}\"\nfrom = 1.0\n{keys}\n")
    };
    let text = format!(
        "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 9.0], cells = [16, 144] }}\n\
         fluid = {{ density = 2.0, viscosity = 0.1, gravity = [0.0, -9.81] }}\n\
         boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" \
             }}\n\
         particle = [{{ shape = {{ disc = {{ diameter = 0.2 }} }}, position = [0.5, 8.0], \
         motion = {{ prescribed = {{\
         oscillation = {{ amplitude = [0.1, 0.0], frequency = 0.5 }} }} }} }}]\n{}",
        kinds.iter().map(measure).collect::<String>()
    );
    series(&written(&text).unwrap())
}

#[test]
fn morison_fit_recovers_coefficients() {
    let mut series = of_kinds(&["morison_drag", "morison_inertia"]);
    let origin = Vector3::zeros();
    let drift = Vector3::zeros();
    let amplitude = Vector3::new(-0.3, 0.4, 0.0);
    let path = |time| Oscillation { origin, drift, amplitude, frequency: 0.5, time };
    let along = amplitude.normalize();
    let mut time = 0.0;
    for k in 0..400 {
        let dt = 0.01 * (1.0 + 0.3 * f64::from(k).sin());
        time += dt;
        let middle = path(time - 0.5 * dt);
        let u = middle.velocity().dot(&along);
        let a = middle.acceleration().dot(&along);
        // Across the motion, and before the window, anything goes.
        let across = Vector3::new(0.8, 0.6, 0.0) * f64::from(k).cos();
        let force = -2.1 * 0.5 * 2.0 * 0.2 * u.abs() * u - 1.4 * 2.0 * 0.01 * PI * a;
        let momentum = if time < 1.0 { Vector3::repeat(9.0) } else { force * along + across };
        let mut body = disc();
        body.motion = Motion::Prescribed(Some(path(time)));
        let exchange = pushed(momentum);
        series
            .iter_mut()
            .for_each(|s| s.sample(&at(time, &[exchange], std::slice::from_ref(&body)), 0.0));
    }
    let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
    assert!((values[0] - 2.1).abs() < 1e-12 && (values[1] - 1.4).abs() < 1e-12, "{values:?}");
}

/// A force of 4 N over 0.9 to 1.2 s and of 1 N over the next 0.5 s, of which the first 0.1 s
/// are before the window; a velocity by what it is at the ends.
#[test]
fn mean_force_is_time_weighted() {
    let mut series = of_kinds(&["force", "velocity_x"]);
    let mut bodies = [disc()];
    for (time, force, speed) in [(0.9, 9.0, 7.0), (1.2, 4.0, 1.0), (1.7, 1.0, 3.0)] {
        bodies[0].velocity.x = speed;
        series.iter_mut().for_each(|s| {
            s.sample(&at(time, &[pushed(Vector3::new(force, 0.0, 0.0))], &bodies), 0.0)
        });
    }
    let [force, speed] = [0, 1].map(|n: usize| series[n].value().unwrap());
    assert!(
        (force - (4.0 * 0.2 + 0.5) / 0.7).abs() < 1e-14 && (speed - 2.0).abs() < 1e-14,
        "{force} {speed}"
    );
}

#[test]
fn maximum_coefficients_within_time_window() {
    let mut series =
        of_kinds(&["drag_coefficient_max", "lift_coefficient_max", "drag_coefficient"]);
    for (time, x, y) in [(0.5, 9.0, 9.0), (1.0, 1.8, -0.9), (2.0, 3.6, 0.18), (3.0, 1.8, -2.0)] {
        let exchange = pushed(Vector3::new(x, y, 0.0));
        series.iter_mut().for_each(|s| s.sample(&at(time, &[exchange], &[disc()]), 0.0));
    }
    // In units of 0.5 rho U^2 d = 1.8 N.
    let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
    assert!(values.iter().zip([2.0, 0.1, 1.5]).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
    let kept: Vec<usize> = series.iter().map(|s| s.samples.len()).collect();
    assert_eq!(kept, [1, 1, 3], "a mean needs all samples, the largest itself");
}

#[test]
fn position_measure_at_passing_and_first_contact() {
    let when = |series: &mut Series, when| series.measure.when = Some(when);
    let mut series = of_kinds(&["position_x", "velocity_x", "position_y"]);
    when(&mut series[0], When::Y(7.5));
    when(&mut series[1], When::Y(2.0));
    when(&mut series[2], When::Contact);
    let mut body = disc();
    for k in 0..9 {
        // A straight way down from (0, 8), which turns back at the fifth step.
        body.centre = Vector3::new(0.2 * f64::from(k), 8.0 - 0.4 * f64::from(k.min(8 - k)), 0.0);
        let mut exchange = Exchange::default();
        exchange.contact.y = if k == 5 { 1.0 } else { 0.0 };
        let time = 1.0 + f64::from(k);
        series
            .iter_mut()
            .for_each(|s| s.sample(&at(time, &[exchange], std::slice::from_ref(&body)), 0.0));
    }
    let values: Vec<_> = series.iter().map(Series::value).collect();
    assert!(
        (values[0].unwrap() - 0.25).abs() < 1e-12,
        "on the way down, between two steps: {values:?}"
    );
    assert_eq!(values[1], None, "never so low");
    assert!((values[2].unwrap() - 6.8).abs() < 1e-12, "{values:?}");
    assert!(series.iter().all(|s| s.samples.is_empty()), "a moment needs no history");
}

#[test]
fn measures_of_height_fastest_particle_and_overlap() {
    let mut series =
        of_kinds(&["mean_height", "height_rank", "fastest_particle", "largest_overlap"]);
    let up = Vector3::new(0.6, 0.8, 0.0);
    for s in &mut series {
        s.up = up;
        s.measure.particles = Some(vec![Which::Id(0), Which::Id(2)]);
    }
    // Heights 5, 1, 3 along `up`, whatever lies across.
    let body = |height: f64, across: f64, speed: f64| {
        let mut body = disc();
        body.centre = height * up + across * Vector3::new(-0.8, 0.6, 0.0);
        body.velocity = Vector3::new(0.0, speed, 0.0);
        body
    };
    let mut bodies = [body(5.0, 9.0, 0.1), body(1.0, -3.0, 7.0), body(3.0, 20.0, -0.2)];
    bodies.iter_mut().enumerate().for_each(|(id, body)| body.id = id);
    series.iter_mut().for_each(|s| s.sample(&at(2.0, &[], &bodies), 0.0));
    let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
    let expected = [3.0, 2.5, 0.2, 2e-3];
    assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
}

#[test]
fn measures_of_falling_and_landing_body() {
    let mut series =
        of_kinds(&["largest_speed", "position_y", "velocity_y", "spin", "contact_start"]);
    assert!(series.iter().all(|s| s.value().is_none()));
    let mut body = disc();
    // Before the window, in it, at the bottom, and at rest without a force.
    for (time, speed, force) in
        [(0.5, -9.0, 9.0), (1.0, -2.0, 0.0), (2.0, -3.0, 0.0), (3.0, 0.0, 7.0), (4.0, 0.0, 0.0)]
    {
        body.velocity.y = speed;
        body.centre.y += speed / 10.0;
        let mut exchange = Exchange::default();
        exchange.contact.y = force;
        series
            .iter_mut()
            .for_each(|s| s.sample(&at(time, &[exchange], std::slice::from_ref(&body)), 0.0));
    }
    let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
    let expected = [3.0, 8.0 - 1.4, -(2.5 + 1.5) / 3.0, 0.5, 3.0];
    assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
}

/// An ellipse of 2:1 in shear turns by Jeffery's law, which begins at any angle.
#[test]
fn measures_of_turning_body() {
    let r = 2.0f64;
    let rate = 3.0;
    let mut series = of_kinds(&["turn_period", "largest_spin", "least_spin", "angle"]);
    let mut body = disc();
    body.angle = 0.4;
    let mut half_turn = None;
    for k in 0..20000 {
        let time = 1.0 + 1e-3 * f64::from(k);
        let dt = 1e-3;
        let spin = |a: f64| -rate * (r * r * a.sin().powi(2) + a.cos().powi(2)) / (r * r + 1.0);
        body.spin.z = spin(body.angle);
        let sample = at(time, &[], std::slice::from_ref(&body));
        series.iter_mut().for_each(|s| s.sample(&sample, 0.0));
        half_turn = half_turn.or(series[0].value());
        body.angle += dt * spin(body.angle + 0.5 * dt * body.spin.z);
    }
    let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
    let period = 2.0 * PI * (r + 1.0 / r) / rate;
    assert!((half_turn.unwrap() - period).abs() < 3e-3, "the first: {half_turn:?} {period}");
    let expected = [period, 0.8 * rate, 0.2 * rate, body.angle];
    assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 3e-3), "{values:?}");
}

#[test]
fn reference_length_of_coefficient_and_strouhal_number() {
    let mut series = with_keys(&["drag_coefficient", "strouhal"], "speed = 3.0\nlength = 0.4");
    for k in 0..400 {
        let time = 1.0 + 0.01 * f64::from(k);
        let exchange = pushed(Vector3::new(3.6, (2.0 * PI * 2.5 * time).sin(), 0.0));
        series.iter_mut().for_each(|s| s.sample(&at(time, &[exchange], &[disc()]), 0.0));
    }
    let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
    assert!((values[0] - 1.0).abs() < 1e-12, "3.6 N over 0.5 rho U^2 0.4 m: {values:?}");
    assert!((values[1] - 2.5 * 0.4 / 3.0).abs() < 1e-3, "{values:?}");
}
