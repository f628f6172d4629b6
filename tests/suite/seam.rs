//! The two ends of a period are one place, and a run may begin under other forces than another
//! ended with.

use crate::restart::said;
use crate::support::{columns, mics, run};
use std::path::Path;

/// The last forces on fixed bodies of 2 mm at these places along x (m), of a stream through a
/// periodic row of discs or of spheres, 8 cells each. Where a free one goes with the stream, faces
/// remember more.
fn forces(three: bool, length: f64, y: f64, places: &[f64], free: Option<f64>) -> Vec<f64> {
    let dir = tempfile::tempdir().unwrap();
    let along = (length * 4000.0).round();
    let (shape, size, cells) = if three {
        ("sphere", format!("[{length:?}, 0.004, 0.004]"), format!("[{along}, 16, 16]"))
    } else {
        ("disc", format!("[{length:?}, 0.008]"), format!("[{along}, 32]"))
    };
    let fixed = places.iter().map(|x| (*x, y, "motion = \"fixed\""));
    let bodies: String = fixed
        .chain(free.map(|x| (x, y - 0.0024, "density = 2650.0")))
        .map(|(x, y, moves)| {
            let at =
                if three { format!("[{x:?}, {y:?}, 0.00199]") } else { format!("[{x:?}, {y:?}]") };
            format!("[[particle]]\nshape.{shape}.diameter = 0.002\nposition = {at}\n{moves}\n")
        })
        .collect();
    let z = if three { "bottom = \"periodic\", top = \"periodic\", " } else { "" };
    let text = format!(
        "name = \"row\"\ndomain = {{ size = {size}, cells = {cells} }}\n\
        fluid = {{ density = 1000.0, viscosity = 0.005 }}\n\
         boundary = {{ {z}west = \"periodic\", east = \"periodic\", south = \"periodic\", north = \
             \"periodic\" }}\n\
         contact.friction = 0.4\ndrive.mean_velocity = {{ axis = \"x\", value = 0.05 }}\n\
             pressure = {{ divergence_limit = 1e-6, max_iterations = 100 }}\n\
         time = {{ end = 0.012, step = 0.0005 }}\n\
         output = {{ figures = false, fixed = \"always\", particles = {{ every = 1 }} }}\n{bodies}"
    );
    let case = dir.path().join("case.toml");
    std::fs::write(&case, text).unwrap();
    run(&case, &dir.path().join("run"), &[]);
    let forces = &columns(&dir.path().join("run/particles.csv"))["fluid_fx"];
    let all = places.len() + usize::from(free.is_some());
    forces[forces.len() - all..][..places.len()].to_vec()
}

/// Where the middle of the gap falls on a face, rounding decided on which side of the period it was
/// counted, and which body comes first.
#[test]
fn force_on_touching_bodies_same_across_periodic_boundary() {
    let scenes = [
        (false, 0.0, 0.004),
        (false, 75e-6, 0.004),
        (false, 0.0, 0.00406),
        (true, 0.0, 0.002),
        (true, 61e-6, 0.00213),
    ];
    for ((three, phase, y), turned) in
        scenes.into_iter().flat_map(|scene| [(scene, false), (scene, true)])
    {
        let pair = |x: f64| {
            let mut places =
                [x + phase - 0.001, x + phase + 0.001].map(|x| if x < 0.0 { x + 0.008 } else { x });
            places[..if turned { 2 } else { 0 }].reverse();
            places
        };
        let free = |x: f64| (!three).then_some(x + phase);
        let (middle, seam) = (
            forces(three, 0.008, y, &pair(0.004), free(0.0)),
            forces(three, 0.008, y, &pair(0.0), free(0.004)),
        );
        println!(
            "{three} {phase} {y} {turned}: {middle:?} N in the middle, {seam:?} N across the period"
        );
        for (a, b) in middle.iter().zip(&seam) {
            assert!((a / b - 1.0).abs() < 1e-5, "{three} {phase} {y}: {middle:?}, {seam:?}");
        }
    }
}

