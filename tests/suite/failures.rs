//! Runs that cannot go on: step, place and cause are named, and the last good state is kept.

use crate::program::{text, write};
use crate::support::{MIXING, SHARP, STREAM, box_case, columns, mics, petsc};
use mics::Error;
use mics::error::NotFinite;
use mics::scene::Scene;

#[test]
fn divergence_limit_below_rounding_names_last_good_state() {
    let dir = tempfile::tempdir().unwrap();
    let more = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.6, 0.5]\n\
                motion = { prescribed = { velocity = [0.4, 0.0] } }\n[coupling]\n\
                wall = \"sharp\"\n";
    let case = write(dir.path(), &box_case([2.0, 1.0], [64, 32], 0.01, STREAM, more));
    let out = dir.path().join("run");
    let words = ["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--set"];
    let output = mics(&[&words[..], &["pressure.divergence_limit=1e-15"]].concat());
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("C-HSMAC reached max |D|") || said.contains("the pressure solve failed"),
        "{said}"
    );
    assert!(!out.exists(), "the very first projection failed: nothing is written");
}

#[test]
fn fixed_step_over_stability_limit_stops_run() {
    let dir = tempfile::tempdir().unwrap();
    let more = "[initial]\nvelocity = [0.0, 0.0]\n[[particle]]\n\
        shape = { disc = { diameter = 0.3 } }\nposition = [0.6, 0.5]\n\
                motion = \"fixed\"\n[coupling]\nwall = \"mixing\"\n[time]\nend = 1.0\n\
                    step = 0.0155";
    let case = write(dir.path(), &box_case([2.0, 1.0], [64, 32], 0.001, STREAM, more));
    let out = dir.path().join("run");
    let output = mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("over the advection limit")
            && said.contains("step ")
            && said.contains("the last good state"),
        "{said}"
    );
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("\"failed\""), "{summary}");
    // The state that the refused step began with is the one kept, and its rows are written.
    let name = said[said.find("fields/").unwrap() + 7..].trim();
    let kept = mics_run::snapshot::Snapshot::read(&out.join("fields").join(name)).unwrap();
    let rows = columns(&out.join("steps.csv"));
    assert!(
        kept.time > 0.0 && kept.time == *rows["time"].last().unwrap(),
        "{} of {:?}",
        kept.time,
        rows["time"]
    );
}

#[test]
fn nan_stops_the_step_with_its_cell() {
    let petsc = petsc();
    let mut scene: Scene<2> = petsc.scene(&box_case([2.0, 1.0], [32, 16], 0.01, STREAM, ""));
    scene.step(0.01).unwrap();
    let cell = scene.domain.grid.owned_index([7, 3]).unwrap();
    scene.state.u[1][cell] = f64::NAN;
    let error = scene.step(0.01).unwrap_err();
    assert!(
        matches!(
            &error,
            Error::NotFinite(NotFinite::Cell { field, .. }) if field.contains("velocity")
        ),
        "{error}"
    );
    let error = scene.energy_and_speed().unwrap_err();
    assert_eq!(error.exit_code(), 3);
}

#[test]
fn lost_particle_stops_the_step() {
    let petsc = petsc();
    let disc = |x: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, 0.5]\n\
            density = 2.0\n"
        )
    };
    for wall in [SHARP, MIXING] {
        let more = [&disc(0.5), &disc(1.2), "[contact]\nnormal_stiffness = 100.0\n", wall].concat();
        let mut scene: Scene<2> = petsc.scene(&box_case([2.0, 1.0], [32, 16], 0.01, STREAM, &more));
        scene.step(0.01).unwrap();
        let lost = scene.state.bodies.iter_mut().find(|body| body.id == 1);
        lost.unwrap().velocity.y = f64::INFINITY;
        let error = scene.step(0.01).unwrap_err();
        assert!(matches!(error, Error::NotFinite(NotFinite::Particle(1))), "{wall}: {error}");
        assert!(
            error.to_string().contains("particle 1 is not a finite number")
                && error.exit_code() == 3,
            "{error}"
        );
    }
}

#[test]
fn overflowing_flow_exits_with_3_and_names_place() {
    let dir = tempfile::tempdir().unwrap();
    let case =
        write(dir.path(), &box_case([1.0, 1.0], [16, 16], 0.01, crate::support::PERIODIC, ""));
    let out = dir.path().join("run");
    let words = ["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--set"];
    let output =
        mics(&[&words[..], &["fluid.density=1e-300", "--set", "drive.force=[1e30,0.0]"]].concat());
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("not a finite number"), "{}", text(&output.stderr));
}

