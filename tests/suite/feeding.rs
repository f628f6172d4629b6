//! Bodies that come in while the run goes on: fed, waiting, and with the momentum that they bring.

use crate::passage::fed;
use crate::program::write;
use crate::support::{PERIODIC, SHARP, STREAM, box_case, columns, mics, run, run_on_ranks};
use std::collections::HashMap;
use std::path::Path;

#[test]
fn fed_discs_are_counted_on_one_and_two_ranks() {
    let dir = tempfile::tempdir().unwrap();
    let [out, broken] = ["out", "broken"].map(|name| dir.path().join(name));
    let text = fed("end = 2.5", &format!("{SHARP}[pressure]\ndivergence_limit = 1e-8\n"));
    let case = write(dir.path(), &text);
    run(&case, &out, &[]);
    let passages = columns(&out.join("passages.csv"));
    let told = std::fs::read_to_string(out.join("passages.csv")).unwrap();
    let (came, left): (Vec<_>, Vec<_>) =
        told.lines().skip(1).partition(|line| line.contains(",entered,"));
    // Twelve come in their order, 0.125 s apart, with the stream's velocity.
    assert_eq!(came.len(), 12, "{told}");
    for (n, line) in came.iter().enumerate() {
        let number = |k: usize| line.split(',').nth(k).unwrap().parse::<f64>().unwrap();
        let due = 0.1 + 0.125 * n as f64;
        assert!(number(2) == n as f64 && (due..due + 0.011).contains(&number(1)), "{line}");
        assert!((0.15..=0.4).contains(&number(6)) && (0.9..1.1).contains(&number(9)), "{line}");
    }
    assert!(left.len() > 2, "{told}");
    // Mass: what came less what left is there.
    let mass = |lines: &[&str]| {
        lines.iter().map(|l| l.split(',').nth(4).unwrap().parse::<f64>().unwrap()).sum::<f64>()
    };
    let rows = columns(&out.join("particles.csv"));
    let there = rows["step"].iter().filter(|step| **step == 250.0).count();
    assert_eq!(there, came.len() - left.len());
    assert!(
        mass(&came) > mass(&left) && passages["mass"].iter().all(|m| (0.047..0.068).contains(m))
    );
    let steps = columns(&out.join("steps.csv"));
    let largest = |name: &str| steps[name].iter().fold(0.0f64, |most, e| most.max(e.abs()));
    assert!(largest("momentum_error") < 1e-11, "{}", largest("momentum_error"));
    assert!(largest("method_loss") < 0.01, "{}", largest("method_loss"));
    // A run in two parts gives the same, byte for byte, though bodies wait in between.
    run(&case, &broken, &["--set", "time.end=0.8"]);
    run(&case, &broken, &["--resume"]);
    for file in ["particles.csv", "passages.csv"] {
        let [a, b] = [&out, &broken].map(|out| std::fs::read(out.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
    let shared = dir.path().join("shared");
    run_on_ranks(2, &case, &shared);
    assert_eq!(columns(&shared.join("passages.csv"))["step"], passages["step"]);
}

#[test]
fn entering_body_waits_for_free_place() {
    let dir = tempfile::tempdir().unwrap();
    let disc = |x: f64, more: &str| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, 0.5]\n\
            density = 2.0\n{more}\n"
        )
    };
    // The first leaves its place at 1 m/s: the second, which would lie where that is now, comes
    // once it is clear by a diameter.
    let discs = disc(0.5, "velocity = [1.0, 0.0]")
        + &disc(0.5, "velocity = [0.5, 0.1]\nenter = { time = 0.1 }");
    let text = box_case(
        [2.0, 1.0],
        [48, 24],
        0.01,
        STREAM,
        &format!("{discs}[time]\nend = 0.6\nstep = 0.01\n[contact]\n"),
    );
    let out = dir.path().join("out");
    run(&write(dir.path(), &text), &out, &[]);
    let came = columns(&out.join("passages.csv"));
    assert!(came["id"] == [1.0] && (0.29..0.36).contains(&came["time"][0]), "{came:?}");
    assert_eq!((came["vx"][0], came["vy"][0]), (0.5, 0.1));
    // The case as it was written out says the same.
    let again = dir.path().join("again");
    run(&out.join("case.toml"), &again, &[]);
    let [a, b] = [&out, &again].map(|out| std::fs::read(out.join("particles.csv")).unwrap());
    assert!(a == b);
}

