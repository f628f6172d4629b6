//! Means over time, layers and probes: identities that hold to rounding, and runs that are broken
//! off.

use crate::program::write;
use crate::support::{box_case, columns, run, run_on_ranks, summary};
use mics_run::snapshot::Snapshot;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;

const CHANNEL: [&str; 4] = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];

/// Discs that go along a driven channel, as told, with these tables.
fn channel(time: &str, more: &str) -> String {
    let disc = |x: f64, y: f64, v: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.4 }} }}\nposition = [{x:?}, {y:?}]\n\
             motion = {{ prescribed = {{ velocity = [{v:?}, 0.0], spin = 1.0 }} }}\n"
        )
    };
    let more = format!(
        "[drive]\nforce = [0.4, 0.0]\n{}{}[output]\nfigures = false\nfields = {{ every = 1 }}\n\
        [time]\n{time}\n{more}",
        disc(0.5, 0.5, 0.2),
        disc(1.3, 1.3, -0.1)
    );
    box_case([2.0, 2.0], [24, 30], 0.05, CHANNEL, &more)
}

#[test]
fn statistics_means_equal_means_of_fields() {
    for wall in ["sharp", "mixing"] {
        let dir = tempfile::tempdir().unwrap();
        let plan = "[statistics]\nfrom = 0.02\nevery = 1\nprofile = \"y\"\n[[probe]]\n\
            name = \"line\"\nat = [0.1, 1.0]\nto = [1.9, 1.0]\npoints = 4\n";
        let text =
            channel("end = 0.1\nstep = 0.01", &format!("{plan}[coupling]\nwall = \"{wall}\""));
        let out = dir.path().join("out");
        run(&write(dir.path(), &text), &out, &[]);
        let found = Snapshot::read(&out.join("statistics.vti")).unwrap();
        let fields: Vec<Snapshot> = (3..=10)
            .map(|step| Snapshot::read(&out.join(format!("fields/{step:08}.vti"))).unwrap())
            .collect();
        let of = |s: &Snapshot, name: &str, at: usize| s.array(name).unwrap().values[at];
        let area = 2.0 * 0.25 * PI * 0.16;
        let cells = 24 * 30;
        let filled: f64 =
            (0..cells).map(|c| of(&found, "solid_fraction", c)).sum::<f64>() * 4.0 / cells as f64;
        assert!((filled / area - 1.0).abs() < 1e-12, "{wall}: {filled} of {area}");
        for c in (0..cells).step_by(7) {
            let weight: f64 = fields.iter().map(|s| 1.0 - of(s, "solid_fraction", c)).sum();
            // A field has the body's own motion where that fills most of a cell.
            let covered = |s: &Snapshot| (0.5..1.0).contains(&of(s, "solid_fraction", c));
            if weight < 1e-6 || fields.iter().any(covered) {
                continue;
            }
            let mean = |value: &dyn Fn(&Snapshot) -> f64| {
                fields.iter().map(|s| (1.0 - of(s, "solid_fraction", c)) * value(s)).sum::<f64>()
                    / weight
            };
            let (u, v) =
                (mean(&|s| of(s, "velocity", 3 * c)), mean(&|s| of(s, "velocity", 3 * c + 1)));
            let uv = mean(&|s| of(s, "velocity", 3 * c) * of(s, "velocity", 3 * c + 1)) - u * v;
            for (name, at, expected) in
                [("velocity", 3 * c, u), ("velocity", 3 * c + 1, v), ("uv", c, uv)]
            {
                assert!(
                    (of(&found, name, at) - expected).abs() < 1e-9,
                    "{wall}, {name} of cell {c}"
                );
            }
        }
        let profile = columns(&out.join("profile.csv"));
        assert_eq!(profile["y"].len(), 30);
        let layered: f64 = profile["solid_fraction"].iter().sum::<f64>() / 30.0 * 4.0;
        assert!((layered / area - 1.0).abs() < 1e-12, "{wall}: {layered}");
        // The discs keep to their layers, and go as told with their spin about them.
        let at = |y: f64| (y / 2.0 * 30.0) as usize;
        assert!(
            (profile["solid_u"][at(0.52)] - 0.2).abs() < 0.05
                && profile["solid_u"][at(1.02)] == 0.0
        );
        // A probe at the middle between cells is their mean.
        let probes = std::fs::read_to_string(out.join("probes.csv")).unwrap();
        assert_eq!(probes.lines().count(), 1 + 4 * 11, "{probes}");
        let last: Vec<&str> = probes.lines().last().unwrap().split(',').collect();
        assert_eq!(last[2..6], ["line", "3", "1.9", "1.0"]);
        let end = fields.last().unwrap();
        // x = 1.9 is 0.3 of a cell below the centre of cell 22; y = 1.0 is between the cells 14 and
        // 15.
        let cell = |i: usize, j: usize| of(end, "velocity", 3 * (i + 24 * j));
        let expected = 0.5 * (14..=15).map(|j| 0.7 * cell(22, j) + 0.3 * cell(23, j)).sum::<f64>();
        assert!(
            (last[7].parse::<f64>().unwrap() - expected).abs() < 1e-12,
            "{} and {expected}",
            last[7]
        );
    }
}

