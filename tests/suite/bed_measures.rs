//! Shear stress on a bed, Shields number, load rate and Einstein's number, beside numbers by hand
//! from the files of a run.

use crate::box_measures::measures;
use crate::support::{box_case, columns, mics, run};
use std::f64::consts::PI;

/// Couette flow under a lid of 0.1 m/s, 0.1 m over the bed: the stress is 10 Pa s U/H by the
/// balance of momentum, from the shear above, and in a region, from that below.
#[test]
fn bed_shear_stress_of_couette_flow_is_exact() {
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "{ moving_wall = [0.1, 0.0] }"];
    let whole = "kind = \"bed_shear_stress\"\nfrom = 1.9\n";
    let more = format!(
        "[[measure]]\nname = \"balance\"\n{whole}[[measure]]\nname = \"region\"\n{whole}\
        region = {{ min = [0.02, 0.0], max = [0.06, 0.1] }}\n[output]\nfigures = false\n\
        [time]\nend = 2.0\nstep = 0.01\n"
    );
    let text = box_case([0.1, 0.1], [20, 20], 10.0, sides, &more)
        .replace("viscosity", "gravity = [0.0, -9.81]\nviscosity")
        .replace("density = 1.0", "density = 1000.0");
    let found = measures(&text);
    println!("{found}");
    for name in ["balance", "region"] {
        let stress = found[name].as_f64().unwrap();
        assert!((stress / 10.0 - 1.0).abs() < 1e-6, "{name}: {stress} Pa");
    }
}

/// A flow over a floor that speeds up with the mean velocity of a flood, under a slip side: the
/// balance of momentum counts no acceleration as stress.
#[test]
fn bed_shear_stress_under_a_rising_mean_velocity_is_the_shear_on_the_floor() {
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
    let kind = "kind = \"bed_shear_stress\"\nfrom = 0.5\n";
    let more = format!(
        "[drive]\nmean_velocity = {{ axis = \"x\", value = 0.1, \
        over_time = {{ time = [0.0, 1.0], factor = [0.0, 1.0] }} }}\n\
        [[measure]]\nname = \"balance\"\n{kind}[[measure]]\nname = \"region\"\n{kind}\
        region = {{ min = [0.02, 0.0], max = [0.06, 0.1] }}\n[output]\nfigures = false\n\
        [time]\nend = 0.9\nstep = 0.005\n"
    );
    let text = box_case([0.1, 0.1], [20, 20], 1.0, sides, &more)
        .replace("viscosity", "gravity = [0.0, -9.81]\nviscosity")
        .replace("density = 1.0", "density = 1000.0");
    let found = measures(&text);
    let [balance, region] = ["balance", "region"].map(|name| found[name].as_f64().unwrap());
    // The acceleration alone is rho H dU/dt = 10 Pa.
    println!("{balance} and {region} Pa");
    assert!((balance / region - 1.0).abs() < 1e-2 && balance < 5.0, "{balance} and {region} Pa");
}

/// The mean over time of samples at the ends of steps, by trapezia.
fn trapezia(samples: &[f64]) -> f64 {
    let last = samples.len() - 1;
    let ends = 0.5 * (samples[0] + samples[last]);
    (ends + samples[1..last].iter().sum::<f64>()) / last as f64
}