/// A body that comes in, or comes back, has its own velocity and spin, less what sets the fluid
/// beside it going: with the paper's mixing it had those of the fluid that it came into.
#[test]
fn entering_body_has_given_velocity_and_spin() {
    for wall in ["sharp", "mixing"] {
        let dir = tempfile::tempdir().unwrap();
        let disc = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.5, 0.5]\n\
            density = 5.0\n\
                    velocity = [0.3, 0.0]\nspin = 4.0\n";
        let at_rest = ["\"wall\""; 4];
        let rest = format!(
            "enter = {{ time = 0.05 }}\n[time]\nend = 0.1\nstep = 0.01\n[contact]\n[coupling]\n\
            wall = {wall:?}\n"
        );
        let case = box_case([2.0, 1.0], [48, 24], 1e-3, at_rest, &format!("{disc}{rest}"));
        let out = dir.path().join("out");
        run(&write(dir.path(), &case), &out, &[]);
        let rows = columns(&out.join("particles.csv"));
        let (speed, spin) = (*rows["vx"].last().unwrap(), *rows["wz"].last().unwrap());
        println!("{wall}: {speed} m/s, {spin} rad/s");
        // As much fluid as it displaces goes along.
        assert!((speed / 0.25 - 1.0).abs() < 0.15, "{wall}: {speed} m/s");
        assert!((0.75 * 4.0..=4.0).contains(&spin), "{wall}: {spin} rad/s");
    }
}

/// An entering body shares its momentum at once with the fluid that it sets off: left to a step,
/// one lighter than that fluid turned back, or made energy and ended the run.
#[test]
fn entering_light_body_shares_momentum_with_fluid() {
    for (s, y) in [(0.01, 0.5), (0.1, 0.5), (0.1, 0.2), (2.65, 0.5)] {
        let dir = tempfile::tempdir().unwrap();
        let text = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [0.6, {y:?}]\n\
            density = {s:?}\nvelocity = [0.5, 0.0]\n\
             enter = {{ time = 0.01 }}\n[contact]\n[time]\nend = 0.2\nstep = 0.01\n{SHARP}"
        );
        let case = box_case([3.0, 2.0], [80, 53], 0.01, ["\"wall\""; 4], &text);
        let out = dir.path().join("out");
        run(&write(dir.path(), &case), &out, &[]);
        let rows = columns(&out.join("particles.csv"));
        let speeds = &rows["vx"];
        println!("s = {s}, {y} m: {speeds:?}");
        // Its added mass is that of as much fluid as it displaces, and more beside the wall.
        let part = s / (s + if y > 0.3 { 1.0 } else { 1.5 });
        assert!(
            (speeds[0] / (0.5 * part) - 1.0).abs() < 0.2,
            "s = {s} at {y} m: {} m/s of {}",
            speeds[0],
            0.5 * part
        );
        assert!(
            speeds.windows(2).all(|v| v[1] < v[0] && v[1] > 0.0),
            "s = {s} at {y} m: {speeds:?}"
        );
        let steps = columns(&out.join("steps.csv"));
        let given = steps["boundary_work"].last().unwrap();
        for loss in ["method_loss", "contact_loss", "viscous_loss"] {
            let least = steps[loss].iter().copied().fold(0.0, f64::min);
            assert!(least > -1e-2 * given, "s = {s} at {y} m: {loss} {least:.1e} of {given:.1e} J");
        }
    }
}

/// In a periodic box at rest nothing else has momentum: what comes in stays, in the cells, in
/// bodies, and in what these have not felt yet.
#[test]
fn entering_body_momentum_is_conserved() {
    for s in [0.1, 1.0, 2.65] {
        let dir = tempfile::tempdir().unwrap();
        let disc = |x: f64, more: &str| {
            format!(
                "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\n\
                position = [{x:?}, 0.513]\ndensity = {s:?}\n{more}\n"
            )
        };
        let both = disc(0.607, "velocity = [0.5, 0.2]\nenter = { time = 0.01 }") + &disc(1.02, "");
        let text = format!("{both}[contact]\n[time]\nend = 0.1\nstep = 0.01\n{SHARP}");
        let out = dir.path().join("out");
        run(&write(dir.path(), &box_case([2.0, 1.0], [48, 24], 0.01, PERIODIC, &text)), &out, &[]);
        let steps = columns(&out.join("steps.csv"));
        let mass = s * std::f64::consts::PI * 0.15 * 0.15;
        for (axis, velocity) in [("momentum_x", 0.5), ("momentum_y", 0.2)] {
            let last = steps[axis].last().unwrap();
            println!("s = {s}: {axis} {last} of {}", mass * velocity);
            assert!(
                (last / (mass * velocity) - 1.0).abs() < 1e-9,
                "s = {s}: {axis} {last} of {}",
                mass * velocity
            );
        }
    }
}