#[test]
fn resumed_run_has_same_statistics_and_probes() {
    let dir = tempfile::tempdir().unwrap();
    let plan = "[statistics]\nevery = 3\nprofile = \"y\"\n[[probe]]\nname = \"a\"\n\
        at = [0.3, 0.7]\nevery = 2\n";
    let case = write(dir.path(), &channel("end = 0.2\nstep = 0.01", plan));
    let [through, broken] = ["through", "broken"].map(|name| dir.path().join(name));
    run(&case, &through, &[]);
    run(&case, &broken, &["--set", "time.end=0.1"]);
    let cpu = |out: &Path| summary(out)["cpu_seconds"].as_f64().unwrap();
    let first = cpu(&broken);
    run(&case, &broken, &["--resume"]);
    for file in ["statistics.vti", "profile.csv", "probes.csv", "particles.csv"] {
        let [a, b] = [&through, &broken].map(|out| std::fs::read(out.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
    // The first half counts too.
    assert!(cpu(&broken) > first, "{} s, the first half took {first} s", cpu(&broken));
}

/// The cells inside a body with sharp surfaces hold a continuation of the fluid's profile, which is
/// no velocity of anything.
#[test]
fn probe_inside_body_has_body_velocity_and_id() {
    for wall in ["sharp", "mixing"] {
        let dir = tempfile::tempdir().unwrap();
        let probes = "[[probe]]\nname = \"in\"\nat = [0.6, 0.6]\n[[probe]]\nname = \"out\"\n\
            at = [1.3, 0.4]\n";
        let text =
            channel("end = 0.1\nstep = 0.01", &format!("{probes}[coupling]\nwall = \"{wall}\""));
        let out = dir.path().join("out");
        run(&write(dir.path(), &text), &out, &[]);
        let text = std::fs::read_to_string(out.join("probes.csv")).unwrap();
        let [inside, outside]: [Vec<&str>; 2] =
            std::array::from_fn(|n| text.lines().rev().nth(1 - n).unwrap().split(',').collect());
        let [vx, vy] = [7, 8].map(|column| inside[column].parse::<f64>().unwrap());
        // The disc has gone from (0.5, 0.5) to (0.52, 0.5), at 0.2 m/s and 1 rad/s.
        assert!((vx - 0.1).abs() < 1e-12 && (vy - 0.08).abs() < 1e-12, "{wall}: {vx}, {vy} m/s");
        assert_eq!((inside[11], outside[11]), ("0", ""), "{wall}");
    }
}

#[test]
fn statistics_of_steady_channel_are_poiseuille_without_fluctuations() {
    let dir = tempfile::tempdir().unwrap();
    let more = "[drive]\nmean_velocity = { axis = \"x\", value = 1.0 }\n[statistics]\nfrom = 9.0\n\
        profile = \"y\"\n[time]\nend = 10.0\ncfl = 0.4\n";
    let text = box_case([1.0, 1.0], [8, 20], 0.1, CHANNEL, more);
    let out = dir.path().join("out");
    run(&write(dir.path(), &text), &out, &[]);
    let profile = columns(&out.join("profile.csv"));
    for (y, u) in profile["y"].iter().zip(&profile["u"]) {
        assert!((u - 6.0 * y * (1.0 - y)).abs() < 4e-3, "{u} m/s at {y} m");
    }
    assert!(profile["uu"].iter().chain(&profile["uv"]).all(|v| v.abs() < 1e-9), "{profile:?}");
}

/// The terms of `balance.csv` beside the change.
const TERMS: [&str; 8] = [
    "drive",
    "gravity",
    "boundary_pressure",
    "boundary_shear",
    "boundary_flow",
    "contacts",
    "held",
    "passages",
];

/// Imbalance of the rows of `balance.csv`, by axis, and their largest terms (N).
fn missing(balance: &HashMap<String, Vec<f64>>) -> [[f64; 2]; 2] {
    std::array::from_fn(|axis| {
        let given: f64 = TERMS.iter().map(|name| balance[*name][axis]).sum();
        let largest = TERMS
            .iter()
            .map(|name| balance[*name][axis].abs())
            .fold(balance["change"][axis].abs(), f64::max);
        [balance["change"][axis] - given, largest]
    })
}

#[test]
fn mean_balance_of_momentum_closes_in_driven_channel() {
    let disc = |x: f64, y: f64, more: &str| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.24 }} }}\nposition = [{x:?}, {y:?}]\n\
            {more}\n"
        )
    };
    // One strikes the floor, two meet, a light one rises, a fixed one stands in the way.
    let discs = [
        disc(0.3, 0.14, "density = 2.65\nvelocity = [0.4, -0.5]\nspin = 3.0"),
        disc(0.9, 0.5, "density = 1.5\nvelocity = [0.6, 0.0]"),
        disc(1.2, 0.52, "density = 3.0\nvelocity = [-0.6, 0.0]"),
        disc(1.6, 0.6, "density = 0.5"),
        disc(0.5, 0.8, "motion = \"fixed\""),
    ]
    .concat();
    for drive in ["mean_velocity = { axis = \"x\", value = 0.3 }", "force = [0.5, 0.0]"] {
        let dir = tempfile::tempdir().unwrap();
        let more = format!(
            "{discs}[contact]\nnormal_stiffness = 500.0\nfriction = 0.3\n[drive]\n{drive}\n\
            [coupling]\nwall = \"sharp\"\n\
             [statistics]\nfrom = 0.0999\nevery = 3\nprofile = \"y\"\n[pressure]\n\
                 divergence_limit = 1e-9\n\
             [output]\nfigures = false\n[time]\nend = 0.4\nstep = 4e-3\n"
        );
        let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "{ moving_wall = [0.5, 0.0] }"];
        let text = box_case([2.0, 1.0], [48, 24], 0.02, sides, &more)
            .replace("density = 1.0\n", "density = 1.0\ngravity = [0.0, -1.0]\n");
        let case = write(dir.path(), &text);
        let [alone, shared] = ["alone", "shared"].map(|name| dir.path().join(name));
        run(&case, &alone, &[]);
        run_on_ranks(2, &case, &shared);
        summary(&shared);
        for out in [&alone, &shared] {
            let balance = columns(&out.join("balance.csv"));
            for (axis, [missing, largest]) in missing(&balance).into_iter().enumerate() {
                println!(
                    "{drive}, axis {axis}: {missing:.1e} N of {largest:.3} N are missing: \
                    {balance:?}"
                );
                assert!(
                    missing.abs() < 1e-8 * largest,
                    "{drive}, axis {axis}: {missing} of {largest} N"
                );
                // Without any of these it would not close.
                let needed = [
                    &["drive", "boundary_shear", "held"][..],
                    &["gravity", "boundary_pressure", "contacts", "held"],
                ];
                for name in needed[axis] {
                    assert!(
                        balance[*name][axis].abs() > 1e-3 * largest,
                        "{drive}: {name} is {balance:?}"
                    );
                }
            }
            // The rows of the steps have the same sums: from 0.1 s on, and up to the last step that
            // is a multiple of three.
            let steps = columns(&out.join("steps.csv"));
            let over = |name: &str| steps[name][26..100].iter().sum::<f64>();
            let duration = over("dt");
            assert!((balance["duration"][0] - duration).abs() < 1e-12, "{balance:?}");
            for (axis, x) in ["x", "y"].into_iter().enumerate() {
                let momentum = &steps[&format!("momentum_{x}")];
                let change = (momentum[99] - momentum[25]) / duration;
                let boundary = over(&format!("boundary_impulse_{x}")) / duration;
                let told: f64 = ["boundary_pressure", "boundary_shear", "boundary_flow"]
                    .iter()
                    .map(|name| balance[*name][axis])
                    .sum();
                assert!(
                    (balance["change"][axis] - change).abs() < 1e-12
                        && (told - boundary).abs() < 1e-12,
                    "{balance:?}"
                );
            }
        }
        let [a, b] = [&alone, &shared].map(|out| columns(&out.join("balance.csv")));
        for name in TERMS {
            let apart =
                a[name].iter().zip(&b[name]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-6, "{drive}: {name} differs by {apart} N");
        }
    }
}