/// A sphere that just reaches a face at the end of a period covers 3e-8 of it or nothing, as
/// rounding has it: at both ends alike.
#[test]
fn solid_fraction_of_periodic_faces_equal_at_both_ends() {
    let petsc = crate::support::petsc();
    let spheres: String = [0.001_075, 0.003_075, 0.005_075_000_000_000_000_5]
        .iter()
        .map(|x| {
            format!(
                "[[particle]]\nshape.sphere.diameter = 0.002\n\
                position = [{x:?}, 0.0040999999999999995, 0.001]\nmotion = \"fixed\"\n"
            )
        })
        .collect();
    let text = format!(
        "name = \"row\"\ndomain = {{ size = [0.006, 0.008, 0.008], cells = [24, 32, 32] }}\n\
        fluid = {{ density = 1000.0, viscosity = 0.001 }}\n\
         boundary = {{ west = \"periodic\", east = \"periodic\", south = \"periodic\", north = \
             \"periodic\", bottom = \"wall\", top = \"wall\" }}\n\
         drive.mean_velocity = {{ axis = \"x\", value = 0.15 }}\n\
             pressure.divergence_limit = 1e-3\ntime.end = 0.005\n{spheres}"
    );
    let mut scene: mics::scene::Scene<3> = petsc.scene(&text);
    scene.step(5e-4).unwrap();
    let (grid, u) = (&scene.domain.grid, &scene.state.faces[0]);
    let length = grid.cells[0] * grid.stride[0];
    let apart =
        |c: usize| if grid.global_cell(c)[0] == 0 { (u[c] - u[c + length]).abs() } else { 0.0 };
    let worst = grid.rows().flatten().map(apart).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst} m/s more flow in than out");
}

/// Two bodies in a period see each other on both sides.
#[test]
fn four_bodies_in_a_period_feel_what_two_in_half_of_it_feel() {
    for gap in [0.0, 0.000_125] {
        // Two of these are a whole number of cells.
        let length = 0.002 + gap;
        let one =
            forces(false, 4.0 * length, 0.00406, &[0.3, 1.3, 2.3, 3.3].map(|k| k * length), None);
        let two = forces(false, 2.0 * length, 0.00406, &[0.3, 1.3].map(|k| k * length), None);
        println!("gap {gap}: {one:?} N in four, {two:?} N in two");
        // Every other one lies alike in its cells.
        for (k, force) in one.iter().enumerate() {
            assert!((force / two[k % 2] - 1.0).abs() < 1e-6, "gap {gap}: {one:?}, {two:?}");
        }
    }
}

/// A body that nearly fills a period is beside its own image: the flow between the two is the same
/// wherever it stands.
#[test]
fn force_beside_own_periodic_image_independent_of_cell_position() {
    let force = |cells: [usize; 2], width: f64, at: [f64; 2]| {
        let dir = tempfile::tempdir().unwrap();
        let (h, case) = (0.000_25, dir.path().join("case.toml"));
        let [size, at] = [cells.map(|n| n as f64), at].map(|v| v.map(|x| h * x));
        let text = format!(
            "name = \"tight\"\ndomain = {{ size = {size:?}, cells = {cells:?} }}\n\
            fluid = {{ density = 1000.0, viscosity = 0.005 }}\n\
             boundary = {{ west = \"periodic\", east = \"periodic\", south = \"periodic\", north = \
                 \"periodic\" }}\n\
             drive.mean_velocity = {{ axis = \"x\", value = 0.005 }}\n\
                 pressure = {{ divergence_limit = 1e-6, max_iterations = 200 }}\n\
             time = {{ end = 0.001, step = 0.0001 }}\n\
             output = {{ figures = false, fixed = \"always\", particles = {{ every = 1 }} }}\n\
             [[particle]]\nshape.disc.diameter = {:?}\nposition = {at:?}\nmotion = \"fixed\"\n",
            h * width
        );
        std::fs::write(&case, text).unwrap();
        run(&case, &dir.path().join("run"), &[]);
        *columns(&dir.path().join("run/particles.csv"))["fluid_fx"].last().unwrap()
    };
    for (cells, width, [x, y]) in [([24, 10], 9.0, [5.25, 4.9392]), ([32, 16], 15.84, [16.5, 3.0])]
    {
        let inside = force(cells, width, [x, y]);
        let wrapped = |x: f64, n: usize| x.rem_euclid(n as f64);
        for (dx, dy) in [(0.0, -4.0), (0.0, 5.0), (-11.0, 0.0), (9.0, 6.0)] {
            let moved = force(cells, width, [wrapped(x + dx, cells[0]), wrapped(y + dy, cells[1])]);
            println!("{width} in {}: {inside} N, {moved} N moved by {dx}, {dy} cells", cells[1]);
            assert!(
                (moved / inside - 1.0).abs() < 1e-6,
                "{width} in {}: {inside} N, {moved} N",
                cells[1]
            );
        }
    }
}

