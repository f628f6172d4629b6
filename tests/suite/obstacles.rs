//! Obstacles of any shape in the flow: channels and ducts across the grid, against the exact flow.

use crate::support::{PERIODIC, Petsc, box_case, columns, mics, order, petsc};
use mics::config::load;
use mics::geometry::shapes::{Extent, Obstacle};
use mics::particles::Body;
use mics::scene::Scene;
use nalgebra::Vector3;
use std::sync::Arc;

fn scene_of(petsc: &Petsc, text: &str, obstacle: Obstacle, centre: Vector3<f64>) -> Scene<2> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("case.toml");
    std::fs::write(&path, text).unwrap();
    let case = load(&path, &[]).unwrap_or_else(|e| panic!("{e}")).case;
    let body = Body::new(Arc::new(obstacle), 1.0, 0.01, centre);
    Scene::with_bodies(&petsc.session, &case, vec![body]).unwrap_or_else(|e| panic!("{e}"))
}

/// Flow through a channel of width 0.5 along (2, 1) in a periodic box of 2 x 1, over the exact one
/// less 1; the walls are moved by `offset` across the grid, `n` cells to the height of the box.
fn tilted_channel(petsc: &Petsc, n: usize, offset: f64) -> f64 {
    let (width, force, viscosity) = (0.5, 1.0, 1.0);
    let along = Vector3::new(2.0, 1.0, 0.0).normalize();
    // Heights of the walls at x = 0: a strip of that width stands open.
    let open = width / along.x;
    let (low, high) = (offset + open, offset + 1.0);
    let outline = vec![[0.0, low], [2.0, low + 1.0], [2.0, high + 1.0], [0.0, high]];
    let room = Extent { size: Vector3::new(2.0, 1.0, 1.0), periodic: [true, true, false] };
    let obstacle = Obstacle::outlines(&[outline], &room).unwrap();
    let more = format!(
        "[drive]\nforce = [{:?}, {:?}]\n[pressure]\ndivergence_limit = 1.0e-9\n",
        force * along.x,
        force * along.y
    );
    let text = box_case([2.0, 1.0], [2 * n, n], viscosity, PERIODIC, &more);
    let mut scene = scene_of(petsc, &text, obstacle, Vector3::new(1.0, 0.5, 0.0));
    let (mut time, end) = (0.0, 1.2 * width * width / viscosity);
    while time < end {
        let dt = scene.limits().unwrap().tightest().1.min(end - time);
        scene.step(dt).unwrap();
        time += dt;
    }
    let grid = &scene.domain.grid;
    let flow: f64 = grid.rows().flatten().map(|c| scene.state.faces[0][c]).sum::<f64>()
        / (2 * n) as f64
        / n as f64;
    // The flow through a line across x is that through the channel.
    let exact = force * width.powi(3) / (12.0 * viscosity);
    flow / exact - 1.0
}

/// The largest error wherever the walls lie: at one place it is up to a third less on either grid,
/// as a row of cells comes to lie within a tenth of a spacing of a wall.
#[test]
fn tilted_channel_flow_is_second_order_wherever_the_walls_lie() {
    let petsc = petsc();
    let worst = [16, 32].map(|n| {
        let all = [0.0, 0.005, 0.013, 0.031].map(|offset| tilted_channel(&petsc, n, offset));
        println!("{n} cells: {all:.5?}");
        all.into_iter().map(f64::abs).fold(0.0, f64::max)
    });
    let observed = order(worst[0], worst[1], 2.0);
    assert!(worst[1] < 2.1e-3 && observed > 1.8, "{worst:?} {observed}");
}

