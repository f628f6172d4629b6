//! Effects of the fluid and of contacts on a body's spin, in the steps that a run chooses.

use crate::support::{columns, run};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// A table's columns.
type Columns = HashMap<String, Vec<f64>>;

/// Runs a case of our own with the steps that a run chooses, and returns the tables of its bodies
/// and steps.
fn run_of(text: &str) -> (Columns, Columns) {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    std::fs::write(&case, text).unwrap();
    let out = dir.path().join("run");
    run(&case, &out, &["--set", "output.particles.every=1", "--set", "output.figures=false"]);
    (columns(&out.join("particles.csv")), columns(&out.join("steps.csv")))
}

/// A box of water of twenty times the viscosity, 24 by 32 mm, its ends walls; what lies in it in
/// `bodies`.
fn tank(gravity: f64, bodies: &str, end: f64) -> String {
    format!(
        "name = \"tank\"\ndomain = {{ size = [0.024, 0.032], cells = [48, 64] }}\n\
         fluid = {{ density = 1000.0, viscosity = 0.02, gravity = [0.0, {gravity:?}] }}\n\
         boundary = {{ west = \"periodic\", east = \"periodic\", south = \"wall\", north = \
             \"wall\" }}\n\
         contact = {{ friction = 0.4 }}\ntime = {{ end = {end:?} }}\n\
         pressure = {{ divergence_limit = 1e-3 }}\n{bodies}"
    )
}

/// The spin (rad/s) at `times` (s) of a disc of the radius `a` (m) and `s` times the density of a
/// fluid at rest without end, of viscosity `nu` (m2/s), that is let go with a spin of 1: `dv/dt =
/// nu d/dr( (1/r) d(r v)/dr )` outside, and its own moment of inertia on the rim. Implicit in time,
/// on circles that grow apart as they are further out.
fn spin_in_still_fluid(s: f64, a: f64, nu: f64, times: &[f64]) -> Vec<f64> {
    let n = 400;
    let r: Vec<f64> =
        (0..=n).map(|i| a + 12.0 * a * (f64::from(i) / f64::from(n)).powi(2)).collect();
    let middle: Vec<f64> = r.windows(2).map(|ends| 0.5 * (ends[0] + ends[1])).collect();
    // Per density: the torque between two circles over their difference of spin, and the moments of
    // inertia of rings.
    let torque: Vec<f64> =
        (0..n as usize).map(|i| TAU * nu * middle[i].powi(3) / (r[i + 1] - r[i])).collect();
    let edges = |i: usize| {
        [if i == 0 { a } else { middle[i - 1] }, if i == n as usize { r[i] } else { middle[i] }]
    };
    let mut inertia: Vec<f64> =
        (0..=n as usize).map(|i| 0.5 * PI * (edges(i)[1].powi(4) - edges(i)[0].powi(4))).collect();
    inertia[0] += 0.5 * PI * s * a.powi(4);
    let mut spin = vec![0.0; n as usize + 1];
    spin[0] = 1.0;
    let (mut t, mut found) = (0.0, Vec::new());
    for &end in times {
        while t < end {
            let dt = f64::min(f64::max(1e-6, 0.005 * t), end - t);
            let between = |i: usize| torque.get(i).copied().unwrap_or(0.0) * dt;
            let (mut diagonal, mut right): (Vec<f64>, Vec<f64>) = (0..spin.len())
                .map(|i| {
                    (
                        inertia[i] + between(i) + if i > 0 { between(i - 1) } else { 0.0 },
                        inertia[i] * spin[i],
                    )
                })
                .unzip();
            for i in 1..spin.len() {
                let part = between(i - 1) / diagonal[i - 1];
                diagonal[i] -= part * between(i - 1);
                right[i] += part * right[i - 1];
            }
            let last = spin.len() - 1;
            spin[last] = right[last] / diagonal[last];
            for i in (0..last).rev() {
                spin[i] = (right[i] + between(i) * spin[i + 1]) / diagonal[i];
            }
            t += dt;
        }
        found.push(spin[0]);
    }
    found
}

/// In the steps of a run by default, a third of `h^2/nu`: what turns light discs is nearly all in
/// the fluid.
#[test]
fn spin_decay_of_free_disc_matches_theory_for_all_densities() {
    for density in [5000.0, 2500.0, 1000.0, 100.0] {
        let body = format!(
            "[[particle]]\nshape.disc.diameter = 0.004\ndensity = {density:?}\n\
            position = [0.012, 0.016]\nspin = 1.0\n"
        );
        let (bodies, _) = run_of(&tank(0.0, &body, 0.15));
        let (times, spins) = (&bodies["time"], &bodies["wz"]);
        let exact = spin_in_still_fluid(1e-3 * density, 0.002, 2e-5, times);
        let worst = times.iter().zip(spins).zip(&exact).filter(|((t, _), _)| **t > 0.01);
        let worst = worst.fold(0.0, |most: f64, ((_, spin), exact)| most.max((spin - exact).abs()));
        println!(
            "{density} kg/m3: within {worst:.4} of the spin at the start from 10 ms on, {} steps",
            times.len() - 1
        );
        assert!(worst < 0.025, "{density} kg/m3: {spins:?} and not {exact:?}");
    }
}