/// Grains on a ground of discs in a channel that a force drives, with a side above that slips.
#[test]
fn bed_measures_equal_numbers_by_hand_of_particles_and_balance() {
    const LENGTH: f64 = 0.1;
    const DEPTH: f64 = 0.06;
    const DRIVE: f64 = 100.0;
    const DIAMETER: f64 = 0.01;
    let disc = |name: &str, x: f64, y: f64, more: &str| {
        format!(
            "[[particle]]\nname = \"{name}\"\nshape = {{ disc = {{ diameter = {DIAMETER} }} }}\n\
            position = [{x:?}, {y:?}]\n{more}\n"
        )
    };
    let ground = |k: usize| disc("ground", 0.01 + 0.02 * k as f64, 0.006, "motion = \"fixed\"");
    let grain = |k: usize| disc("grain", 0.02 + 0.02 * k as f64, 0.014, "density = 2650.0");
    let grounds: String = (0..5).map(ground).collect();
    let grains: String = (0..4).map(grain).collect();
    let kinds = [
        ("bed_height", ""),
        ("bed_shear_stress", ""),
        ("shields", ""),
        ("bedload_rate", ""),
        ("einstein", "particles = [\"grain\"]"),
        ("transport_rate", ""),
    ];
    let one = |(kind, keys): &(&str, &str)| {
        format!("[[measure]]\nname = \"{kind}\"\nkind = \"{kind}\"\n{keys}\n")
    };
    let stress = |name: &str, keys: &str| {
        format!("[[measure]]\nname = \"{name}\"\nkind = \"bed_shear_stress\"\n{keys}\n")
    };
    let all = stress("all", &format!("region = {{ min = [0, 0], max = [{LENGTH}, {DEPTH}] }}"));
    let listed = stress("listed", "particles = [\"ground\"]");
    let more = format!(
        "{grounds}{grains}{}{all}{listed}[contact]\nfriction = 0.3\n[drive]\nforce = [{DRIVE}, 0]\n\
        [statistics]\nfrom = 0.0\n[output]\nfigures = false\nparticles = {{ every = 1 }}\n\
        fixed = \"always\"\n[time]\nend = 0.1\nstep = 0.001\n",
        kinds.iter().map(one).collect::<String>()
    );
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
    let text = box_case([LENGTH, DEPTH], [80, 48], 0.1, sides, &more)
        .replace("viscosity", "gravity = [0.0, -9.81]\nviscosity")
        .replace("density = 1.0", "density = 1000.0");
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    std::fs::write(&case, text).unwrap();
    let out = dir.path().join("out");
    let summary = run(&case, &out, &[]);
    let found = |name: &str| summary["measures"][name].as_f64().unwrap();
    println!("{}", summary["measures"]);

    let rows = columns(&out.join("particles.csv"));
    let times = 1 + rows["step"].iter().fold(0.0f64, |most, step| most.max(*step)) as usize;
    let sums = |column: &str, counts: fn(f64) -> bool| {
        let mut sums = vec![0.0; times];
        for ((step, id), value) in rows["step"].iter().zip(&rows["id"]).zip(&rows[column]) {
            sums[*step as usize] += if counts(*id) { *value } else { 0.0 };
        }
        sums
    };
    // A force is the mean over its step, and the first row has none.
    let force = |counts: fn(f64) -> bool| {
        sums("fluid_fx", counts)[1..].iter().sum::<f64>() / (times - 1) as f64
    };
    let volume = 0.25 * PI * DIAMETER * DIAMETER;
    // The measures begin with the first step.
    let rate = volume * trapezia(&sums("vx", |_| true)[1..]) / LENGTH;
    let near = |name: &str, expected: f64, tolerance: f64| {
        let value = found(name);
        println!("{name}: {value}, by hand {expected}");
        assert!((value - expected).abs() < tolerance * expected.abs(), "{name}: {value}");
    };
    near("bedload_rate", rate, 1e-9);
    near("transport_rate", rate, 1e-9);
    near("einstein", rate / (1.65 * 9.81 * DIAMETER.powi(3)).sqrt(), 1e-9);
    near("listed", force(|id| id < 5.0) / LENGTH, 1e-9);
    // No shear at the side that slips; the mean of the height is by trapezia.
    let balance = DRIVE * (DEPTH - found("bed_height"));
    near("bed_shear_stress", balance, 1e-3);
    near("shields", found("bed_shear_stress") / (1650.0 * 9.81 * DIAMETER), 1e-12);
    // What all bodies and the side below take of the momentum; the balance has the shear of stages.
    let balance = columns(&out.join("balance.csv"));
    near("all", (force(|_| true) - balance["boundary_shear"][0]) / LENGTH, 1e-2);
    let units = ["Pa", "", "m2/s", ""];
    for (kind, unit) in ["all", "shields", "bedload_rate", "einstein"].iter().zip(units) {
        assert_eq!(summary["units"][*kind].as_str().unwrap_or_default(), unit, "{kind}");
    }
}