#[test]
fn fixed_bed_has_rows_once_and_starts_another_case() {
    let dir = tempfile::tempdir().unwrap();
    let ground = "[[swarm]]\nname = \"ground\"\ncount = 12\n\
        region = { min = [0.0, 0.0], max = [2.0, 0.15] }\ndiameter = 0.12\n\
                  motion = \"fixed\"\n[[particle]]\nshape = { disc = { diameter = 0.3 } }\n\
                      position = [0.5, 0.6]\ndensity = 2.0\n";
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];
    let text = |more: &str| {
        box_case(
            [2.0, 1.0],
            [48, 24],
            0.01,
            sides,
            &format!("{more}[time]\nend = 0.1\nstep = 0.01\n[contact]\n"),
        )
    };
    let count = |out: &Path| {
        let rows = columns(&out.join("particles.csv"));
        [0.0, 12.0].map(|id| rows["id"].iter().filter(|k| **k == id).count())
    };
    let [out, all, next] = ["out", "all", "next"].map(|name| dir.path().join(name));
    let case = write(dir.path(), &text(ground));
    run(&case, &out, &[]);
    assert_eq!(count(&out), [11, 1]);
    run(
        &case,
        &all,
        &["--set", "output.fixed=\"always\"", "--set", "output.particles={ every = 1 }"],
    );
    assert_eq!(count(&all), [11, 11]);
    let shown = mics(&["plot", out.to_str().unwrap()]);
    assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
    run(&write(dir.path(), &text(&format!("[initial]\nfrom = {out:?}\n"))), &next, &[]);
    assert_eq!(count(&next), [11, 1]);
    let [a, b] = [&out, &next].map(|out| columns(&out.join("particles.csv")));
    // The disc goes on from where it was, the ground lies where it lay.
    let place = |rows: &HashMap<String, Vec<f64>>, id: f64, last: bool| {
        let mut of = (0..rows["id"].len()).filter(|k| rows["id"][*k] == id);
        let row = if last { of.next_back() } else { of.next() }.unwrap();
        (rows["x"][row], rows["y"][row])
    };
    assert_eq!(place(&a, 0.0, true), place(&b, 0.0, false));
    assert_eq!(place(&a, 12.0, true), place(&b, 12.0, true));
}

#[test]
fn resume_with_entering_grains_and_open_sides_byte_for_byte() {
    let dir = tempfile::tempdir().unwrap();
    let [out, broken] = ["out", "broken"].map(|name| dir.path().join(name));
    let feed = "[[swarm]]\ncount = 12\nregion = { min = [0.8, 0.7], max = [1.2, 1.0] }\n\
        diameter = { uniform = [0.16, 0.2] }\n\
                density = 2.5\nfeed = { rate = 10.0 }\n[contact]\n[output]\nfigures = false\n\
                particles = { every = 10 }\n";
    let sides = ["\"outflow\"", "\"outflow\"", "\"wall\"", "\"wall\""];
    let text = box_case(
        [2.0, 1.0],
        [64, 32],
        0.005,
        sides,
        &format!("[time]\nend = 1.2\nstep = 0.004\n{feed}"),
    );
    let case = write(
        dir.path(),
        &text.replace("density = 1.0\n", "density = 1.0\ngravity = [0.0, -1.0]\n"),
    );
    run(&case, &out, &[]);
    run(&case, &broken, &["--set", "time.end=0.8"]);
    run(&case, &broken, &["--resume"]);
    let [a, b] = [&out, &broken].map(|out| std::fs::read(out.join("particles.csv")).unwrap());
    assert!(a == b);
    // They have met the floor and each other, and the open sides have not driven the box.
    let steps = columns(&out.join("steps.csv"));
    assert!(steps["substeps"].iter().any(|n| *n > 0.0));
    let [given, taken] = ["gravity_work", "boundary_work"].map(|name| *steps[name].last().unwrap());
    assert!(taken.abs() < 0.05 * given, "{taken} {given}");
}

/// An obstacle is in the way of bodies that come in where it is, and not as far as its corners are
/// from its centre.
#[test]
fn bodies_come_in_over_a_bed_as_wide_as_the_box() {
    let dir = tempfile::tempdir().unwrap();
    let bed =
        "[[obstacle]]\npolygon = { points = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.3], [0.0, 0.4]] }\n";
    let text =
        fed("end = 0.5", bed).replace("diameter = { uniform = [0.2, 0.24] }", "diameter = 0.2");
    let out = dir.path().join("out");
    run(&write(dir.path(), &text), &out, &[]);
    let came = columns(&out.join("passages.csv"));
    assert_eq!(came["id"], [0.0, 1.0, 2.0, 3.0], "{came:?}");
    // Where they come in the bed is 0.375 to 0.4 high.
    assert!(came["y"].iter().all(|y| (0.475..0.9).contains(y)), "{came:?}");
}
