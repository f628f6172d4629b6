//! State that lasts from step to step: a scene that is written and read goes on bit for bit.

use crate::passage::fed;
use crate::restart::{STREAM, discs};
use crate::support::{PERIODIC, Petsc, SHARP, box_case, case, petsc};
use mics::archive::Archive;
use mics::scene::{Scene, pass_boundaries};

/// Lasting state of a scene, as a checkpoint has it.
fn recorded<const D: usize>(petsc: &Petsc, scene: &mut Scene<D>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = Archive::write(&petsc.session, &mut bytes);
    scene.state.serialize(&scene.domain.grid, &mut archive).unwrap();
    archive.finish().unwrap();
    bytes
}

/// Steps of unequal length, since a step remembers the one before.
fn steps<const D: usize>(scene: &mut Scene<D>, which: std::ops::Range<u32>, dt: f64) -> usize {
    let step = |k: u32| {
        scene.step(dt * [1.0, 0.7, 0.9][k as usize % 3]).unwrap();
        scene.state.substeps
    };
    which.map(step).max().unwrap()
}

/// A scene that is read from an archive goes on as the one that was written, bit for bit, and so
/// does one that drops all its scratch between every two steps.
fn expect_to_go_on<const D: usize>(petsc: &Petsc, text: &str, dt: f64, touches: bool) {
    let mut straight: Scene<D> = petsc.scene(text);
    let before = steps(&mut straight, 0..5, dt);
    let kept = recorded(petsc, &mut straight);
    let after = steps(&mut straight, 5..10, dt);
    assert_eq!(
        before > 1 && after > 1,
        touches,
        "contacts before and after: {before}, {after} substeps: {text}"
    );
    let mut resumed: Scene<D> = petsc.scene(text);
    let mut bytes = &kept[..];
    let mut archive = Archive::read(&petsc.session, &mut bytes);
    resumed.state.serialize(&resumed.domain.grid, &mut archive).unwrap();
    archive.finish().unwrap();
    resumed.resume().unwrap();
    assert!(recorded(petsc, &mut resumed) == kept, "what is read is what was written: {text}");
    steps(&mut resumed, 5..10, dt);
    let (a, b) = (recorded(petsc, &mut straight), recorded(petsc, &mut resumed));
    let mut renewed: Scene<D> = petsc.scene(text);
    for k in 0..10 {
        steps(&mut renewed, k..k + 1, dt);
        renewed.renew(&case(text)).unwrap();
    }
    assert!(
        recorded(petsc, &mut renewed) == a,
        "scratch that is made anew changes nothing: {text}"
    );
    let differ = a.chunks(8).zip(b.chunks(8)).filter(|(a, b)| a != b).count();
    assert!(a == b, "{differ} of {} numbers differ: {text}", a.len() / 8);
}

#[test]
fn restart_from_checkpoint_is_bitwise_identical() {
    let petsc = petsc();
    let walls = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
    let falling = |more: &str| {
        let text = box_case([1.2, 1.0], [30, 25], 0.01, walls, &discs(more));
        text.replace("viscosity = 0.01", "viscosity = 0.01\ngravity = [0.3, -1.0]")
    };
    for more in [
        "[coupling]\nwall = \"sharp\"",
        "[coupling]\nwall = \"sharp\"\n[time]\nend = 1.0\nscheme = \"euler\"\ncfl = 0.2",
        "[coupling]\nwall = \"sharp\"\n[drive]\nmean_velocity = { axis = \"x\", value = 0.3 }",
        "[coupling]\nwall = \"mixing\"\n[drive]\nmean_velocity = { axis = \"x\", value = 0.3 }",
        "[coupling]\nwall = \"mixing\"\n[drive]\nforce = [0.4, 0.0]",
        "[coupling]\nwall = \"sharp\"\n[drive]\nforce = { value = [0.4, 0.0], over_time = { \
        time = [0.0, 0.02], factor = [0.0, 1.0] } }",
        "[coupling]\nwall = \"sharp\"\n[time]\nend = 1.0\nscheme = \"rk3\"",
        "[coupling]\nwall = \"mixing\"",
        "[coupling]\nwall = \"mixing\"\n[time]\nend = 1.0\nscheme = \"euler\"\n\
        advection = \"qsi\"",
    ] {
        expect_to_go_on::<2>(&petsc, &falling(more), 4e-3, true);
    }
    let body = |motion: &str| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [0.6, 0.5]\n\
            density = 2.65\nviscosity = 0.0\n\
             motion = {motion}\n"
        )
    };
    let swings = body(
        "{ prescribed = { spin = 2.0, oscillation = { amplitude = [0.05, 0.02], frequency = \
            3.0 } } }",
    );
    let goes = body("{ prescribed = { velocity = [0.7, 0.4], spin = 1.0 } }");
    for wall in ["sharp", "mixing"] {
        for body in [body("\"fixed\""), swings.clone(), goes.clone()] {
            let more = format!("{body}[coupling]\nwall = \"{wall}\"");
            for sides in [STREAM, PERIODIC] {
                expect_to_go_on::<2>(
                    &petsc,
                    &box_case([2.0, 1.0], [32, 16], 0.01, sides, &more),
                    5e-3,
                    false,
                );
            }
        }
    }
    // Of the fixed one the gap to the inflow is built once, and the inflow varies.
    let varying = "{ inflow = { velocity = [1.0, 0.0], over_time = { time = [0.0, 0.03, 0.1], \
        factor = [0.0, 2.0, 1.0] } } }";
    let sides = [varying, STREAM[1], STREAM[2], STREAM[3]];
    for more in [
        body("\"fixed\"").replace("[0.6, 0.5]", "[0.17, 0.5]") + SHARP,
        goes.clone() + SHARP,
        goes + "[coupling]\nwall = \"mixing\"\n",
        String::new(),
    ] {
        let text = box_case([2.0, 1.0], [32, 16], 0.01, sides, &more);
        expect_to_go_on::<2>(&petsc, &text, 5e-3, false);
    }
    // One that rests is built once, however often others are beside it.
    let apart = body("\"fixed\"").replace("[0.6, 0.5]", "[0.4, 0.5]")
        + &body("\"free\"\nvelocity = [0.5, 0.1]").replace("[0.6, 0.5]", "[1.4, 0.5]");
    expect_to_go_on::<2>(
        &petsc,
        &box_case([2.0, 1.0], [32, 16], 0.01, PERIODIC, &format!("{apart}{SHARP}")),
        5e-3,
        false,
    );
    let fluid = "[initial]\nvelocity = [1.0, 0.3]\nperturbation = 0.3";
    expect_to_go_on::<2>(
        &petsc,
        &box_case([1.0, 1.0], [16, 16], 0.01, PERIODIC, fluid),
        1e-2,
        false,
    );
}