#[test]
fn obstacle_has_its_name_in_messages_and_its_number_in_files() {
    let dir = tempfile::tempdir().unwrap();
    let (file, out) = (dir.path().join("case.toml"), dir.path().join("out"));
    let wall = "\"wall\"";
    let text = |more: &str| {
        let more = format!(
            "[output]\nfigures = false\n[contact]\n[coupling]\nwall = \"sharp\"\n{more}\n\
            [[obstacle]]\nname = \"plate\"\npolygon = {{ points = [[0.2, 0.05], [0.24, 0.05], \
            [0.24, 0.15], [0.2, 0.15]] }}\n"
        );
        box_case([0.4, 0.2], [40, 20], 1e-3, [wall; 4], &more)
    };
    let disc = |x: f64, more: &str| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.04 }} }}\nposition = [{x:?}, 0.101]\n\
            {more}\n"
        )
    };
    // The plate is driven into the disc that is held.
    let driven = "motion = { prescribed = { velocity = [-1.0, 0.0] } }\n";
    let held = disc(0.1, "motion = \"fixed\"") + "[time]\nend = 0.1\n";
    std::fs::write(&file, text(&held) + driven).unwrap();
    let file = file.to_str().unwrap();
    let check = mics(&["check", file]);
    let said = String::from_utf8_lossy(&check.stdout).into_owned();
    assert!(said.contains("plate has run into particle 0 ("), "{said}");
    let words = ["run", file, "--quiet", "--out", out.to_str().unwrap(), "--set", "time.end=1e-4"];
    assert!(mics(&words).status.success());
    let surface = std::fs::read_to_string(out.join("fields/obstacles-00000000.vtp")).unwrap();
    let ids = surface.split("Name=\"id\"").nth(1).unwrap().split(['<', '>']).nth(1).unwrap();
    assert!(ids.split_whitespace().all(|id| id == "0"), "{ids}");
    // A disc that is too fast for its soft contact.
    let struck = disc(0.17, "density = 2000.0\nvelocity = [20.0, 0.0]") + &disc(0.32, "");
    let soft = struck + "[time]\nend = 0.1\nstep = 2e-5\n";
    let soft = text(&soft).replace("[contact]", "[contact]\nnormal_stiffness = 10.0");
    std::fs::write(file, soft).unwrap();
    let ended = mics(&["run", file, "--quiet", "--force", "--out", out.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(said.contains("particle 0 and plate"), "{said}");
}

/// Solids with re-entrant right angles in a box of 16 x 12 cells, a metre each: a block on a bed, a
/// step of the bed, a block with a step that is turned; its corner at a place of a cell.
fn solid_with_corner(kind: usize, [x, y]: [f64; 2], angle: f64) -> Vec<[f64; 2]> {
    let (x, y) = (5.0 + x, 4.0 + y);
    match kind {
        0 => vec![
            [0.0, -1.0],
            [16.0, -1.0],
            [16.0, y],
            [x + 5.5, y],
            [x + 5.5, y + 4.0],
            [x, y + 4.0],
            [x, y],
            [0.0, y],
        ],
        1 => {
            vec![[0.0, -1.0], [16.0, -1.0], [16.0, y + 3.0], [x, y + 3.0], [x, y], [0.0, y]]
        }
        _ => {
            let (sin, cos) = angle.sin_cos();
            let turned =
                |[dx, dy]: [f64; 2]| [x + 2.0 + cos * dx - sin * dy, y + 2.0 + sin * dx + cos * dy];
            [[-3.5, -3.5], [3.5, -3.5], [3.5, 0.0], [0.0, 0.0], [0.0, 3.5], [-3.5, 3.5]]
                .map(turned)
                .to_vec()
        }
    }
}

/// The largest velocity after 60 long steps of a creeping flow past a solid, over the one that an
/// open channel of that height would come to.
fn largest_velocity(petsc: &Petsc, outline: &[[f64; 2]]) -> f64 {
    let more = format!(
        "[drive]\nforce = [1.0, 0.0]\n[pressure]\ndivergence_limit = 1.0e-6\n\
        [[obstacle]]\npolygon = {{ points = {outline:?} }}\n"
    );
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
    let text = box_case([16.0, 12.0], [16, 12], 1e3, sides, &more);
    let mut scene: Scene<2> = petsc.scene(&text);
    for _ in 0..60 {
        let dt = 0.8 * scene.limits().unwrap().tightest().1;
        scene.step(dt).unwrap();
    }
    let u = &scene.state.u[0];
    let cells = scene.domain.grid.rows().flatten();
    cells.map(|c| u[c].abs()).fold(0.0, f64::max) / (0.5 * 12.0 * 12.0 / 1e3)
}

/// A cell that is close to both walls of a corner, and a row of cells that is close to a flat one,
/// saw so little of themselves in their ghost cells that eight Legendre stages amplified them.
#[test]
fn creeping_flow_over_corners_is_stable_wherever_they_lie() {
    let petsc = petsc();
    for (kind, place, angle) in [
        (0, [0.96, 0.74], 0.0),
        (0, [0.52, 0.48], 0.0),
        (1, [0.52, 0.48], 0.0),
        (1, [0.15, 0.488], 0.0),
        (1, [0.43, 0.43], 0.0),
        (2, [0.5, 0.5], 3.0),
    ] {
        let largest = largest_velocity(&petsc, &solid_with_corner(kind, place, angle));
        assert!(largest < 1.0, "{kind} {place:?} {angle}: {largest}");
    }
}

/// Creeping flow over corners at 500 random places and angles: a minute.
#[test]
#[ignore = "500 runs"]
fn creeping_flow_over_corners_is_stable_at_500_random_places_and_angles() {
    let (petsc, mut state) = (petsc(), 1u64);
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut unstable = Vec::new();
    for k in 0..500 {
        let (place, angle) = ([random(), random()], std::f64::consts::TAU * random());
        let largest = largest_velocity(&petsc, &solid_with_corner(k % 3, place, angle));
        if largest.is_nan() || largest > 1.0 {
            unstable.push((k % 3, place, angle, largest));
        }
    }
    assert!(unstable.is_empty(), "{} of 500: {unstable:?}", unstable.len());
}

/// The cells within a bed have a pressure that no fluid sees, and the bed's force along the stream
/// had its difference from one side of the box to the other: ten times the friction.
#[test]
fn flat_bed_from_inflow_to_outflow_has_friction_alone_on_any_ranks() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("bed.toml");
    let case = |top: f64| {
        format!(
            "name = \"bed\"\ndomain = {{ size = [0.4, 0.1], cells = [48, 12] }}\n\
            fluid = {{ density = 1000.0, viscosity = 0.05 }}\n\
            [boundary]\nwest = {{ inflow_half_parabola = [0.2, 0.0] }}\neast = \"outflow\"\n\
            south = \"wall\"\nnorth = \"slip\"\n\
            [[obstacle]]\nname = \"bed\"\n\
            heights = {{ points = [[-1.0, {top}], [2.0, {top}]] }}\n\
            [[particle]]\nshape.disc.diameter = 0.03\nposition = [0.15, 0.07]\n\
            density = 1500.0\n[contact]\n[time]\nend = 0.1\n"
        )
    };
    for top in [0.0197, 0.021, 0.03] {
        std::fs::write(&file, case(top)).unwrap();
        let mut last = Vec::new();
        for ranks in ["1", "2"] {
            let out = dir.path().join(format!("{top}-{ranks}"));
            let words = ["run", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
            let output = mics(&[&words[..], &["--ranks", ranks, "--quiet"]].concat());
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let rows = columns(&out.join("obstacles.csv"));
            let end = |name: &str| *rows[name].last().unwrap();
            let largest = rows["pressure_fx"].iter().fold(0.0, |most: f64, f| most.max(f.abs()));
            println!("{top}: {:.3e} along, {largest:.1e} of it by pressure", end("fluid_fx"));
            assert!(end("viscous_fx") > 0.05 && largest < 1e-9, "{top}: {largest:e} N/m");
            last.push(end("fluid_fx"));
            let steps = columns(&out.join("steps.csv"));
            let error = steps["momentum_error"].iter().fold(0.0, |most: f64, e| most.max(*e));
            assert!(error < 1e-9, "{top}: {error:e}");
        }
        assert!((last[0] / last[1] - 1.0).abs() < 1e-6, "{top}: {last:?}");
    }
}
