//! Measures of the whole box, and channels that bodies or boundaries shut.

use crate::drive::{CHANNEL, disc};
use crate::support::{box_case, mics, mpirun, run};
use std::f64::consts::PI;

/// The measures of a run of this case.
pub fn measures(text: &str) -> serde_json::Value {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    std::fs::write(&file, text).unwrap();
    run(&file, &folder.path().join("out"), &[])["measures"].clone()
}

#[test]
fn measures_of_flow_rate_pressure_drop_and_drive_force() {
    let kinds = |kinds: &[(&str, &str)]| -> String {
        kinds
            .iter()
            .map(|(kind, keys)| {
                format!("[[measure]]\nname = \"{kind}\"\nkind = \"{kind}\"\n{keys}\n")
            })
            .collect()
    };
    let number = |of: &serde_json::Value, name: &str| {
        of[name].as_f64().unwrap_or_else(|| panic!("{name} in {of}"))
    };
    // A pier that stays, and two grains that move as told: every number is known beforehand.
    let told = |x: f64, y: f64, v: f64| {
        format!(
            "[[particle]]\nname = \"grain\"\nshape = {{ disc = {{ diameter = 0.4 }} }}\n\
            position = [{x:?}, {y:?}]\n\
             motion = {{ prescribed = {{ velocity = [{v:?}, 0.0] }} }}\n"
        )
    };
    let box_kinds = kinds(&[
        ("superficial_velocity", ""),
        ("flow_rate", ""),
        ("drive_force", ""),
        ("pressure_drop", ""),
        ("transport_rate", "particles = [\"grain\"]"),
        ("mean_speed", "particles = [\"grain\"]"),
        ("rms_speed", "particles = [\"grain\", \"pier\"]"),
        ("bed_height", "threshold = 0.05"),
        ("solid_fraction", "region = { min = [0.0, 0.0], max = [2.0, 1.0] }"),
        ("force", "particles = [\"pier\"]"),
    ]);
    let pier = disc([1.0, 0.5], 1.0, "name = \"pier\"\nmotion = \"fixed\"");
    let more = format!(
        "[drive]\nmean_velocity = {{ axis = \"x\", value = 0.3 }}\n{pier}{}{}{box_kinds}[output]\n\
        figures = false\n",
        told(0.5, 1.2, 0.1),
        told(1.3, 1.2, 0.3)
    );
    let text =
        box_case([2.0, 2.0], [40, 40], 0.1, CHANNEL, &more).replace("end = 1.0", "end = 0.2");
    let found = measures(&text.replace("viscosity", "gravity = [0.0, -1.0]\nviscosity"));
    let grain = 0.25 * PI * 0.16;
    let near = |name: &str, expected: f64, tolerance: f64| {
        let value = number(&found, name);
        assert!(
            (value - expected).abs() <= tolerance * expected.abs(),
            "{name}: {value}, not {expected}: {found}"
        );
    };
    near("flow_rate", 0.3 * 2.0, 1e-12);
    near("transport_rate", grain * 0.4 / 2.0, 1e-12);
    near("superficial_velocity", 0.3 - grain * 0.4 / 4.0, 1e-12);
    near("mean_speed", 0.2, 1e-12);
    near("rms_speed", (0.1f64 / 3.0).sqrt(), 1e-12);
    near("pressure_drop", 2.0 * number(&found, "drive_force"), 1e-12);
    near("solid_fraction", 0.25 * PI * 0.36 / 2.0, 1e-9);
    // The chord of the two grains is 5 % of the length where they are 0.1 m wide in all, next to
    // their top at 1.4 m.
    near("bed_height", 1.4, 0.02);
    assert!(number(&found, "force") > 0.0, "{found}");
    // Poiseuille between an inflow and an outflow: the drop of the pressure is 12 mu U L/H^2.
    let sides = ["{ inflow_parabola = [1.5, 0.0] }", "\"outflow\"", "\"wall\"", "\"wall\""];
    let text = box_case(
        [4.0, 1.0],
        [64, 16],
        0.1,
        sides,
        &kinds(&[("pressure_drop", "axis = \"x\"\nfrom = 2.9")]),
    );
    let drop = number(&measures(&text.replace("end = 1.0", "end = 3.0")), "pressure_drop");
    assert!((drop / (12.0 * 0.1 * 4.0) - 1.0).abs() < 0.01, "{drop} Pa");
}

