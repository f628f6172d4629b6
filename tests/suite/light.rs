//! Bodies much lighter than the fluid, whose mass in contact is the fluid's: they rest where they lie, and friction makes no energy.

use crate::support::{columns, run};
use std::collections::HashMap;

/// Runs a case of our own with the steps that a run chooses, and returns the table of its steps.
fn steps_of(text: &str) -> HashMap<String, Vec<f64>> {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    std::fs::write(&case, text).unwrap();
    let out = dir.path().join("run");
    run(&case, &out, &["--set", "output.figures=false"]);
    columns(&out.join("steps.csv"))
}

/// A box whose floor and lid are walls, 8 cells a disc of 1 cm, with this viscosity (Pa s) and this text for what lies in it.
fn tank(width: f64, viscosity: f64, end: f64, bodies: &str) -> String {
    format!(
        "name = \"tank\"\ndomain = {{ size = [{width:?}, 0.06], cells = [{}, 48] }}\n\
         fluid = {{ density = 1000.0, viscosity = {viscosity:?}, gravity = [0.0, -9.81] }}\n\
         boundary = {{ west = \"periodic\", east = \"periodic\", south = \"wall\", north = \"wall\" }}\n\
         contact = {{ friction = 0.5, restitution = 0.5 }}\ntime = {{ end = {end:?} }}\n{bodies}",
        (width * 800.0).round()
    )
}

/// Fourteen discs rise in rows and pack under the lid; held there by friction, whether they can turn or not. What friction gives was mended along
/// the lines of centres alone: the pile slid to and fro and made 0.6 of
/// gravity's work from nothing where no disc turned.
#[test]
fn discs_that_friction_holds_under_a_lid_rest() {
    for (density, locked) in [(5.0, true), (5.0, false), (50.0, false)] {
        let lock = if locked { "locked = [\"rotation\"]\n" } else { "" };
        let discs: String = (0..14)
            .map(|k| {
                // In rows of three, each a little aside from the row below.
                let (row, column) = (k / 3, k % 3);
                let (x, y) =
                    (0.0067 + 0.0133 * f64::from(column) + 0.0003 * f64::from(k % 5), 0.007 + 0.011 * f64::from(row));
                format!(
                    "[[particle]]\nshape.disc.diameter = 0.01\ndensity = {density:?}\nposition = [{x:?}, {y:?}]\n{lock}"
                )
            })
            .collect();
        let steps = steps_of(&tank(0.04, 0.1, 1.5, &discs));
        let [given, lost, energy] =
            ["gravity_work", "method_loss", "kinetic_energy"].map(|name| *steps[name].last().unwrap());
        let most = steps["kinetic_energy"].iter().copied().fold(0.0, f64::max);
        println!(
            "s = {}, locked {locked}: method {:.3} of gravity's work, {:.1e} of the energy left after {} steps",
            density / 1000.0,
            lost / given,
            energy / most,
            steps["time"].len()
        );
        assert!(lost > -0.02 * given, "s = {}: {lost} J from nothing, of {given} J", density / 1000.0);
        assert!(energy < 0.05 * most, "s = {}: {energy} J left of {most} J", density / 1000.0);
    }
}

/// A disc of a hundredth of the fluid's density lies under the lid from the start, at rest or with a spin, and stays there: contacts hold its
/// weight from the second step on. It was taken for an impact, and half of its weight pushed it into the fluid again.
#[test]
fn a_light_disc_that_lies_under_a_lid_from_the_start_stays() {
    for spin in [0.0, 5.0] {
        let disc = format!(
            "[[particle]]\nshape.disc.diameter = 0.01\ndensity = 10.0\nposition = [0.04, 0.055]\nspin = {spin:?}\n"
        );
        let steps = steps_of(&tank(0.08, 0.01, 0.2, &disc));
        // What it had by its fall over a thousandth of its diameter.
        let fall = 990.0 * 9.81 * 0.25 * std::f64::consts::PI * 0.01f64.powi(2) * 1e-5;
        let (start, most) = (steps["kinetic_energy"][0], steps["kinetic_energy"].iter().copied().fold(0.0, f64::max));
        println!("spin {spin}: at most {:.2e} J, {start:.2e} J at the start, fall {fall:.2e} J", most);
        assert!(most < start + 0.05 * fall, "spin {spin}: {most} J of {start} J at the start");
    }
}
