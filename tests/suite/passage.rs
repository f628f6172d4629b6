//! Free bodies that reach an outflow leave, return or end the run, and nothing of the others
//! changes.

use crate::support::{PERIODIC, SHARP, box_case, columns, mics, mpirun, run, summary};
use std::collections::HashMap;
use std::path::Path;

const STREAM: [&str; 4] = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];

/// Four discs in a stream that carries them out one after the other, with these tables.
fn carried(time: &str, more: &str) -> String {
    let disc = |x: f64, y: f64, density: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, {y:?}]\n\
            velocity = [1.0, 0.0]\n\
             density = {density:?}\n"
        )
    };
    let discs =
        disc(1.55, 0.3, 1.5) + &disc(0.4, 0.6, 1.0) + &disc(1.2, 0.72, 0.8) + &disc(0.8, 0.25, 3.0);
    let ends = "[[measure]]\nname = \"first\"\nkind = \"velocity_x\"\nparticle = 0\n[[measure]]\n\
        name = \"light\"\nkind = \"mean_speed\"\n\
                particles = [0, 2]\n[[measure]]\nname = \"last\"\nkind = \"position_x\"\n\
                    particle = 1\n[[measure]]\nname = \"all\"\nkind = \"mean_speed\"\n";
    box_case(
        [2.0, 1.0],
        [48, 24],
        0.01,
        STREAM,
        &format!("{discs}{ends}[output]\nfigures = false\n[time]\n{time}\n{more}"),
    )
    .replace("[output]\nfigures = false\n[time]", "[time]")
}

fn write(dir: &Path, text: &str) -> std::path::PathBuf {
    std::fs::write(dir.join("case.toml"), text).unwrap();
    dir.join("case.toml")
}

#[test]
fn discs_leave_through_an_outflow_one_after_the_other_and_the_others_keep_their_numbers() {
    for (wall, contact) in
        [("sharp", "[contact]\n"), ("sharp", ""), ("mixing", "[contact]\n"), ("mixing", "")]
    {
        let dir = tempfile::tempdir().unwrap();
        let case = write(
            dir.path(),
            &carried("end = 1.0\nstep = 0.005", &format!("{contact}[coupling]\nwall = \"{wall}\"")),
        );
        let out = dir.path().join("out");
        let found = run(&case, &out, &[]);
        let left = std::fs::read_to_string(out.join("passages.csv")).unwrap();
        let ids: Vec<&str> =
            left.lines().skip(1).map(|line| line.split(',').nth(2).unwrap()).collect();
        assert_eq!(ids, ["0", "2"], "{wall}: {left}");
        let mass: f64 = left.lines().nth(1).unwrap().split(',').nth(4).unwrap().parse().unwrap();
        assert!((mass / (1.5 * 0.25 * std::f64::consts::PI * 0.09) - 1.0).abs() < 1e-12);
        let rows = columns(&out.join("particles.csv"));
        let count = |step: f64| rows["step"].iter().filter(|s| **s == step).count();
        assert_eq!((count(0.0), count(120.0), count(200.0)), (4, 3, 2), "{wall}");
        // The second one goes on with the stream, and measures know it by its number.
        let end = rows["x"][rows["id"].iter().rposition(|id| *id == 1.0).unwrap()];
        assert!((1.3..1.5).contains(&end), "{wall}: {end} m");
        // JSON's reader may miss the last bit.
        assert!(
            (found["measures"]["last"].as_f64().unwrap() - end).abs() < 1e-14 * end.abs().max(1.0),
            "{wall}"
        );
        // Nothing is missing in the balance of any step, and nothing was gained.
        let steps = columns(&out.join("steps.csv"));
        assert!(steps["momentum_error"].iter().all(|e| *e < 1e-11), "{wall}");
        assert!(
            steps["method_loss"].iter().all(|e| e.abs() < 0.1),
            "{wall}: {:?}",
            steps["method_loss"]
        );
        // A measure of what has left is that of the time when it was there.
        assert!(
            (found["measures"]["first"].as_f64().unwrap() - 1.0).abs() < 0.1,
            "{wall}: {found}"
        );
        if wall == "mixing" && contact.is_empty() {
            let shown = mics(&["plot", out.to_str().unwrap()]);
            assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
        }
    }
}