#[test]
fn statistics_and_balance_include_entering_bodies() {
    let dir = tempfile::tempdir().unwrap();
    let stream = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];
    let more = "[[swarm]]\ncount = 3\nregion = { min = [0.05, 0.0], max = [0.6, 1.0] }\n\
        diameter = 0.2\ndensity = 1.5\n\
         feed = { rate = 8.0, from = 0.055 }\n[contact]\n[statistics]\nevery = 1\n\
         [pressure]\ndivergence_limit = 1e-9\n[output]\nfigures = false\n[time]\nend = 0.4\n\
         step = 0.01\n";
    let out = dir.path().join("out");
    run(&write(dir.path(), &box_case([2.0, 1.0], [48, 24], 0.01, stream, more)), &out, &[]);
    let found = Snapshot::read(&out.join("statistics.vti")).unwrap();
    let filled =
        found.array("solid_fraction").unwrap().values.iter().sum::<f64>() * 2.0 / (48.0 * 24.0);
    // There from 0.06, 0.18 and 0.31 s on, of 0.4 s.
    let expected = 0.25 * PI * 0.04 * (0.34 + 0.22 + 0.09) / 0.4;
    assert!((filled / expected - 1.0).abs() < 1e-12, "{filled} m2, not {expected}");
    let balance = columns(&out.join("balance.csv"));
    let [[missing, largest], _] = missing(&balance);
    println!("{missing:.1e} of {largest:.3} N: {balance:?}");
    assert!(missing.abs() < 1e-8 * largest, "{missing} of {largest} N, {balance:?}");
    assert!(balance["passages"][0].abs() > 1e-3 * largest, "{balance:?}");
}

