//! Warnings of `mics check` and of a run before the first step.

use crate::estimates::{SPRINGS, fall, says};
use crate::support::{mics, run, shipped};

#[test]
fn inflow_pointing_outwards_is_warned_of() {
    let case = shipped("cases/cylinder-wake/case.toml");
    let case = case.to_str().unwrap();
    for (inflow, warned) in [("[-1.0, 0.0]", true), ("[1.0, 0.0]", false)] {
        let (code, said) =
            says(&["check", case, "--set", &format!("boundary.west.inflow={inflow}")]);
        let line =
            said.lines().find(|line| line.contains("the inflow at west leaves the box there"));
        assert!(code == Some(0) && line.is_some() == warned, "{said}");
    }
}

#[test]
fn no_slip_bodies_at_zero_viscosity_are_warned_of() {
    let dir = tempfile::tempdir().unwrap();
    let case = fall(dir.path(), SPRINGS);
    for (viscosity, warned) in [("0.0", true), ("0.05", false)] {
        let (code, said) = says(&[
            "check",
            case.to_str().unwrap(),
            "--set",
            &format!("fluid.viscosity={viscosity}"),
        ]);
        let found = said
            .lines()
            .any(|line| line.starts_with("warning      bodies are no-slip even at zero viscosity"));
        assert!(code == Some(0) && found == warned, "{said}");
    }
}

/// One stiffness holds for all: that which a body of a hundred tonnes per cubic metre asks for is
/// costly where another one weighs what water does.
#[test]
fn contact_substeps_of_unequal_masses_are_warned_of() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    for (heavy, warned) in [(1e8, true), (7800.0, false)] {
        let disc = |x: f64, density: f64| {
            format!(
                "[[particle]]\nshape.disc.diameter = 0.01\ndensity = {density:?}\n\
                position = [{x:?}, 0.02]\n"
            )
        };
        let text = format!(
            "name = \"two\"\ndomain = {{ size = [0.04, 0.04], cells = [32, 32] }}\n\
             fluid = {{ density = 1000.0, viscosity = 0.05, gravity = [0.0, -9.81] }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" \
                 }}\ncontact = {{}}\n\
             time = {{ end = 0.1 }}\n{}{}",
            disc(0.01, heavy),
            disc(0.03, 1100.0)
        );
        std::fs::write(&case, text).unwrap();
        let (code, said) = says(&["check", case.to_str().unwrap()]);
        let found = said
            .lines()
            .any(|line| line.starts_with("warning      a step in which two touch takes about "));
        assert!(code == Some(0) && found == warned, "{heavy} kg/m3: {said}");
    }
}

#[test]
fn overlap_at_start_is_warned_of() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    for (second, warned) in [(0.01495, true), (0.015, false)] {
        let disc = |y: f64| {
            format!(
                "[[particle]]\nshape.disc.diameter = 0.01\ndensity = 2650.0\n\
                position = [0.02, {y:?}]\n"
            )
        };
        let text = format!(
            "name = \"two\"\ndomain = {{ size = [0.04, 0.04], cells = [32, 32] }}\n\
             fluid = {{ density = 1000.0, viscosity = 0.05, gravity = [0.0, -9.81] }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" \
                 }}\ncontact = {{}}\n\
             time = {{ end = 0.1 }}\n{}{}",
            disc(0.005),
            disc(second)
        );
        std::fs::write(&case, text).unwrap();
        let (code, said) = says(&["check", case.to_str().unwrap()]);
        assert!(
            code == Some(0) && said.contains("particles overlap at the start") == warned,
            "{said}"
        );
    }
}