/// A light disc that contacts hold at a lid: the response of the fluid to them lasts from step to
/// step.
#[test]
fn restart_of_light_disc_at_lid_is_bitwise_identical() {
    let petsc = petsc();
    let disc = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.6, 0.851]\n\
        density = 0.1\nvelocity = [0.1, 0.1]\n\
                [contact]\nnormal_stiffness = 500.0\nrestitution = 0.6\n[coupling]\n\
                wall = \"sharp\"";
    let walls = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];
    let text = box_case([1.2, 1.0], [30, 25], 0.01, walls, disc);
    let text = text.replace("viscosity = 0.01", "viscosity = 0.01\ngravity = [0.3, -1.0]");
    expect_to_go_on::<2>(&petsc, &text, 4e-3, true);
}

#[test]
fn restart_in_3d_is_bitwise_identical() {
    let petsc = petsc();
    for wall in ["sharp", "mixing"] {
        let sphere = |place: [f64; 3], velocity: [f64; 3]| {
            format!(
                "[[particle]]\nshape = {{ sphere = {{ diameter = 0.4 }} }}\nposition = {place:?}\n\
                density = 3.0\n\
                 velocity = {velocity:?}\nspin = [1.0, 2.0, 3.0]\n"
            )
        };
        let text = format!(
            "name = \"s\"\n[domain]\nsize = [1.2, 0.8, 0.8]\ncells = [18, 12, 12]\n[fluid]\n\
            density = 1.0\nviscosity = 0.02\n\
             gravity = [0.0, 0.0, -1.0]\n[boundary]\nwest = \"periodic\"\neast = \"periodic\"\n\
                 south = \"wall\"\n\
             north = \"slip\"\nbottom = \"wall\"\ntop = \"slip\"\n{}{}[contact]\n\
                 normal_stiffness = 500.0\n\
             friction = 0.3\n[coupling]\nwall = \"{wall}\"\n[time]\nend = 1.0",
            sphere([0.3, 0.4, 0.4], [0.5, 0.0, 0.0]),
            sphere([0.705, 0.42, 0.38], [-0.5, 0.1, 0.0]),
        );
        expect_to_go_on::<3>(&petsc, &text, 4e-3, true);
    }
}

/// The method goes on with what it has of the bodies that neither pass a boundary nor lie near to
/// one that does: as if all were cut anew.
#[test]
fn passing_bodies_change_nothing_of_others_that_is_not_found_anew() {
    let petsc = petsc();
    let sill = "[[obstacle]]\npolygon = { points = [[1.0, 0.0], [1.4, 0.0], [1.2, 0.2]] }\n";
    for removed in ["log", "return"] {
        let text = fed("end = 2.5", &format!("{SHARP}{sill}"))
            .replace("rate = 8.0", "rate = 40.0")
            .replace("figures = false", &format!("figures = false\nremoved = \"{removed}\""));
        let case = case(&text);
        let mut scenes: [Scene<2>; 2] = [petsc.scene(&text), petsc.scene(&text)];
        let mut told = Vec::new();
        for k in 0..220 {
            let [passed, _] = scenes.each_mut().map(|scene| {
                let passed = pass_boundaries(scene, &case, 0.01).unwrap();
                scene.step(0.01).unwrap();
                passed.passages
            });
            told.extend(passed.iter().map(|passage| passage.what));
            scenes[1].renew(&case).unwrap();
            let [taken, anew] = scenes.each_mut().map(|scene| recorded(&petsc, scene));
            assert!(taken == anew, "step {k}, {removed}: {told:?}");
        }
        let count = |what: &str| told.iter().filter(|told| **told == what).count();
        let out = if removed == "return" { "returned" } else { "left" };
        assert!(count("entered") == 12 && count(out) > 3, "{removed}: {told:?}");
    }
}