#[test]
fn a_run_that_bodies_have_left_goes_on_byte_for_byte_and_on_ranks() {
    let dir = tempfile::tempdir().unwrap();
    let text =
        carried("end = 1.0\nstep = 0.005", "[contact]\n[pressure]\ndivergence_limit = 1e-9\n");
    let case = write(dir.path(), &text);
    let [through, broken, shared] =
        ["through", "broken", "shared"].map(|name| dir.path().join(name));
    run(&case, &through, &[]);
    run(&case, &broken, &["--set", "time.end=0.7"]);
    let on = mics(&[
        "run",
        case.to_str().unwrap(),
        "--out",
        broken.to_str().unwrap(),
        "--resume",
        "--quiet",
    ]);
    assert!(on.status.success(), "{}", String::from_utf8_lossy(&on.stderr));
    for file in ["particles.csv", "passages.csv"] {
        let [a, b] = [&through, &broken].map(|out| std::fs::read(out.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
    let ranks = mpirun(2, env!("CARGO_BIN_EXE_mics"))
        .args(["run", case.to_str().unwrap(), "--quiet", "--out", shared.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(ranks.status.success(), "{}", String::from_utf8_lossy(&ranks.stderr));
    summary(&shared);
    let [a, b] = [&through, &shared].map(|out| columns(&out.join("particles.csv")));
    assert_eq!(a["id"], b["id"]);
    let apart = a["x"].iter().zip(&b["x"]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart} m");
    // A case can begin where it ended, with those that were left.
    let next =
        carried("end = 0.1\nstep = 0.005", &format!("[contact]\n[initial]\nfrom = {through:?}\n"));
    let next = next.split("[[particle]]").next().unwrap().to_owned()
        + &next[next.find("[time]").unwrap()..].replace("[[measure]]", "#");
    run(&write(dir.path(), &next), &dir.path().join("next"), &[]);
    assert_eq!(columns(&dir.path().join("next/particles.csv"))["id"][..2], [0.0, 1.0]);
}

#[test]
fn where_all_have_left_the_fluid_goes_on_alone_and_a_case_begins_with_none() {
    let dir = tempfile::tempdir().unwrap();
    let (out, next) = (dir.path().join("out"), dir.path().join("next"));
    let text = carried("end = 2.0\nstep = 0.005", "[contact]\n");
    let found = run(&write(dir.path(), &text), &out, &[]);
    let left = std::fs::read_to_string(out.join("passages.csv")).unwrap();
    assert_eq!(left.lines().count(), 5, "{left}");
    assert!((found["measures"]["first"].as_f64().unwrap() - 1.0).abs() < 0.1, "{found}");
    let alone = text.split("[[particle]]").next().unwrap().to_owned()
        + &format!("[time]\nend = 0.1\nstep = 0.005\n[initial]\nfrom = {out:?}\n");
    run(&write(dir.path(), &alone), &next, &[]);
    assert!(!next.join("particles.csv").exists());
}

#[test]
fn a_body_returns_or_ends_the_run_where_the_case_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let returns = carried(
        "end = 1.0\nstep = 0.005",
        "[contact]\n[output]\nfigures = false\nremoved = \"return\"\n",
    );
    let out = dir.path().join("out");
    run(&write(dir.path(), &returns), &out, &[]);
    let rows = columns(&out.join("particles.csv"));
    assert_eq!(rows["id"][rows["id"].len() - 4..], [0.0, 1.0, 2.0, 3.0]);
    let first = rows["x"][rows["x"].len() - 4];
    assert!((0.8..0.9).contains(&first), "{first} m");
    let stops = returns.replace("\"return\"", "\"stop\"");
    let stopped = dir.path().join("stop");
    let ended = run(&write(dir.path(), &stops), &stopped, &[]);
    let log = std::fs::read_to_string(stopped.join("log.txt")).unwrap();
    assert!(log.contains("particle 0 has reached an outflow"), "{log}");
    let time = ended["time"].as_f64().unwrap();
    assert!(
        ended["status"] == "done" && time < 1.0 && ended["measures"]["first"].as_f64().is_some(),
        "{ended}"
    );
    let times = &columns(&stopped.join("particles.csv"))["time"];
    assert!(
        times.windows(2).all(|two| two[0] <= two[1]),
        "the rows of a step come again at the end"
    );
}

/// A stream into which discs are fed, and out of which they are carried, with these tables.
fn fed(time: &str, more: &str) -> String {
    let feed = "[[swarm]]\ncount = 12\nregion = { min = [0.05, 0.0], max = [0.5, 1.0] }\n\
        diameter = { uniform = [0.2, 0.24] }\n\
                density = 1.5\nfeed = { rate = 8.0, from = 0.1 }\n[output]\nfigures = false\n\
                particles = { every = 10 }\n[contact]\n";
    box_case(
        [2.0, 1.0],
        [48, 24],
        0.01,
        STREAM,
        &format!("[time]\n{time}\nstep = 0.01\n{feed}{more}"),
    )
}

#[test]
fn discs_are_fed_into_a_stream_and_all_that_came_is_there_or_has_left_on_two_ranks_too() {
    for wall in ["sharp", "mixing"] {
        let dir = tempfile::tempdir().unwrap();
        let [out, broken] = ["out", "broken"].map(|name| dir.path().join(name));
        let text = fed(
            "end = 2.5",
            &format!("[coupling]\nwall = \"{wall}\"\n[pressure]\ndivergence_limit = 1e-8\n"),
        );
        let case = write(dir.path(), &text);
        run(&case, &out, &[]);
        let passages = columns(&out.join("passages.csv"));
        let told = std::fs::read_to_string(out.join("passages.csv")).unwrap();
        let (came, left): (Vec<_>, Vec<_>) =
            told.lines().skip(1).partition(|line| line.contains(",entered,"));
        // Twelve come in their order, 0.125 s apart, with the stream's velocity.
        assert_eq!(came.len(), 12, "{wall}: {told}");
        for (n, line) in came.iter().enumerate() {
            let number = |k: usize| line.split(',').nth(k).unwrap().parse::<f64>().unwrap();
            let due = 0.1 + 0.125 * n as f64;
            assert!(
                number(2) == n as f64 && (due..due + 0.011).contains(&number(1)),
                "{wall}: {line}"
            );
            assert!(
                (0.15..=0.4).contains(&number(6)) && (0.9..1.1).contains(&number(9)),
                "{wall}: {line}"
            );
        }
        assert!(left.len() > 2, "{told}");
        // Mass: what came less what left is there.
        let mass = |lines: &[&str]| {
            lines.iter().map(|l| l.split(',').nth(4).unwrap().parse::<f64>().unwrap()).sum::<f64>()
        };
        let rows = columns(&out.join("particles.csv"));
        let there = rows["step"].iter().filter(|step| **step == 250.0).count();
        assert_eq!(there, came.len() - left.len(), "{wall}");
        assert!(
            mass(&came) > mass(&left)
                && passages["mass"].iter().all(|m| (0.047..0.068).contains(m))
        );
        let steps = columns(&out.join("steps.csv"));
        let largest = |name: &str| steps[name].iter().fold(0.0f64, |most, e| most.max(e.abs()));
        assert!(largest("momentum_error") < 1e-11, "{wall}: {}", largest("momentum_error"));
        assert!(largest("method_loss") < 0.01, "{wall}: {}", largest("method_loss"));
        // The same in two parts, byte for byte, though bodies wait in between.
        run(&case, &broken, &["--set", "time.end=0.8"]);
        let on = mics(&[
            "run",
            case.to_str().unwrap(),
            "--out",
            broken.to_str().unwrap(),
            "--resume",
            "--quiet",
        ]);
        assert!(on.status.success(), "{}", String::from_utf8_lossy(&on.stderr));
        for file in ["particles.csv", "passages.csv"] {
            let [a, b] = [&out, &broken].map(|out| std::fs::read(out.join(file)).unwrap());
            assert!(a == b, "{wall}: {file}");
        }
        let shared = dir.path().join("shared");
        let ranks = mpirun(2, env!("CARGO_BIN_EXE_mics"))
            .args(["run", case.to_str().unwrap(), "--quiet", "--out", shared.to_str().unwrap()])
            .output()
            .unwrap();
        assert!(ranks.status.success(), "{}", String::from_utf8_lossy(&ranks.stderr));
        assert_eq!(columns(&shared.join("passages.csv"))["step"], passages["step"], "{wall}");
    }
}

#[test]
fn a_case_begins_with_the_bodies_that_were_in_the_flow_and_feeds_its_own() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    // The 15th body is due at 1.845 s, and so comes in at 1.85 s, where the run ends; 5 more wait
    // behind it.
    let before = fed("end = 1.85", "[pressure]\ndivergence_limit = 1e-8\n")
        .replace("count = 12", "count = 20")
        .replace("from = 0.1", "from = 0.095")
        .replace("every = 10", "every = 5");
    run(&write(dir.path(), &before), &at("before"), &[]);
    let (old, told) = (
        columns(&at("before/particles.csv")),
        std::fs::read_to_string(at("before/passages.csv")).unwrap(),
    );
    let there: Vec<usize> = (0..old["id"].len()).filter(|k| old["step"][*k] == 185.0).collect();
    let left = told.lines().filter(|line| line.contains(",left,")).count();
    let came = told.lines().filter(|line| line.contains(",entered,")).count();
    assert!(came == 14 && left > 0 && there.len() == came - left, "{told}");
    // Its own feed: three discs, after those that come over.
    let from = format!("[initial]\nfrom = {:?}\n", at("before"));
    let next = fed("end = 0.6", &format!("{from}[pressure]\ndivergence_limit = 1e-8\n"))
        .replace("count = 12", "count = 3")
        .replace("rate = 8.0, from = 0.1", "rate = 10.0, from = 0.045");
    let case = write(dir.path(), &next);
    run(&case, &at("next"), &[]);
    let new = columns(&at("next/particles.csv"));
    for (k, row) in there.iter().enumerate() {
        assert_eq!(new["id"][k], k as f64);
        for name in ["x", "y", "vx", "vy", "wz", "diameter", "fluid_fx"]
            .iter()
            .filter(|name| old.contains_key(**name))
        {
            assert_eq!(new[*name][k], old[*name][*row], "{name} of {k}");
        }
    }
    assert_eq!(new["step"].iter().filter(|step| **step == 0.0).count(), there.len());
    let fed = columns(&at("next/passages.csv"));
    let told = std::fs::read_to_string(at("next/passages.csv")).unwrap();
    let entered: Vec<&str> =
        told.lines().skip(1).filter(|line| line.contains(",entered,")).collect();
    assert_eq!(entered.len(), 3, "{told}");
    for (n, line) in entered.iter().enumerate() {
        assert_eq!(line.split(',').nth(2).unwrap(), (there.len() + n).to_string(), "{told}");
    }
    assert!(fed["id"].iter().all(|id| *id < (there.len() + 3) as f64));
    // Who came over, who stayed behind and who had left stands in the log.
    let log = std::fs::read_to_string(at("next/log.txt")).unwrap();
    let spoken = [
        "ended: all that lasts".to_owned(),
        format!("its particles {left} to 13 come over and are 0 to {} here", there.len() - 1),
        "6 particles that waited there to come in stay behind".to_owned(),
        format!(
            "{left} particle{} had left through an outflow there",
            if left == 1 { "" } else { "s" }
        ),
    ];
    assert!(spoken.iter().all(|words| log.contains(words)), "{spoken:?} in {log}");
    // Broken off between two that come in, it goes on byte for byte.
    run(&case, &at("broken"), &["--set", "time.end=0.2"]);
    let on = mics(&[
        "run",
        case.to_str().unwrap(),
        "--out",
        at("broken").to_str().unwrap(),
        "--resume",
        "--quiet",
    ]);
    assert!(on.status.success(), "{}", String::from_utf8_lossy(&on.stderr));
    for file in ["particles.csv", "passages.csv"] {
        let [a, b] = ["next", "broken"].map(|out| std::fs::read(at(out).join(file)).unwrap());
        assert!(a == b, "{file}");
    }
}

#[test]
fn a_body_waits_until_its_place_is_free() {
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

/// What comes in, or comes back, has its own velocity and spin, less what sets the fluid beside it
/// going: with the paper's mixing it had those of the fluid that it came into.
#[test]
fn a_body_comes_in_with_its_own_motion() {
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

/// It shares its momentum with the fluid that it sets off, at once: left to a step, a body lighter
/// than that turned back, or made energy and ended the run.
#[test]
fn a_light_body_that_comes_in_goes_on_with_its_part_of_the_momentum() {
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
        let given = steps["border_work"].last().unwrap();
        for loss in ["method_loss", "contact_loss", "viscous_loss"] {
            let least = steps[loss].iter().copied().fold(0.0, f64::min);
            assert!(least > -1e-2 * given, "s = {s} at {y} m: {loss} {least:.1e} of {given:.1e} J");
        }
    }
}

/// What returns sets the flow off anew, and the next step is as short as the first: in one as long
/// as viscosity's stages make it, ten times the body's energy was gained, and the run ended.
#[test]
fn a_light_disc_that_returns_in_a_viscous_stream_makes_no_energy() {
    let dir = tempfile::tempdir().unwrap();
    let disc = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [1.7, 0.85]\n\
        velocity = [1.0, 0.0]\ndensity = 0.08\n[contact]\n";
    let text = box_case(
        [2.0, 1.0],
        [48, 24],
        0.1,
        ["{ inflow_parabola = [1.0, 0.0] }", "\"outflow\"", "\"wall\"", "\"slip\""],
        disc,
    )
    .replace("viscosity = 0.1", "viscosity = 0.1\ngravity = [0.0, -1.0]");
    let case = write(dir.path(), &(text + "[output]\nfigures = false\nremoved = \"return\"\n"));
    let out = dir.path().join("out");
    run(&case, &out, &[]);
    let passages = columns(&out.join("passages.csv"));
    let steps = columns(&out.join("steps.csv"));
    let [time, dt, lost, fluid, body] =
        ["time", "dt", "method_loss", "fluid_energy", "bodies_energy"].map(|name| &steps[name]);
    let back = time.iter().position(|t| *t == passages["time"][0]).unwrap();
    let most = |of: &[f64]| of[back + 1..].iter().copied().fold(0.0, f64::max);
    println!(
        "steps of {} s, then {} s: {} J in the fluid before, {} J after; {} J in the disc",
        dt[back],
        dt[back + 1],
        fluid[back],
        most(fluid),
        most(body)
    );
    assert!(dt[back + 1] < 0.3 * dt[back] && dt.len() > back + 20);
    assert!(most(fluid) < 1.2 * fluid[back] && most(body) < 3.0 * body[back]);
    assert!(lost[back..].iter().all(|lost| *lost > -0.03 * fluid[back]), "{lost:?}");
}

/// A disc that weighs next to nothing between two outflows: the fluid turns it back as it returns,
/// and it went to and fro hundreds of times in one step.
#[test]
fn a_body_returns_once_in_a_step() {
    let dir = tempfile::tempdir().unwrap();
    let text = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 0.042 }} }}\nposition = [0.17, 0.33]\n\
        velocity = [0.2, 0.1]\ndensity = 0.001\n\
         [contact]\n[output]\nfigures = false\nremoved = \"return\"\n[time]\nend = 0.5\n{SHARP}"
    );
    let sides = ["\"wall\"", "\"wall\"", "\"outflow\"", "\"outflow\""];
    let case = box_case([0.34, 0.36], [34, 36], 0.005, sides, &text)
        .replace("viscosity = 0.005", "viscosity = 0.005\ngravity = [0.0, -0.5]");
    let out = dir.path().join("out");
    let case = write(dir.path(), &case);
    let said = mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--quiet"]);
    let passages = columns(&out.join("passages.csv"));
    println!("{:?}: returned in the steps {:?}", said.status.code(), passages["step"]);
    assert!(
        !passages["step"].is_empty() && passages["step"].windows(2).all(|pair| pair[0] < pair[1]),
        "{:?}",
        passages["step"]
    );
}

/// In a periodic box at rest nothing else has momentum: what comes in stays, in the cells, in
/// bodies, and in what these have not felt yet.
#[test]
fn what_comes_in_brings_its_momentum_and_no_more() {
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
fn a_ground_of_fixed_grains_has_rows_once_and_another_case_begins_with_it() {
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
fn grains_that_fall_in_while_fluid_comes_in_at_open_sides_go_on_byte_for_byte() {
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
    let on = mics(&[
        "run",
        case.to_str().unwrap(),
        "--out",
        broken.to_str().unwrap(),
        "--resume",
        "--quiet",
    ]);
    assert!(on.status.success(), "{}", String::from_utf8_lossy(&on.stderr));
    let [a, b] = [&out, &broken].map(|out| std::fs::read(out.join("particles.csv")).unwrap());
    assert!(a == b);
    // They have met the floor and each other, and the open sides have not driven the box.
    let steps = columns(&out.join("steps.csv"));
    assert!(steps["substeps"].iter().any(|n| *n > 0.0));
    let [given, taken] = ["gravity_work", "border_work"].map(|name| *steps[name].last().unwrap());
    assert!(taken.abs() < 0.05 * given, "{taken} {given}");
}