#[test]
fn check_prints_gravity_contact_laws_and_output() {
    let dir = tempfile::tempdir().unwrap();
    let laws = "contact = \
        { friction = 0.4, restitution = 0.7, pair = [{ between = [\"ice\", \"wall\"], friction = \
            0.02 }] }\n\
                output.fields = { every_time = 0.1 }";
    let case = fall(dir.path(), laws);
    let text = std::fs::read_to_string(&case)
        .unwrap()
        .replace("name = \"stone\",", "name = \"stone\", material = \"ice\",");
    std::fs::write(&case, text).unwrap();
    let (code, said) = says(&["check", case.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{said}");
    for part in [
        "viscosity 1 Pa s, gravity [0.0, -9.81] m/s2",
        "materials    ice with wall: friction 0.02, restitution 0.7",
        "materials    all other contacts: friction 0.4, restitution 0.7, normal stiffness \"auto\"",
        "output       into runs/fall, ",
        "fields every 0.1 s, 9 snapshots of ",
        "particles.csv every step, ",
        "a checkpoint every 15 minutes",
    ] {
        assert!(said.contains(part), "{part} in {said}");
    }
    let out = dir.path().join("run");
    run(&case, &out, &[]);
    let fields = std::fs::read_dir(out.join("fields")).unwrap().flatten();
    assert_eq!(
        fields.filter(|f| f.path().extension().is_some_and(|ending| ending == "vti")).count(),
        9
    );
}

#[test]
fn missing_contact_table_is_a_notice() {
    let dir = tempfile::tempdir().unwrap();
    for (more, noticed) in [("", true), (SPRINGS, false)] {
        let (code, said) = says(&["check", fall(dir.path(), more).to_str().unwrap()]);
        let line = said
            .lines()
            .find(|line| line.starts_with("notice       the case has no [contact]: the run ends"));
        assert!(code == Some(0) && line.is_some() == noticed, "{said}");
    }
}

#[test]
fn too_tight_divergence_limit_is_noted() {
    let dir = tempfile::tempdir().unwrap();
    let case = fall(dir.path(), SPRINGS);
    for (limit, named) in [("1e-9", true), ("1e-5", false), ("1e-2", false)] {
        let (code, said) = says(&[
            "check",
            case.to_str().unwrap(),
            "--set",
            &format!("pressure.divergence_limit={limit}"),
        ]);
        let line = said.lines().find(|line| {
            line.starts_with("note         pressure.divergence_limit = 1e-9 1/s is tighter")
        });
        assert!(code == Some(0) && line.is_some() == named, "{said}");
    }
}

/// A disc that falls beside a wall: steps of four stages are too long for the gap.
#[test]
fn check_warns_of_many_stages_for_body_beside_wall() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("case.toml");
    let case = |x: f64, scheme: &str| {
        let text = format!(
            "name = \"beside\"\ndomain = {{ size = [0.03, 0.06], cells = [48, 96] }}\n\
             fluid = {{ density = 1000.0, viscosity = 0.1, gravity = [0.0, -9.81] }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"periodic\", north = \
                 \"periodic\" }}\n\
             drive = {{ mean_velocity = {{ axis = \"y\", value = 0.0 }} }}\ncontact = {{}}\n\
             time = {{ end = 0.3, scheme = \"{scheme}\" }}\n\
             particle = [{{ shape = {{ disc = {{ diameter = 0.01 }} }}, position = [{x}, 0.03], \
             density = 1500.0 }}]\n"
        );
        std::fs::write(&file, text).unwrap();
        let said = mics(&["check", file.to_str().unwrap()]);
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
        String::from_utf8_lossy(&said.stdout)
            .contains("particle 0 begins 0.320 spacings from a wall")
    };
    assert!(case(0.0052, "rkl2"));
    assert!(!case(0.0052, "rk2") && !case(0.015, "rkl2"));
}

/// Twelve discs of a tenth of the box cover its section 1.2 times and are a crowd; eight are none,
/// nor are those whose step is given.
#[test]
fn default_step_of_crowd_is_long_and_check_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("case.toml");
    for (count, time, long) in [(12, "", true), (8, "", false), (12, ", cfl = 0.4", false)] {
        let text = format!(
            "name = \"crowd\"\ndomain = {{ size = [0.06, 0.06], cells = [60, 60] }}\n\
             fluid = {{ density = 1000.0, viscosity = 0.05, gravity = [0.0, -9.81] }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" \
                 }}\ncontact = {{}}\ntime = {{ end = 0.1{time} }}\n\
             swarm = [{{ count = {count}, diameter = 0.006, density = 2650.0, region = {{ min = \
                 [0.0, 0.0], max = [0.06, 0.06] }} }}]\n"
        );
        std::fs::write(&file, text).unwrap();
        let (code, said) = says(&["check", file.to_str().unwrap()]);
        let found = said.contains("are a crowd, with 1.2 times the least cross-section");
        assert!(code == Some(0) && found == long, "{count}{time}: {said}");
    }
}