fn slope(dir: &Path, name: &str, gravity: &str, start: &str) -> std::path::PathBuf {
    let text = format!(
        "name = \"slope\"\ndomain = {{ size = [0.016, 0.012], cells = [64, 48] }}\n\
         fluid = {{ density = 1000.0, viscosity = 0.001, gravity = {gravity} }}\n\
         boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
         contact = {{ friction = 0.4 }}\ntime = {{ end = 0.04 }}\n\
         pressure = {{ divergence_limit = 1e-3 }}\n\
         output = {{ figures = false, particles = {{ every = 1 }} }}\n{start}\n"
    );
    std::fs::write(dir.join(name), text).unwrap();
    dir.join(name)
}

/// The acceleration and the contact forces of a body under the old gravity are no part of its first
/// step under the new one.
#[test]
fn first_step_after_tilted_gravity_equals_fresh_start() {
    let dir = tempfile::tempdir().unwrap();
    let disc =
        "[[particle]]\nshape.disc.diameter = 0.002\nposition = [0.004, 0.001]\ndensity = 2650.0";
    let rest = dir.path().join("rest");
    run(&slope(dir.path(), "rest.toml", "[0.0, -9.81]", disc), &rest, &[]);
    let from = format!("initial.from = {rest:?}");
    for gravity in ["[6.0, -7.5]", "[0.0, 9.81]"] {
        let [tilted, fresh] = [("tilted", from.as_str()), ("fresh", disc)].map(|(name, start)| {
            let out = dir.path().join(name);
            let case = slope(dir.path(), &format!("{name}.toml"), gravity, start);
            let ran = mics(&[
                "run",
                case.to_str().unwrap(),
                "--out",
                out.to_str().unwrap(),
                "--quiet",
                "--force",
            ]);
            assert_eq!(ran.status.code(), Some(0), "{gravity} {name}: {}", said(&ran));
            let (bodies, steps) =
                (columns(&out.join("particles.csv")), columns(&out.join("steps.csv")));
            let [lost, given] =
                ["method_loss", "gravity_work"].map(|name| *steps[name].last().unwrap());
            assert!(lost > -0.05 * given, "{gravity} {name}: {lost} J of {given}");
            ["x", "y"].map(|name| bodies[name].last().unwrap() - bodies[name][0])
        });
        println!("{gravity}: {tilted:?} m after the tilt, {fresh:?} m put down");
        // The time that a film holds a body which is pulled off depends on how thin it was.
        let (way, off) =
            (fresh[0].hypot(fresh[1]), (tilted[0] - fresh[0]).hypot(tilted[1] - fresh[1]));
        let allowed = if gravity.starts_with("[0.0") { 0.3 } else { 0.03 };
        assert!(way > 0.0 && off < allowed * way, "{gravity}: {tilted:?}, {fresh:?}");
    }
}