/// A disc or sphere on a slope rolls, whatever the step, where friction could hold much more.
#[test]
fn rolling_without_slip_down_a_slope_in_liquid() {
    let slope = "name = \"slope\"\ndomain = { size = [0.04, 0.012], cells = [80, 24] }\n\
        fluid = { density = 1000.0, viscosity = 0.05, gravity = [1.7035, -9.661] }\n\
        boundary = { west = \"periodic\", east = \"periodic\", south = \"wall\", north = \"slip\" \
            }\n\
        contact = { friction = 0.5 }\npressure = { divergence_limit = 1e-3 }\n\
        particle = \
        [{ shape.disc.diameter = 0.004, position = [0.005, 0.002], density = DENSITY }]\n";
    for density in ["1100.0", "2650.0"] {
        for time in ["end = 0.4", "end = 0.4\nstep = 4e-4"] {
            let (bodies, _) =
                run_of(&format!("{}[time]\n{time}\n", slope.replace("DENSITY", density)));
            let last = |name: &str| *bodies[name].last().unwrap();
            let (way, rim) = (last("vx"), -0.002 * last("wz"));
            println!("{density} kg/m3, {time:?}: {way:.5} m/s, its rim {rim:.5} m/s");
            assert!(
                (rim / way - 1.0).abs() < 0.01,
                "{density} kg/m3, {time:?}: {way} m/s, its rim {rim} m/s"
            );
        }
    }
}

/// Next to all that turns with a light body is fluid. The changes of its spin by contacts and
/// films, and those by the fluid, must not respond to each other's errors from step to step.
#[test]
fn light_discs_at_lid_come_to_rest_without_spin() {
    let one = "[[particle]]\nshape.disc.diameter = 0.004\ndensity = 5.0\n\
        position = [0.012, 0.022]\nspin = 0.01\n";
    let many = "[[swarm]]\ncount = 14\ndiameter = { uniform = [0.003, 0.004] }\ndensity = 100.0\n\
                region = { min = [0.0, 0.010], max = [0.024, 0.024] }\n";
    let closed = tank(-9.81, many, 1.0)
        .replace("periodic", "wall")
        .replace("[0.024, 0.032]", "[0.024, 0.024]");
    let closed = closed.replace("cells = [48, 64]", "cells = [64, 64]");
    // The pile still settles when it ends; before, its discs turned with 34 rad/s, all of gravity's
    // work over again.
    for (name, text, allowed) in [("one", tank(-9.81, one, 0.7), 0.01), ("many", closed, 1.5)] {
        let (discs, steps) = run_of(&text);
        let end = discs["time"].last().unwrap() - 0.1;
        let late = discs["time"].iter().zip(&discs["wz"]).filter(|(t, _)| **t > end);
        let fastest = late.fold(0.0, |most: f64, (_, spin)| most.max(spin.abs()));
        let [given, lost] =
            ["gravity_work", "method_loss"].map(|name| *steps[name].last().unwrap());
        println!(
            "{name}: {fastest:.1e} rad/s at rest, the method takes {:.1} % of gravity's work",
            100.0 * lost / given
        );
        assert!(fastest < allowed, "{name}: turns at rest with {fastest} rad/s");
        assert!(lost > -0.05 * given, "{name}: {lost} J gained, of {given} J");
    }
}

/// The work that turns a disc in a fluid is the viscous loss, with the part on the disc's surface:
/// `2 mu w^2` of its volume, half of it all here.
#[test]
fn work_of_spinning_disc_equals_viscous_loss() {
    let disc = "particle = \
        [{ shape.disc.diameter = 0.004, position = [0.012, 0.016], motion.prescribed.spin = \
            1.0 }]\n";
    let text = tank(0.0, "", 0.3)
        .replace("viscosity = 0.02", "viscosity = 0.2")
        .replace("contact = { friction = 0.4 }\n", "");
    let (_, steps) = run_of(&format!("{text}{disc}"));
    let [given, viscous, method] =
        ["prescribed_work", "viscous_loss", "method_loss"].map(|name| *steps[name].last().unwrap());
    println!(
        "of {given:.3e} J viscosity takes {:.3}, the method {:.3}",
        viscous / given,
        method / given
    );
    assert!(
        (method / given).abs() < 0.06 && viscous > 0.9 * given,
        "{given} J: {viscous} J and {method} J"
    );
}

/// A body may be set down a little into a wall: what its spring holds is there from the start.
#[test]
fn disc_starting_with_overlap_in_floor_comes_to_rest() {
    for pressed in [1e-7, 2e-5] {
        let body = format!(
            "[[particle]]\nshape.disc.diameter = 0.004\ndensity = 2500.0\n\
            position = [0.012, {:?}]\n",
            0.002 - pressed
        );
        let (disc, steps) = run_of(&tank(-9.81, &body, 0.2));
        let last = |table: &Columns, name: &str| *table[name].last().unwrap();
        println!(
            "{pressed} m: {:.3e} J in its spring, {:.1e} m/s at the end",
            steps["spring_energy"][0],
            last(&disc, "vy")
        );
        assert!(steps["spring_energy"][0] > 0.0 && last(&disc, "vy").abs() < 1e-4, "{pressed} m");
        assert!(
            (last(&disc, "y") - 0.002).abs() < 4e-5,
            "{pressed} m: it lies at {} m",
            last(&disc, "y")
        );
    }
}
