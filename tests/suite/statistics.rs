//! Means over time, layers and probes: identities that hold to rounding, and runs that are broken off.

use crate::support::{box_case, columns, mics, run};
use mics::output::snapshot::Snapshot;
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
        "[drive]\nforce = [0.4, 0.0]\n{}{}[output]\nfigures = false\nfields = {{ every = 1 }}\n[time]\n{time}\n{more}",
        disc(0.5, 0.5, 0.2),
        disc(1.3, 1.3, -0.1)
    );
    box_case([2.0, 2.0], [24, 30], 0.05, CHANNEL, &more)
}

fn write(dir: &Path, name: &str, text: &str) -> std::path::PathBuf {
    std::fs::write(dir.join(name), text).unwrap();
    dir.join(name)
}

#[test]
fn means_are_those_of_the_fields_and_fractions_fill_the_bodies() {
    for wall in ["sharp", "mixing"] {
        let dir = tempfile::tempdir().unwrap();
        let plan = "[statistics]\nfrom = 0.02\nevery = 1\nprofile = \"y\"\n[[probe]]\nname = \"line\"\nat = [0.1, 1.0]\nto = [1.9, 1.0]\npoints = 4\n";
        let text = channel("end = 0.1\nstep = 0.01", &format!("{plan}[coupling]\nwall = \"{wall}\""));
        let out = dir.path().join("out");
        run(&write(dir.path(), "case.toml", &text), &out, &[]);
        let found = Snapshot::read(&out.join("statistics.vti")).unwrap();
        let fields: Vec<Snapshot> =
            (3..=10).map(|step| Snapshot::read(&out.join(format!("fields/{step:08}.vti"))).unwrap()).collect();
        let of = |s: &Snapshot, name: &str, at: usize| s.array(name).unwrap().values[at];
        let area = 2.0 * 0.25 * PI * 0.16;
        let cells = 24 * 30;
        let filled: f64 = (0..cells).map(|c| of(&found, "solid_fraction", c)).sum::<f64>() * 4.0 / cells as f64;
        assert!((filled / area - 1.0).abs() < 1e-12, "{wall}: {filled} of {area}");
        for c in (0..cells).step_by(7) {
            let weight: f64 = fields.iter().map(|s| 1.0 - of(s, "solid_fraction", c)).sum();
            // A field has the body's own motion where that fills most of a cell.
            let covered = |s: &Snapshot| (0.5..1.0).contains(&of(s, "solid_fraction", c));
            if weight < 1e-6 || fields.iter().any(covered) {
                continue;
            }
            let mean = |value: &dyn Fn(&Snapshot) -> f64| {
                fields.iter().map(|s| (1.0 - of(s, "solid_fraction", c)) * value(s)).sum::<f64>() / weight
            };
            let (u, v) = (mean(&|s| of(s, "velocity", 3 * c)), mean(&|s| of(s, "velocity", 3 * c + 1)));
            let uv = mean(&|s| of(s, "velocity", 3 * c) * of(s, "velocity", 3 * c + 1)) - u * v;
            for (name, at, expected) in [("velocity", 3 * c, u), ("velocity", 3 * c + 1, v), ("uv", c, uv)] {
                assert!((of(&found, name, at) - expected).abs() < 1e-9, "{wall}, {name} of cell {c}");
            }
        }
        let profile = columns(&out.join("profile.csv"));
        assert_eq!(profile["y"].len(), 30);
        let layered: f64 = profile["solid_fraction"].iter().sum::<f64>() / 30.0 * 4.0;
        assert!((layered / area - 1.0).abs() < 1e-12, "{wall}: {layered}");
        // The discs keep to their layers, and go as told with their spin about them.
        let at = |y: f64| (y / 2.0 * 30.0) as usize;
        assert!((profile["solid_u"][at(0.52)] - 0.2).abs() < 0.05 && profile["solid_u"][at(1.02)] == 0.0);
        // A probe at the middle between cells is their mean.
        let probes = std::fs::read_to_string(out.join("probes.csv")).unwrap();
        assert_eq!(probes.lines().count(), 1 + 4 * 11, "{probes}");
        let last: Vec<&str> = probes.lines().last().unwrap().split(',').collect();
        assert_eq!(last[2..6], ["line", "3", "1.9", "1.0"]);
        let end = fields.last().unwrap();
        // x = 1.9 is 0.3 of a cell below the centre of cell 22; y = 1.0 is between the cells 14 and 15.
        let cell = |i: usize, j: usize| of(end, "velocity", 3 * (i + 24 * j));
        let expected = 0.5 * (14..=15).map(|j| 0.7 * cell(22, j) + 0.3 * cell(23, j)).sum::<f64>();
        assert!((last[7].parse::<f64>().unwrap() - expected).abs() < 1e-12, "{} and {expected}", last[7]);
    }
}

#[test]
fn a_run_that_is_broken_off_has_the_same_means_and_records() {
    let dir = tempfile::tempdir().unwrap();
    let plan = "[statistics]\nevery = 3\nprofile = \"y\"\n[[probe]]\nname = \"a\"\nat = [0.3, 0.7]\nevery = 2\n";
    let case = write(dir.path(), "case.toml", &channel("end = 0.2\nstep = 0.01", plan));
    let [through, broken] = ["through", "broken"].map(|name| dir.path().join(name));
    run(&case, &through, &[]);
    run(&case, &broken, &["--set", "time.end=0.1"]);
    let on = mics(&["run", case.to_str().unwrap(), "--out", broken.to_str().unwrap(), "--resume", "--quiet"]);
    assert!(on.status.success(), "{}", String::from_utf8_lossy(&on.stderr));
    for file in ["statistics.vti", "profile.csv", "probes.csv", "particles.csv"] {
        let [a, b] = [&through, &broken].map(|out| std::fs::read(out.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
}

#[test]
fn a_channel_has_poiseuilles_profile_and_no_fluctuations_once_it_is_steady() {
    let dir = tempfile::tempdir().unwrap();
    let more = "[drive]\nmean_velocity = { axis = \"x\", value = 1.0 }\n[statistics]\nfrom = 9.0\nprofile = \"y\"\n[time]\nend = 10.0\ncfl = 0.4\n";
    let text = box_case([1.0, 1.0], [8, 20], 0.1, CHANNEL, more);
    let out = dir.path().join("out");
    run(&write(dir.path(), "case.toml", &text), &out, &[]);
    let profile = columns(&out.join("profile.csv"));
    for (y, u) in profile["y"].iter().zip(&profile["u"]) {
        assert!((u - 6.0 * y * (1.0 - y)).abs() < 4e-3, "{u} m/s at {y} m");
    }
    assert!(profile["uu"].iter().chain(&profile["uv"]).all(|v| v.abs() < 1e-9), "{profile:?}");
}
