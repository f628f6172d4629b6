//! Free bodies that reach an outflow leave, return or end the run, and nothing of the others
//! changes.

use crate::program::write;
use crate::support::{
    SHARP, STREAM, box_case, case, columns, mics, petsc, run, run_on_ranks, summary,
};
use mics::scene::{Scene, pass_boundaries};

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

#[test]
fn discs_leave_outflow_and_ids_are_kept() {
    for (wall, contact) in [("sharp", "[contact]\n"), ("sharp", ""), ("mixing", "[contact]\n")] {
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
        if wall == "sharp" {
            assert!(steps["momentum_error"].iter().all(|e| *e < 1e-11));
        }
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
        if contact.is_empty() {
            let shown = mics(&["plot", out.to_str().unwrap()]);
            assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
        }
    }
}

#[test]
fn resume_after_bodies_left_byte_for_byte_and_on_ranks() {
    let dir = tempfile::tempdir().unwrap();
    let text =
        carried("end = 1.0\nstep = 0.005", "[contact]\n[pressure]\ndivergence_limit = 1e-9\n");
    let case = write(dir.path(), &text);
    let [through, broken, shared] =
        ["through", "broken", "shared"].map(|name| dir.path().join(name));
    run(&case, &through, &[]);
    run(&case, &broken, &["--set", "time.end=0.7"]);
    run(&case, &broken, &["--resume"]);
    for file in ["particles.csv", "passages.csv"] {
        let [a, b] = [&through, &broken].map(|out| std::fs::read(out.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
    run_on_ranks(2, &case, &shared);
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
fn run_continues_after_all_bodies_have_left() {
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
fn removed_return_and_stop_options() {
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
pub fn fed(time: &str, more: &str) -> String {
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

/// A body that moves less than what it is cut anew for is cut where it comes in again.
#[test]
fn slow_body_that_returns_is_cut_at_its_new_place() {
    let petsc = petsc();
    let more = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [1.84999, 0.5]\n\
        velocity = [1e-3, 0.0]\ndensity = 1e4\n[output]\nremoved = \"return\"\n{SHARP}"
    );
    let text = box_case([2.0, 1.0], [48, 24], 0.01, STREAM, &more);
    let mut scene: Scene<2> = petsc.scene(&text);
    scene.step(1e-3).unwrap();
    let passed = pass_boundaries(&mut scene, &case(&text), 0.01).unwrap();
    assert_eq!(
        passed.passages.iter().map(|passage| passage.what).collect::<Vec<_>>(),
        ["returned"]
    );
    let cells = scene.method.overlaps().map(|o| o.cell).collect::<Vec<_>>();
    let centre = &scene.state.bodies[0].centre;
    let far = |c: &usize| {
        let [x, y] = scene.domain.grid.centre(*c);
        (x - centre.x).hypot(y - centre.y)
    };
    assert!(!cells.is_empty() && cells.iter().all(|c| far(c) < 0.2), "{cells:?}");
}

#[test]
fn initial_from_with_feed_of_own_bodies() {
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
        "ended: the whole state, bit for bit".to_owned(),
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
    run(&case, &at("broken"), &["--resume"]);
    for file in ["particles.csv", "passages.csv"] {
        let [a, b] = ["next", "broken"].map(|out| std::fs::read(at(out).join(file)).unwrap());
        assert!(a == b, "{file}");
    }
}

/// A body that returns sets the flow off anew, and the next step is as short as the first: in one
/// as long as viscosity's stages make it, ten times its energy was gained, and the run ended.
#[test]
fn returning_light_disc_has_no_energy_gain() {
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
fn body_returns_at_most_once_per_step() {
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
