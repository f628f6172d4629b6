//! Estimates of `mics check`, and what it and a run say alike before the first step.

use crate::support::{columns, mics, run, shipped};
use std::path::{Path, PathBuf};

/// A stone that falls in a box of water of 64 x 32 cells, with these further keys.
pub fn fall(folder: &Path, more: &str) -> PathBuf {
    let text = format!(
        "name = \"fall\"\ntime.end = 0.8\noutput.figures = false\n\
        pressure.divergence_limit = 1e-2\n\
         domain = {{ size = [2.0, 1.0], cells = [64, 32] }}\n\
         fluid = {{ density = 1000.0, viscosity = 1.0, gravity = [0.0, -9.81] }}\n\
         boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
         particle = [{{ name = \"stone\", shape = {{ disc = {{ diameter = 0.25 }} }}, density = \
             2650.0, position = [0.7, 0.7] }}]\n{more}\n"
    );
    let file = folder.join("fall.toml");
    std::fs::write(&file, text).unwrap();
    file
}

pub const SPRINGS: &str = "contact = { friction = 0.4 }";

/// The exit status of a command, and what it says on both channels.
pub fn says(words: &[&str]) -> (Option<i32>, String) {
    let output = mics(words);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout) + &text(&output.stderr))
}

#[test]
fn check_counts_steps_by_the_first_one() {
    let dir = tempfile::tempdir().unwrap();
    let case = fall(dir.path(), SPRINGS);
    let case = case.to_str().unwrap();
    let line = |set: &[&str]| {
        let (code, said) = says(&[&["check", case], set].concat());
        assert_eq!(code, Some(0), "{said}");
        said.lines().find(|line| line.starts_with("step  ")).unwrap().to_owned()
    };
    let given = line(&["--set", "time.step=0.003"]);
    assert!(given.contains("3.0000e-3 s, given; 267 steps of this length to t = 0.8 s"), "{given}");
    let chosen = line(&[]);
    let words: Vec<&str> = chosen.split_whitespace().collect();
    let dt: f64 = words[1].parse().unwrap();
    let at = words.iter().position(|word| *word == "steps").unwrap();
    let count: f64 = words[at - 1].parse().unwrap();
    assert!(chosen.contains(" s at the start, ") && (count - 0.8 / dt).abs() <= 1.0, "{chosen}");
    let out = dir.path().join("out");
    run(Path::new(case), &out, &[]);
    let first = columns(&out.join("steps.csv"))["dt"][1];
    assert!((dt / first - 1.0).abs() < 1e-4, "{first} s: {chosen}");
}

#[test]
fn unresolved_boundary_layer_is_warned_of_with_cells_needed() {
    let dir = tempfile::tempdir().unwrap();
    let water = "fluid.viscosity=1e-6";
    let cavity = shipped("cases/lid-driven-cavity/case.toml");
    for (case, set, end, expected) in [
        // Re = 5.9e8: 1.2 d/sqrt(Re) of the fall's; the walls' L/sqrt(Re) at 1e7.
        (
            fall(dir.path(), SPRINGS),
            water,
            "time.end=0.01",
            ["cells a diameter", "and there are 8.0; so large"],
        ),
        (
            cavity,
            "fluid.viscosity=1e-7",
            "time.end=0.005",
            ["3163 cells along", "and there are 128; so large"],
        ),
    ] {
        let case = case.to_str().unwrap();
        let (code, said) = says(&["check", case, "--set", set, "--set", end]);
        let line = said
            .lines()
            .find(|line| line.starts_with("warning      the boundary layer of "))
            .unwrap_or_default();
        assert!(code == Some(0) && expected.iter().all(|part| line.contains(part)), "{said}");
        assert!(line.contains("fluid.viscosity is dynamic, in Pa s"), "{line}");
        let out = dir.path().join("run");
        run(
            Path::new(case),
            &out,
            &["--force", "--set", set, "--set", end, "--set", "output.figures=false"],
        );
        let log = std::fs::read_to_string(out.join("log.txt")).unwrap();
        assert!(log.lines().any(|said| said == line), "{log}");
    }
}

/// A disc of 1 cm that is told to move ends its run at the wall, at a fixed disc or at another one,
/// and where its path is free or the run ends before, it does not.
#[test]
fn collision_time_of_prescribed_body_is_estimated() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let disc = |x: f64, motion: &str| {
        format!(
            "[[particle]]\nshape.disc.diameter = 0.01\nposition = [{x:?}, 0.02]\n\
            motion = {motion}\n"
        )
    };
    let goes = |velocity: [f64; 2]| format!("{{ prescribed = {{ velocity = {velocity:?} }} }}");
    let swings = |amplitude: f64| {
        format!(
            "{{ prescribed = {{ oscillation = {{ amplitude = [{amplitude:?}, 0.0], frequency = \
                2.5 }} }} }}"
        )
    };
    // 1.5 cm to the wall; 2 cm between two surfaces.
    for (discs, end, expected) in [
        (
            disc(0.02, &goes([0.0, 0.05])),
            0.4,
            Some((0.3, "particle 0 has reached the boundary of the box along y")),
        ),
        (disc(0.02, &goes([0.0, 0.05])), 0.29, None),
        (
            disc(0.02, &goes([0.05, 0.0])) + &disc(0.05, "\"fixed\""),
            0.45,
            Some((0.4, "particle 0 has run into particle 1")),
        ),
        (disc(0.02, &goes([0.05, 0.0])) + &disc(0.05, "\"free\""), 0.45, None),
        // Across the boundary in x.
        (
            disc(0.01, &goes([-0.1, 0.0])) + &disc(0.06, &goes([0.1, 0.0])),
            0.2,
            Some((0.1, "particle 1 has run into particle 0")),
        ),
        (
            disc(0.02, &swings(0.021)) + &disc(0.05, "\"fixed\""),
            0.2,
            Some((0.0804, "particle 0 has run into particle 1")),
        ),
        (disc(0.02, &swings(0.019)) + &disc(0.05, "\"fixed\""), 0.2, None),
    ] {
        let text = format!(
            "name = \"told\"\ndomain = {{ size = [0.08, 0.04], cells = [64, 32] }}\n\
            fluid = {{ density = 1000.0, viscosity = 0.05 }}\n\
             boundary = {{ west = \"periodic\", east = \"periodic\", south = \"wall\", north = \
                 \"wall\" }}\n\
             contact = {{}}\noutput.figures = false\ntime = {{ end = {end:?} }}\n{discs}"
        );
        std::fs::write(&case, text).unwrap();
        let (code, said) = says(&["check", case.to_str().unwrap()]);
        let line =
            said.lines().find(|line| line.starts_with("warning      the run will end at t = "));
        assert!(code == Some(0) && line.is_some() == expected.is_some(), "{said}");
        let (Some(line), Some((time, words))) = (line, expected) else { continue };
        let told: f64 = line.split(' ').find_map(|word| word.parse().ok()).unwrap();
        assert!(line.contains(words) && (told - time).abs() < 0.003, "{time}: {line}");
        let out = dir.path().join("out");
        let (code, said) =
            says(&["run", case.to_str().unwrap(), "--force", "--out", out.to_str().unwrap()]);
        assert!(
            code == Some(3) && said.contains(line) && said.contains("error: step"),
            "{code:?}: {said}"
        );
    }
}