/// The flow through a channel of two or three cells is far from right.
#[test]
fn channels_of_few_cells_are_warned_of() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let words = |obstacles: &[[f64; 4]]| {
        let outline = |[x, y, to_x, to_y]: &[f64; 4]| {
            format!(
                "[[obstacle]]\npolygon = {{ points = [[{x}, {y}], [{to_x}, {y}], [{to_x}, {to_y}], \
                [{x}, {to_y}]] }}\n"
            )
        };
        let text = format!(
            "name = \"channel\"\ndomain = {{ size = [1.0, 1.0], cells = [24, 24] }}\n\
            fluid = {{ density = 1.0, viscosity = 1.0 }}\n\
            boundary = {{ west = \"periodic\", east = \"periodic\", south = \"wall\", \
            north = \"wall\" }}\ntime.end = 0.1\n{}",
            obstacles.iter().map(outline).collect::<String>()
        );
        std::fs::write(&case, text).unwrap();
        let (code, said) = says(&["check", case.to_str().unwrap()]);
        assert_eq!(code, Some(0), "{said}");
        said.lines().find(|line| line.contains("the channel between")).map(str::to_owned)
    };
    let bed = [0.0, -0.2, 1.0, 0.4375];
    for (obstacles, said) in [
        (&[bed, [0.0, 0.5625, 1.0, 1.2]][..], Some(["obstacle 0 and obstacle 1", "3.0 cells"])),
        (&[bed, [0.0, 0.65, 1.0, 1.2]], None),
        // A pier that stands in the bed, and one on it.
        (&[bed, [0.3, 0.3, 0.6, 0.7]], None),
        (&[bed, [0.3, 0.4375, 0.6, 0.7]], None),
        (&[bed, [0.3, 0.3, 0.6, 0.9]], Some(["obstacle 1 and the side north", "2.4 cells"])),
    ] {
        let found = words(obstacles);
        let right = match (&found, said) {
            (Some(found), Some(said)) => said.iter().all(|part| found.contains(part)),
            (found, said) => found.is_none() && said.is_none(),
        };
        assert!(right, "{obstacles:?}: {found:?}");
    }
}

/// No film of two faces holds a plank that sinks flat in oil; in water none would.
#[test]
fn films_between_flat_faces_are_warned_of() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let plank = "polygon = { points = [[0, 0], [0.02, 0], [0.02, 0.005], [0, 0.005]] }";
    for (shape, viscosity, warned) in
        [(plank, 0.1, true), (plank, 1e-3, false), ("disc = { diameter = 0.01 }", 0.1, false)]
    {
        let text = format!(
            "name = \"plank\"\ndomain = {{ size = [0.06, 0.03], cells = [48, 24] }}\n\
            fluid = {{ density = 1000.0, viscosity = {viscosity}, gravity = [0.0, -9.81] }}\n\
            boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \
            \"wall\" }}\ncontact = {{}}\ntime.end = 0.3\n[[particle]]\nshape = {{ {shape} }}\n\
            position = [0.03, 0.0055]\ndensity = 2650.0\n"
        );
        std::fs::write(&case, text).unwrap();
        let (code, said) = says(&["check", case.to_str().unwrap()]);
        assert!(code == Some(0) && said.contains("has flat faces") == warned, "{said}");
    }
}

/// The drag of a cylinder of eight cells at Re = 100 is up to 6 % too much, and 2 % at twelve.
#[test]
fn cylinder_of_eight_cells_is_advised_twelve() {
    let case = shipped("cases/cylinder-wake/case.toml");
    let (code, said) = says(&["check", case.to_str().unwrap()]);
    assert!(code == Some(0) && said.contains(": 12 cells a diameter would resolve it"), "{said}");
}

/// A stone that shuts a passage is pressed by what no "auto" knows of: the stiffness that the
/// message names holds it.
#[test]
fn stiffness_named_when_overlap_is_too_deep_holds_the_body() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    let text = "name = \"gap\"\ndomain = { size = [2.0, 1.0], cells = [60, 30] }\n\
        fluid = { density = 1.0, viscosity = 0.02 }\n\
        boundary = { west.inflow = [1.0, 0.0], east = \"outflow\", south = \"wall\", north = \
        \"wall\" }\ncontact.friction = 0.4\ntime.end = 0.5\n\
        pressure.divergence_limit = 1.0e-6\noutput.figures = false\n\
        [[obstacle]]\npolygon.points = [[1.0, -0.1], [1.2, -0.1], [1.2, 0.35], [1.0, 0.35]]\n\
        [[obstacle]]\npolygon.points = [[1.0, 0.65], [1.2, 0.65], [1.2, 1.1], [1.0, 1.1]]\n\
        [[particle]]\nshape.polygon.points = [[0, 0], [0.38, 0], [0.4, 0.36], [0.1, 0.42]]\n\
        position = [0.7, 0.5]\ndensity = 2.65\norientation = 5.0\n";
    std::fs::write(&case, text).unwrap();
    let out = dir.path().join("run");
    let (case, out) = (case.to_str().unwrap(), out.to_str().unwrap());
    let (code, said) = says(&["run", case, "--ranks", "1", "--out", out]);
    let named = said.split("contact.normal_stiffness = ").nth(1).unwrap_or_default();
    let stiffness = named.split(' ').next().unwrap_or_default();
    assert!(code == Some(3) && !stiffness.is_empty(), "{said}");
    let set = format!("contact.normal_stiffness={stiffness}");
    let (code, said) = says(&["run", case, "--ranks", "1", "--out", out, "--force", "--set", &set]);
    assert_eq!(code, Some(0), "{said}");
}