#[test]
fn check_warns_of_driven_channel_blocked_by_bodies() {
    let dir = tempfile::tempdir().unwrap();
    let said = |discs: &[(f64, f64)]| {
        let disc = |(y, d): &(f64, f64)| {
            format!(
                "[[particle]]\nshape = {{ disc = {{ diameter = {d} }} }}\nposition = [0.1, {y}]\n\
                motion = \"fixed\"\n"
            )
        };
        let discs: String = discs.iter().map(disc).collect();
        let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];
        let text = box_case(
            [2.0, 1.0],
            [80, 40],
            0.1,
            sides,
            &format!("{discs}[drive]\nforce = [1.0, 0.0]\n[time]\nend = 1.0\nstep = 1e-3\n"),
        );
        std::fs::write(dir.path().join("case.toml"), text).unwrap();
        let said = mics(&["check", dir.path().join("case.toml").to_str().unwrap()]);
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
        String::from_utf8_lossy(&said.stdout).contains("shut the channel along x")
    };
    // Discs that touch from wall to wall, and fewer.
    assert!(said(&[(0.25, 0.5), (0.75, 0.5)]));
    assert!(!said(&[(0.25, 0.5), (0.75, 0.4)]));
    assert!(!said(&[(0.25, 0.5)]));
}

#[test]
fn blocked_inflow_is_refused_on_several_ranks() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let sides = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"wall\"", "\"wall\""];
    let write = |diameter: f64, motion: &str| {
        let disc = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = {diameter} }} }}\n\
            position = [1.0, 0.5]\nmotion = {motion}\n"
        );
        let time = "[time]\nend = 1e-3\nstep = 1e-3\n[output]\nfigures = false\n";
        std::fs::write(&case, box_case([2.0, 1.0], [64, 32], 0.1, sides, &format!("{disc}{time}")))
            .unwrap();
    };
    let out = dir.path().join("out");
    let arguments = ["run", case.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap()];
    write(1.0, "\"fixed\"");
    for said in [
        mics(&["check", case.to_str().unwrap()]),
        mics(&arguments),
        mpirun(2, env!("CARGO_BIN_EXE_mics")).args(arguments).output().unwrap(),
    ] {
        let words = String::from_utf8_lossy(&said.stderr);
        assert!(
            !said.status.success()
                && words.contains("shut the channel between west and the outflow"),
            "{words}"
        );
    }
    assert!(!out.exists(), "it wrote something");
    write(0.9, "\"fixed\"");
    let said = mics(&arguments);
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
}

#[test]
fn unbalanced_inflow_without_outflow_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let out = dir.path().join("out");
    let disc = "[[particle]]\nshape = { disc = { diameter = 0.25 } }\nposition = [0.7, 0.5]\n\
        motion = \"fixed\"\n";
    let said = |east: &str| {
        let sides = ["{ inflow_parabola = [1.0, 0.0] }", east, "\"wall\"", "\"wall\""];
        let more = format!("{disc}[time]\nend = 0.1\n");
        std::fs::write(&case, box_case([2.0, 1.0], [64, 32], 0.1, sides, &more)).unwrap();
        mics(&["run", case.to_str().unwrap(), "--quiet", "--force", "--out", out.to_str().unwrap()])
    };
    let balanced = said("{ inflow_parabola = [1.0, 0.0] }");
    assert!(balanced.status.success(), "{}", String::from_utf8_lossy(&balanced.stderr));
    let refused = said("{ inflow_parabola = [0.5, 0.0] }");
    let words = String::from_utf8_lossy(&refused.stderr);
    assert!(words.contains("0.66699 m2/s come in and 0.3335 m2/s go out"), "{words}");
}
