//! The shipped cases: each is read, checked and stepped, and each has its page and its picture.

use crate::support::{box_case, mics, run, shipped};
use std::path::PathBuf;

/// Every `*.toml` under cases/, studies aside.
fn cases() -> Vec<PathBuf> {
    let folders = std::fs::read_dir(shipped("cases"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_dir());
    let files = folders
        .flat_map(|f| std::fs::read_dir(f).unwrap().map(|e| e.unwrap().path()).collect::<Vec<_>>());
    let is_case = |p: &PathBuf| {
        p.extension().is_some_and(|e| e == "toml") && !p.to_string_lossy().contains(".study.")
    };
    files.filter(is_case).collect()
}

#[test]
fn shipped_cases_take_first_steps() {
    let all = cases();
    assert!(all.len() >= 3);
    for case in all {
        let output = mics(&["check", case.to_str().unwrap()]);
        let (said, error) =
            (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "{}: {error}", case.display());
        // A fall at thousands of Reynolds numbers is shipped with the warning that its layer is
        // thin.
        let warns = said
            .lines()
            .any(|line| line.starts_with("warning") && !line.contains("is thinner than a spacing"));
        assert!(said.contains("ms a step") && !warns, "{}: {said}", case.display());
        assert!(case.with_file_name("README.md").exists(), "{} has no page", case.display());
    }
}

#[test]
fn contact_pair_materials_from_initial_run() {
    let dir = tempfile::tempdir().unwrap();
    let closed = ["\"wall\""; 4];
    let stone = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.5, 0.5]\n\
        density = 2.0\nmaterial = \"stone\"\n";
    let time = "[time]\nend = 0.02\nstep = 0.01\n[output]\nfigures = false\n[contact]\n";
    let text = |more: &str| box_case([1.0, 1.0], [20, 20], 0.01, closed, &format!("{more}{time}"));
    let (first, next, out) =
        (dir.path().join("pour.toml"), dir.path().join("tilt.toml"), dir.path().join("pour"));
    std::fs::write(&first, text(stone)).unwrap();
    run(&first, &out, &[]);
    let pair = |name: &str| {
        format!("[[contact.pair]]\nbetween = [\"{name}\", \"wall\"]\nfriction = 0.9\n")
    };
    let lists =
        format!("[[swarm]]\nfrom = \"{}\"\ndensity = 2.0\n", out.join("particles.csv").display());
    for brings in [format!("[initial]\nfrom = \"{}\"\n", out.display()), lists] {
        std::fs::write(&next, text(&brings) + &pair("stone")).unwrap();
        let said = mics(&["check", next.to_str().unwrap()]);
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
        let doubled = "note         this file adds 1 to the 1 that come from that run";
        let other = stone.replace("[0.5, 0.5]", "[0.2, 0.2]");
        std::fs::write(&next, text(&(brings.clone() + &other)) + &pair("stone")).unwrap();
        let said =
            String::from_utf8_lossy(&mics(&["check", next.to_str().unwrap()]).stdout).into_owned();
        let count = usize::from(brings.contains("[initial]"));
        assert_eq!(said.matches(doubled).count(), count, "{said}");
        std::fs::write(&next, text(&brings) + &pair("stane")).unwrap();
        let said = mics(&["check", next.to_str().unwrap()]);
        let error = String::from_utf8_lossy(&said.stderr);
        assert!(error.contains("known here: \"default\", \"stone\", \"wall\""), "{error}");
    }
}

#[test]
fn too_small_contact_stiffness_is_warned_of() {
    let case = shipped("cases/steel-in-air/case.toml");
    for (stiffness, warns) in [("1e3", true), ("1e7", false), ("\"auto\"", false)] {
        let set = format!("contact.normal_stiffness={stiffness}");
        let output = mics(&["check", case.to_str().unwrap(), "--set", &set]);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(
            said.contains("normal_stiffness is too small: an impact at"),
            warns,
            "{stiffness}: {said}"
        );
    }
}

#[test]
fn steel_in_air_keeps_d0_while_it_falls() {
    let dir = tempfile::tempdir().unwrap();
    let short = ["--set", "time.end=0.02", "--set", "output.figures=false"];
    let summary = run(&shipped("cases/steel-in-air/case.toml"), dir.path(), &short);
    assert_eq!(summary["status"], "done");
    assert_eq!(summary["solver_retries"], 0);
}
