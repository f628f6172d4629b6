//! Runs that start where another one ended (`initial.from`).

use crate::restart::{said, words};
use crate::support::{columns, mics, run};
use mics_run::snapshot::Snapshot;
use std::path::Path;

/// A bed of discs that lands, in a box whose lid stands still or moves (m/s), of so many cells a
/// side, with these keys in place of its swarm.
fn bed(lid: f64, cells: usize, time: &str, more: &str) -> String {
    format!(
        "name = \"bed\"\ndomain = {{ size = [1.2, 1.2], cells = [{cells}, {cells}] }}\n\
         fluid = {{ density = 1000.0, viscosity = 1.0, gravity = [0.0, -9.81] }}\n\
         contact = {{ friction = 0.3 }}\n\
         time = {{ {time} }}\npressure = {{ divergence_limit = 1e-4 }}\n\
         output = {{ figures = false, particles = {{ every = 1 }}, checkpoint = {{ every_steps = \
         20 }} }}\n\
         boundary = {{ west = \"periodic\", east = \"periodic\", south = \"wall\", north = \
             {{ moving_wall = [{lid:?}, 0.0] }} }}\n{more}"
    )
}

#[test]
fn initial_from_continues_a_run_byte_for_byte() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let write = |name: &str, text: &str| {
        std::fs::write(at(name), text).unwrap();
        at(name)
    };
    let swarm = "[[swarm]]\ncount = 6\nregion = { min = [0.0, 0.0], max = [1.2, 0.45] }\n\
        diameter = 0.2\ndensity = 2000.0\n";
    run(&write("settle.toml", &bed(0.0, 36, "end = 0.8, cfl = 0.4", swarm)), &at("settled"), &[]);
    let from = format!("[initial]\nfrom = {:?}\n", at("settled"));
    let shear = write("shear.toml", &bed(0.5, 36, "end = 0.2, step = 4e-3", &from));
    run(&shear, &at("sheared"), &[]);
    // The bodies are where they were, and press on each other and on the floor as they did: nothing
    // jumps.
    let (settled, sheared) =
        (columns(&at("settled/particles.csv")), columns(&at("sheared/particles.csv")));
    for name in ["x", "y", "vx", "vy", "wz", "fluid_fx"] {
        let last = &settled[name][settled[name].len() - 6..];
        assert_eq!(last, &sheared[name][..6], "{name}");
    }
    let (last, first) =
        (&settled["contact_fy"][settled["contact_fy"].len() - 6..], &sheared["contact_fy"][6..12]);
    let (load, next): (f64, f64) = (last.iter().sum(), first.iter().sum());
    assert!(
        load > 0.0 && (next / load - 1.0).abs() < 0.2,
        "contacts carried {load} N, and now {next} N"
    );
    // Broken off and gone on with, the run gives the same.
    let out = at("again");
    let stopped = mics(&words(&shear, &out, &["--set", "time.end=0.1", "--quiet"]));
    assert!(stopped.status.success(), "{}", said(&stopped));
    let on = mics(&words(&shear, &out, &["--resume", "--quiet"]));
    assert!(on.status.success(), "{}", said(&on));
    let rows = |run: &Path| std::fs::read(run.join("particles.csv")).unwrap();
    assert!(rows(&at("sheared")) == rows(&out));
    let last = |run: &Path| Snapshot::read(&run.join("fields/00000050.vti")).unwrap();
    assert_eq!(last(&at("sheared")), last(&out));
    // On another grid the velocity is interpolated, and the bodies are the same; as ground they
    // stay.
    let finer = write("finer.toml", &bed(0.5, 42, "end = 0.02, step = 4e-3", &from));
    run(&finer, &at("finer"), &[]);
    assert_eq!(columns(&at("finer/particles.csv"))["x"][..6], sheared["x"][..6]);
    let ground =
        format!("[[swarm]]\nfrom = {:?}\nmotion = \"fixed\"\n", at("settled/particles.csv"));
    run(
        &write("ground.toml", &bed(0.5, 36, "end = 0.02, step = 4e-3", &ground)),
        &at("ground"),
        &[],
    );
    let lies = columns(&at("ground/particles.csv"));
    assert_eq!(lies["x"][lies["x"].len() - 6..], sheared["x"][..6]);
    // Runs that a case cannot begin from are refused.
    let refused = |text: &str, why: &str| {
        let output = mics(&words(&write("bad.toml", text), &at("bad"), &[]));
        let words = said(&output);
        assert!(
            output.status.code() == Some(2)
                && words.contains("initial.from")
                && words.contains(why),
            "{words}"
        );
        assert!(!at("bad").exists());
    };
    let good = bed(0.5, 36, "end = 0.2, step = 4e-3", &from);
    refused(&good.replace("settled", "nowhere"), "holds no run");
    refused(
        &good.replace("[initial]\n", "[initial]\nvelocity = [1.0, 0.0]\n"),
        "remove initial.velocity",
    );
    refused(&good.replace("size = [1.2, 1.2]", "size = [1.2, 0.15]"), "outside");
    std::fs::remove_file(at("settled/summary.json")).unwrap();
    refused(&good, "has not ended");
}

/// The drive that holds a mean velocity and the faces of the step before are what they were; "auto"
/// would take the springs from the speeds there.
#[test]
fn initial_from_continues_a_driven_run() {
    let dir = tempfile::tempdir().unwrap();
    for (name, drive) in [
        ("held", "mean_velocity = { axis = \"x\", value = 0.05 }"),
        ("driven", "force = [400.0, 0.0]"),
    ] {
        let at = |part: &str| dir.path().join(format!("{name}-{part}"));
        let go = |part: &str, end: f64, more: &str| {
            let discs: String = [(0.0101, 0.0112), (0.0043, 0.0034)]
                .iter()
                .map(|(x, y)| {
                    format!(
                        "[[particle]]\nshape.disc.diameter = 0.006\ndensity = 2650.0\n\
                        position = [{x}, {y}]\n"
                    )
                })
                .collect();
            let text = format!(
                "name = \"part\"\ndomain = {{ size = [0.02, 0.02], cells = [20, 20] }}\n\
                 fluid = {{ density = 1000.0, viscosity = 0.05, gravity = [0.0, -9.81] }}\n\
                 boundary = {{ west = \"periodic\", east = \"periodic\", south = \"wall\", north = \
                     \"wall\" }}\n\
                 contact = {{ friction = 0.3, normal_stiffness = 1e4 }}\n\
                 pressure = {{ divergence_limit = 1e-9 }}\ndrive = {{ {drive} }}\n\
                 time = {{ end = {end:?}, step = 5e-4 }}\n\
                 output = {{ figures = false, particles = {{ every = 1 }} }}\n{}",
                if more.is_empty() { &discs } else { more }
            );
            let case = at(&format!("{part}.toml"));
            std::fs::write(&case, text).unwrap();
            run(&case, &at(part), &[]);
            (columns(&at(part).join("particles.csv")), columns(&at(part).join("steps.csv")))
        };
        go("first", 0.02, "");
        let (second, forces) =
            go("second", 0.01, &format!("[initial]\nfrom = {:?}\n", at("first")));
        let (whole, all) = go("whole", 0.03, "");
        assert!(whole["contact_fy"].iter().any(|force| *force != 0.0), "{name}: they touch");
        for column in ["x", "y", "vx", "vy", "wz", "contact_fy"] {
            assert_eq!(second[column][2..], whole[column][2 * 41..], "{name}: {column}");
        }
        assert_eq!(forces["drive_fx"], all["drive_fx"][40..], "{name}");
    }
}