/// In a steady channel the bed and the side below it take all that drives it: a force on the fluid
/// alone, or gravity along a slope, which bodies feel as well.
#[test]
fn bed_shear_stress_of_steady_channel_equals_its_drive() {
    const AREA: f64 = 0.1 * 0.06;
    let discs = 5.0 * 0.25 * PI * 0.01 * 0.01;
    let disc = |k: usize| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.01 }} }}\nmotion = \"fixed\"\n\
            position = [{:?}, 0.006]\n",
            0.01 + 0.02 * k as f64
        )
    };
    let ground: String = (0..5).map(disc).collect();
    let stress = |name: &str, keys: &str| {
        format!(
            "[[measure]]\nname = \"{name}\"\nkind = \"bed_shear_stress\"\naxis = \"x\"\n\
            from = 0.75\n{keys}\n"
        )
    };
    let all = stress("all", "region = { min = [0, 0], max = [0.1, 0.06] }");
    let balance = stress("balance", "");
    let height = "[[measure]]\nname = \"height\"\nkind = \"bed_height\"\n";
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
    for (drive, slope, pushed) in
        [("force = [100.0, 0.0]", 0.0, AREA - discs), ("gravity = true", 0.1, AREA)]
    {
        let more = format!(
            "{ground}[drive]\n{drive}\n{all}{balance}{height}[time]\nend = 0.8\ncfl = 0.4\n\
            [output]\nfigures = false\n"
        );
        let text = box_case([0.1, 0.06], [80, 48], 10.0, sides, &more)
            .replace("viscosity", &format!("gravity = [{slope:?}, -9.81]\nviscosity"))
            .replace("density = 1.0", "density = 1000.0");
        let found = measures(&text);
        let [all, balance, height] =
            ["all", "balance", "height"].map(|name| found[name].as_f64().unwrap());
        let exact = 100.0 * pushed / 0.1;
        println!("{drive}: {all} Pa of {exact} Pa, by the balance over {height} m {balance} Pa");
        assert!((all / exact - 1.0).abs() < 5e-3, "{all} {exact}");
        assert!((balance / (100.0 * (0.06 - height)) - 1.0).abs() < 1e-9, "{balance} {height}");
    }
}

#[test]
fn bed_measures_name_what_a_case_lacks() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("case.toml");
    let said = |kind: &str, particle: &str| {
        let more = format!(
            "[[particle]]\nname = \"stone\"\nshape = {{ disc = {{ diameter = 0.2 }} }}\n\
            position = [0.5, 0.5]\n{particle}\n[[measure]]\nname = \"bed\"\nkind = {kind}\n"
        );
        let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
        let text = box_case([1.0, 1.0], [16, 16], 0.1, sides, &more)
            .replace("viscosity", "gravity = [0.0, -9.81]\nviscosity");
        std::fs::write(&file, text).unwrap();
        String::from_utf8(mics(&["check", file.to_str().unwrap()]).stderr).unwrap()
    };
    let fixed = "motion = \"fixed\"";
    for (kind, particle, words) in [
        ("\"einstein\"\naxis = \"x\"", fixed, "measure.0.kind: is of grains that move"),
        ("\"shields\"\naxis = \"x\"", "density = 0.9", "are of grains heavier than the fluid"),
        ("\"shields\"\naxis = \"y\"", "density = 2.0", "measure.0.axis: gravity is along it"),
        ("\"bed_shear_stress\"", "density = 2.0", "along which axis: give `axis`"),
        ("\"mean_speed\"\nregion = { min = [0, 0], max = [1, 1] }", fixed, "bed_shear_stress"),
    ] {
        let said = said(kind, particle);
        assert!(said.contains(words), "{kind}: {said}");
    }
}