/// Between the last cells of a rank and the first of the next a probe reads both, as they are after
/// a body's motion was mixed in.
#[test]
fn probes_at_subdomain_edge_read_correct_values() {
    for wall in ["sharp", "mixing"] {
        let dir = tempfile::tempdir().unwrap();
        let disc = "[[particle]]\nshape = { disc = { diameter = 0.6 } }\nposition = [1.0, 1.0]\n\
                    motion = { prescribed = { velocity = [0.4, 0.2] } }\n";
        let probe =
            "[[probe]]\nname = \"beside\"\nat = [0.6, 0.97]\nto = [1.4, 1.03]\npoints = 9\n";
        let text = format!(
            "{disc}{probe}[coupling]\nwall = \"{wall}\"\n[pressure]\ndivergence_limit = 1e-8\n\
            [output]\nfigures = false\n\
             [time]\nend = 0.1\nstep = 0.01\n"
        );
        let case = write(dir.path(), &box_case([2.0, 2.0], [24, 30], 0.05, CHANNEL, &text));
        let [alone, shared] = ["alone", "shared"].map(|name| dir.path().join(name));
        run(&case, &alone, &[]);
        run_on_ranks(2, &case, &shared);
        let text = |out: &Path| std::fs::read_to_string(out.join("probes.csv")).unwrap();
        let velocities = |out: &Path| -> Vec<f64> {
            let rows = text(out);
            let row = |line: &str| {
                line.split(',').skip(7).take(2).map(|v| v.parse().unwrap()).collect::<Vec<f64>>()
            };
            rows.lines().skip(1).flat_map(row).collect()
        };
        let worst = velocities(&alone)
            .iter()
            .zip(velocities(&shared))
            .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        println!("{wall}: {worst:.1e} m/s");
        assert!(worst < 1e-7, "{wall}: {worst} m/s");
    }
}

#[test]
fn shortest_snapshot_interval_writes_every_step() {
    let dir = tempfile::tempdir().unwrap();
    let text = box_case(
        [1.0, 1.0],
        [16, 16],
        0.05,
        CHANNEL,
        "[drive]\nforce = [0.4, 0.0]\n[time]\nend = 0.05\nstep = 0.01\n",
    );
    let case = write(dir.path(), &text);
    for (n, every) in ["1e-25", "1e-19", "0.01"].into_iter().enumerate() {
        let out = dir.path().join(n.to_string());
        run(
            &case,
            &out,
            &[
                "--set",
                &format!("output.fields={{ every_time = {every} }}"),
                "--set",
                "output.figures=false",
            ],
        );
        let snapshots = std::fs::read_dir(out.join("fields")).unwrap().filter(|file| {
            file.as_ref().unwrap().path().extension().is_some_and(|extension| extension == "vti")
        });
        assert_eq!(snapshots.count(), 6, "every {every} s");
    }
}