#[test]
fn check_and_run_agree_on_bad_contact_stiffness() {
    let dir = tempfile::tempdir().unwrap();
    let case = fall(dir.path(), SPRINGS);
    let out = dir.path().join("out");
    let [case, out] = [&case, &out].map(|path| path.to_str().unwrap());
    // A soft contact takes a while to give way.
    let end = "time.end=1.4";
    let both = |stiffness: &str| {
        let set = format!("contact.normal_stiffness={stiffness}");
        [
            &["check", case, "--set", &set, "--set", end][..],
            &["run", case, "--set", &set, "--set", end, "--force", "--out", out],
        ]
        .map(says)
    };
    let refused = both("1e19");
    for (code, said) in &refused {
        assert_eq!(*code, Some(2), "{said}");
        assert!(
            said.contains("contact.normal_stiffness: 1e19 N/m^exponent is too stiff")
                && said.contains("\"auto\" takes"),
            "{said}"
        );
    }
    assert_eq!(refused[0].1, refused[1].1);
    assert!(!Path::new(out).exists(), "nothing is written");
    for (stiffness, warning, code) in [
        ("1e13", "stiffer than the impacts ask for", 0),
        ("1e3", "normal_stiffness is too small: an impact at", 3),
    ] {
        let [check, run] = both(stiffness);
        let line = |said: &str| said.lines().find(|line| line.contains(warning)).map(str::to_owned);
        assert!(check.0 == Some(0) && line(&check.1).is_some(), "{stiffness}: {}", check.1);
        assert_eq!((run.0, line(&run.1)), (Some(code), line(&check.1)), "{stiffness}: {}", run.1);
    }
    // The stiffness that the failing run asks for holds.
    let (_, said) = &both("1e3")[1];
    let asked =
        said.split("contact.normal_stiffness = ").nth(1).unwrap().split(' ').next().unwrap();
    assert_eq!(both(asked)[1].0, Some(0), "{asked}");
}