/// A law of contacts does not move what moves as told.
#[test]
fn colliding_or_leaving_prescribed_bodies_stop_run() {
    const LAW: &str = "[[particle]]\nshape = { disc = { diameter = 0.2 } }\n\
        position = [1.6, 0.2]\n[contact]\nnormal_stiffness = 100.0\n";
    let dir = tempfile::tempdir().unwrap();
    let moving = |x: f64, v: [f64; 2]| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, 0.5]\n\
             motion = {{ prescribed = {{ velocity = {v:?} }} }}\n"
        )
    };
    let meeting = || moving(0.6, [1.0, 0.0]) + &moving(1.2, [-1.0, 0.0]);
    for (name, bodies, says) in [
        ("meet-sharp", meeting() + SHARP, "has run into particle 0"),
        ("meet-mixing", meeting() + MIXING + LAW, "has run into particle 0"),
        (
            "wall-sharp",
            moving(0.6, [0.0, 2.0]) + SHARP + LAW,
            "has reached the boundary of the box along y",
        ),
        (
            "wall-mixing",
            moving(0.6, [0.0, 2.0]) + MIXING,
            "has reached the boundary of the box along y",
        ),
    ] {
        let case = write(dir.path(), &box_case([2.0, 1.0], [32, 16], 0.01, STREAM, &bodies));
        let out = dir.path().join(name);
        let output =
            mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--quiet"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{said}");
        assert!(
            said.contains("particle 0") && said.contains(says) && said.contains("error: step "),
            "{said}"
        );
        let rows = columns(&out.join("particles.csv"));
        assert!(
            *rows["time"].last().unwrap() > 0.1,
            "they met after 0.15 s: {:?}",
            rows["time"].last()
        );
    }
}

#[test]
fn schemes_at_stability_limit_keep_energy_bounded() {
    let petsc = petsc();
    for (viscosity, scheme) in [
        (1e-6, "scheme = \"rk2\"\ncfl = 0.5"),
        (1e-6, "scheme = \"rk3\"\ncfl = 1.2"),
        (1e-6, "scheme = \"euler\"\nadvection = \"qsi\"\ncfl = 0.9"),
        (2e-3, "scheme = \"euler\"\ncfl = 0.25"),
        (1.0, "scheme = \"rk2\"\ncfl = 0.5"),
        (1.0, "scheme = \"rk3\"\ncfl = 1.2"),
        (1.0, "scheme = \"euler\"\nadvection = \"qsi\"\ncfl = 0.9"),
    ] {
        let more = format!(
            "[initial]\nvelocity = [1.0, 0.3]\nperturbation = 0.5\n[time]\nend = 1.0\n{scheme}"
        );
        let text = box_case([1.0, 1.0], [24, 24], viscosity, crate::support::PERIODIC, &more);
        let mut scene: Scene<2> = petsc.scene(&text);
        let (start, _) = scene.energy_and_speed().unwrap();
        let mut before = start;
        for step in 0..200 {
            let (_, dt) = scene.limits().unwrap().tightest();
            scene.step(dt).unwrap();
            let (energy, _) = scene.energy_and_speed().unwrap();
            // The noise of the start has another pressure in each of the first steps.
            let growth = if step < 5 { 0.02 } else { 1e-3 };
            assert!(
                energy < before * (1.0 + growth),
                "{scheme}, nu = {viscosity}: {energy} after {before}"
            );
            before = energy;
        }
        assert!(before < start, "{scheme}, nu = {viscosity}: {before} of {start}");
    }
}

#[test]
fn failure_message_printed_once_and_logged() {
    let dir = tempfile::tempdir().unwrap();
    let disc = |x: f64, v: f64| {
        let motion = format!("motion = {{ prescribed = {{ velocity = [{v:?}, 0.0] }} }}");
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, 0.5]\n\
            {motion}\n"
        )
    };
    let meet = [&disc(0.6, 1.0), &disc(1.2, -1.0), SHARP].concat();
    let case =
        write(dir.path(), &box_case([2.0, 1.0], [32, 16], 0.01, crate::support::PERIODIC, &meet));
    let out = dir.path().join("run");
    let output = mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    let [said, errors] = [text(&output.stdout), text(&output.stderr)];
    assert!(!said.contains("error: ") && errors.matches("error: ").count() == 1, "{said}{errors}");
    let log = std::fs::read_to_string(out.join("log.txt")).unwrap();
    assert_eq!(log.matches("error: ").count(), 1, "{log}");
}