/// The substeps that `mics check` finds before the stone touches the floor are those of a run in
/// which it lies there; it says nothing of a body that nothing can touch.
#[test]
fn check_measures_contacts_before_bodies_touch() {
    let dir = tempfile::tempdir().unwrap();
    let case = fall(dir.path(), SPRINGS);
    let (code, said) = says(&["check", case.to_str().unwrap(), "--set", "time.step=0.002"]);
    let line = said.lines().find(|line| line.starts_with("contacts   ")).unwrap_or_else(|| {
        panic!("{said}");
    });
    assert!(code == Some(0) && line.contains("1 of 1 free bodies touch"), "{said}");
    let words: Vec<&str> = line.split(' ').collect();
    let before = |word: &str| -> f64 {
        let at = words.iter().position(|found| found.starts_with(word)).unwrap();
        words[at - 1].parse().unwrap()
    };
    assert!(before("substeps") > 0.0 && before("us") >= 0.0, "{line}");
    let cost = said.lines().find(|line| line.starts_with("cost")).unwrap();
    assert!(cost.contains(" ms a step with contacts ("), "{cost}");

    let out = dir.path().join("run");
    let lies = "particle.0.position=[0.7, 0.12499]";
    run(&case, &out, &["--set", lies, "--set", "time.step=0.002", "--set", "time.end=0.04"]);
    let substeps = *columns(&out.join("steps.csv"))["substeps"].last().unwrap();
    println!("{line}: a run takes {substeps} substeps");
    assert!((0.5..2.0).contains(&(before("substeps") / substeps)), "{line}, {substeps}");

    let open =
        ["west", "east", "south", "north"].map(|side| format!("boundary.{side}=\"periodic\""));
    let sets = open.iter().flat_map(|set| ["--set", set]);
    let words: Vec<&str> = ["check", case.to_str().unwrap()].into_iter().chain(sets).collect();
    let (code, said) = says(&words);
    assert_eq!(code, Some(0), "{said}");
    let speaks = |line: &str| line.starts_with("contacts   ") || line.contains("with contacts");
    assert!(!said.lines().any(speaks), "{said}");
}

/// Disk space that `mics check` estimates, beside what the run has left there.
#[test]
fn check_estimates_disk_space() {
    let dir = tempfile::tempdir().unwrap();
    let more = "output.fields = { every = 20 }\noutput.particles = { every = 1 }\n\
        output.checkpoint = { every_steps = 30 }\ntime.step = 0.002";
    let case = fall(dir.path(), more);
    let (code, said) = says(&["check", case.to_str().unwrap(), "--set", "time.end=0.2"]);
    assert_eq!(code, Some(0), "{said}");
    let cost = said.lines().find(|line| line.starts_with("cost")).unwrap();
    let words: Vec<&str> = cost.rsplit("; ").next().unwrap().split(' ').collect();
    assert_eq!(words[1..], ["MB", "of", "disk", "at", "most"], "{cost}");
    let out = dir.path().join("run");
    run(&case, &out, &["--set", "time.end=0.2"]);
    fn size(path: &std::path::Path) -> u64 {
        let entries = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap());
        entries
            .map(|e| if e.path().is_dir() { size(&e.path()) } else { e.metadata().unwrap().len() })
            .sum()
    }
    let said = words[0].parse::<f64>().unwrap();
    let left = 1e-6 * size(&out) as f64;
    assert!((0.6..1.0).contains(&(left / said)), "{said} MB said, {left} MB left");
}

#[test]
fn a_free_body_that_a_locked_axis_drives_into_a_boundary_is_foreseen() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let foreseen = |east: &str, end: f64| {
        let sides = ["\"wall\"", east, "\"wall\"", "\"wall\""];
        let more = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.2 }} }}\nposition = [0.5, 0.5]\n\
            density = 2.0\n\
             velocity = [0.1, 0.0]\nlocked = [\"x\"]\n[contact]\n[time]\nend = {end:?}\n\
                 step = 0.01\n"
        );
        std::fs::write(&case, crate::support::box_case([1.0, 1.0], [40, 40], 0.01, sides, &more))
            .unwrap();
        let (code, said) = says(&["check", case.to_str().unwrap()]);
        assert_eq!(code, Some(0), "{said}");
        said.contains("the run will end soon after t = 4.000 s")
            && said.contains("into the east boundary")
    };
    // 0.4 m to the boundary at 0.1 m/s.
    assert!(foreseen("\"wall\"", 5.0));
    assert!(!foreseen("\"wall\"", 3.9));
    assert!(!foreseen("\"outflow\"", 5.0));
}

/// Millimetres taken for metres.
#[test]
fn particle_below_one_cell_is_refused_before_stiffness() {
    let dir = tempfile::tempdir().unwrap();
    for stiffness in ["1e5", "1e14", "\"auto\""] {
        let case = fall(dir.path(), &format!("contact = {{ normal_stiffness = {stiffness} }}"));
        let case = case.to_str().unwrap();
        let out = dir.path().join("out");
        for words in [&["check", case][..], &["run", case, "--out", out.to_str().unwrap()]] {
            let (code, said) = says(&[words, &["--set", "domain.size=[2000.0, 1000.0]"]].concat());
            assert_eq!(code, Some(2), "{said}");
            assert!(
                said.contains("domain.size: the smallest particle is 8.00e-3 cells across"),
                "{said}"
            );
            assert!(said.contains("in another unit") && !said.contains("stiff"), "{said}");
        }
        assert!(!out.exists());
    }
}
