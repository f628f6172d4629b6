//! Inflows by the height above a bed, and inflows and drives that vary over time.

use crate::support::{MIXING, SHARP, box_case, case, petsc};
use mics::config::load;
use mics::drive::mean;
use mics::scene::Scene;

/// Flow rates (m2/s, m3/s) along x through the faces of the low and of the high side across x.
fn flow_rates<const D: usize>(scene: &Scene<D>) -> [f64; 2] {
    let grid = &scene.domain.grid;
    let area = grid.cell_volume() / grid.h[0];
    [0, 1].map(|side| {
        let face = |cell| scene.state.faces[0][cell + side * grid.stride[0]];
        area * grid.boundary_cells(0, side).map(face).sum::<f64>()
    })
}

/// A flood: its times (s) and factors, and the factor at a time.
const FLOOD: &str = "over_time = { time = [0.05, 0.2, 0.3, 0.4], factor = [0.2, 1.5, 1.5, 0.5] }";

fn flood(time: f64) -> f64 {
    match time {
        t if t < 0.05 => 0.2,
        t if t < 0.2 => 0.2 + (t - 0.05) / 0.15 * 1.3,
        t if t < 0.3 => 1.5,
        t if t < 0.4 => 1.5 - (t - 0.3) / 0.1,
        _ => 0.5,
    }
}

const DISC: &str = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.7, 0.4]\n\
    motion = \"fixed\"\n";

/// What comes in is the table's at the end of each step, and as much goes out.
#[test]
fn hydrograph_flow_rate_comes_in_and_goes_out_in_each_step() {
    let petsc = petsc();
    let kinds = [
        (format!("{{ inflow = {{ velocity = [0.6, 0.0], {FLOOD} }} }}"), 0.6),
        (format!("{{ inflow_half_parabola = {{ velocity = [0.9, 0.0], {FLOOD} }} }}"), 0.6),
        (format!("{{ inflow_log = {{ velocity = [0.6, 0.0], roughness = 0.01, {FLOOD} }} }}"), 0.6),
        (
            format!(
                "{{ inflow_profile = {{ at = [0.0, 1.0], velocity = [[0.4, 0.0], [0.8, 0.0]], \
                {FLOOD} }} }}"
            ),
            0.6,
        ),
    ];
    for (west, given) in kinds {
        for body in [String::new(), DISC.to_owned() + SHARP] {
            let more = format!("{body}[pressure]\ndivergence_limit = 1e-11\n");
            let sides = [&west, "\"outflow\"", "\"wall\"", "\"slip\""];
            let text = box_case([2.0, 1.0], [32, 16], 0.01, sides, &more);
            // The stream is that of the largest factor, and so are the limits of a step.
            let speed = case(&text).reference_speed().unwrap();
            let mut scene: Scene<2> = petsc.scene(&text);
            let limits = scene.limits().unwrap();
            assert!(limits.courant_rate * scene.domain.grid.h[0] >= 0.9 * speed, "{west}");
            assert!((flow_rates(&scene)[0] - given * 0.2).abs() < 1e-14, "{west}");
            let mut off = [0.0f64; 2];
            for _ in 0..50 {
                scene.step(0.01).unwrap();
                let [enters, leaves] = flow_rates(&scene);
                off[0] = off[0].max((enters - given * flood(scene.state.time)).abs());
                off[1] = off[1].max((leaves - enters).abs());
            }
            let e = &scene.state.energy;
            let lost = e.losses.method / e.scale();
            println!("{west}: in off by {:.1e}, out by {:.1e} m2/s; {lost:.1e}", off[0], off[1]);
            assert!(off[0] < 1e-14 && off[1] < 1e-11, "{west}: {off:?}");
        }
    }
}

/// A uniform stream between slip sides is pushed by the pressure alone, and has the velocity of the
/// table everywhere.
#[test]
fn uniform_stream_follows_hydrograph_everywhere() {
    let petsc = petsc();
    let west = format!("{{ inflow = {{ velocity = [1.0, 0.0], {FLOOD} }} }}");
    let sides = [&west, "\"outflow\"", "\"slip\"", "\"slip\""];
    for scheme in ["rk2", "rk3", "rkl2", "euler"] {
        let more = format!(
            "[time]\nend = 1.0\nscheme = \"{scheme}\"\n[pressure]\ndivergence_limit = 1e-10\n"
        );
        let mut scene: Scene<2> = petsc.scene(&box_case([2.0, 1.0], [32, 16], 0.05, sides, &more));
        let mut off = 0.0f64;
        for _ in 0..90 {
            scene.step(0.005).unwrap();
            let wanted = flood(scene.state.time);
            let faces = scene.domain.grid.face_rows(0).flatten();
            let faces = faces.map(|f| (scene.state.faces[0][f] - wanted).abs());
            off = faces.fold(off, f64::max);
        }
        let cells = scene.domain.grid.rows().flatten();
        let cells = cells.map(|c| (scene.state.u[0][c] - 0.5).abs()).fold(0.0, f64::max);
        println!("{scheme}: faces off by {off:.1e} m/s, cells at the end by {cells:.1e} m/s");
        assert!(off < 1e-9 && cells < 1e-2, "{scheme}: {off:e}, {cells:e}");
    }
}

/// Over a bed that ends within a cell the log law has the mean that is given over what is open.
#[test]
fn inflow_log_over_bed_has_the_given_mean_over_the_open_height() {
    let petsc = petsc();
    let bed = "[[obstacle]]\npolygon = { points = [[-0.5, -0.5], [2.5, -0.5], [2.5, 0.23], \
        [-0.5, 0.23]] }\n";
    let law = |z: f64| (1.0 + z.max(0.0) / 0.002).ln();
    let depth = 0.77;
    let whole = (1.0 + 0.002 / depth) * law(depth) - 1.0;
    for (gravity, hangs) in [(-9.81, false), (9.81, true)] {
        let bed =
            if hangs { bed.replace("-0.5", "1.5").replace("0.23", "0.77") } else { bed.into() };
        // Counterclockwise either way.
        let west = "{ inflow_log = { velocity = [0.4, 0.0], roughness = 0.002 } }";
        let ends = [west, "\"outflow\"", "\"wall\"", "\"wall\""];
        let bed = bed.replace("[1.5, ", "[-0.5, ");
        let text = box_case([2.0, 1.0], [32, 16], 0.01, ends, &(bed + SHARP));
        let text = text.replace("viscosity", &format!("gravity = [0.0, {gravity:?}]\nviscosity"));
        let scene: Scene<2> = petsc.scene(&text);
        let [enters, _] = flow_rates(&scene);
        let grid = &scene.domain.grid;
        let mut off = 0.0f64;
        for cell in grid.boundary_cells(0, 0) {
            let y = grid.centre(cell)[1];
            let height = if hangs { 0.77 - y } else { y - 0.23 };
            if height > 0.5 * grid.h[1] {
                let wanted = 0.4 * law(height) / whole;
                off = off.max((scene.state.faces[0][cell] / wanted - 1.0).abs());
            }
        }
        println!("hangs {hangs}: flow {enters:?} of {}, off by {off:.1e}", 0.4 * depth);
        assert!((enters - 0.4 * depth).abs() < 1e-10, "{enters}");
        // Means of faces against the middle's, nearest to the bed the most.
        assert!(off < 0.05, "{off}");
    }
}

#[test]
fn height_of_an_inflow_is_along_gravity_in_3d() {
    let petsc = petsc();
    for (gravity, along) in [("[0.0, 0.0, -9.81]", 2), ("[0.1, -9.81, 0.0]", 1), ("[1.0, 0, 0]", 1)]
    {
        let text = format!(
            "name = \"s\"\n[domain]\nsize = [1.0, 1.0, 0.5]\ncells = [8, 8, 8]\n[fluid]\n\
            density = 1.0\nviscosity = 0.01\ngravity = {gravity}\n[boundary]\n\
            west = {{ inflow_half_parabola = [1.0, 0.0, 0.0] }}\neast = \"outflow\"\n\
            south = \"slip\"\nnorth = \"slip\"\nbottom = \"slip\"\ntop = \"slip\"\n\
            [time]\nend = 1.0"
        );
        let scene: Scene<3> = petsc.scene(&text);
        let [enters, _] = flow_rates(&scene);
        assert!((enters - 0.5 * 2.0 / 3.0).abs() < 1e-14, "{enters}");
        let grid = &scene.domain.grid;
        for cell in grid.boundary_cells(0, 0) {
            let s = grid.centre(cell)[along] / grid.size[along];
            // The mean of a parabola over a face is below its middle by a 24th of its bend.
            let wanted = 2.0 * s - s * s - 1.0 / (12.0 * 64.0);
            let found = scene.state.faces[0][cell];
            assert!((found - wanted).abs() < 1e-14, "{gravity}: {found}, {wanted} at {s}");
        }
    }
}

/// The impulse of a force is the integral of its table, and a mean velocity is the table's.
#[test]
fn drive_follows_its_table_over_time() {
    let petsc = petsc();
    let walls = ["\"periodic\"", "\"periodic\"", "\"slip\"", "\"slip\""];
    let force = format!("[drive]\nforce = {{ value = [2.0, 0.0], {FLOOD} }}\n");
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [16, 16], 0.01, walls, &force));
    assert!((scene.limits().unwrap().courant_growth - 3.0 * 16.0).abs() < 1e-9);
    let (mut impulse, mut off) = (0.0, 0.0f64);
    for _ in 0..50 {
        impulse += 2.0 * 0.01 * flood(scene.state.time + 0.005);
        scene.step(0.01).unwrap();
        let cells = scene.domain.grid.rows().flatten();
        off = cells.map(|c| (scene.state.u[0][c] - impulse).abs()).fold(off, f64::max);
    }
    // Trapezia of the table.
    let exact = 2.0 * (0.05 * 0.2 + 0.15 * 0.85 + 0.1 * 1.5 + 0.1 * 1.0 + 0.1 * 0.5);
    let e = &scene.state.energy;
    let missing = (e.work.drive - e.fluid).abs();
    println!("force: off by {off:.1e} m/s, {impulse:?} of {exact:?}; {missing:.1e} J missing");
    assert!(off < 1e-13 && (impulse - exact).abs() < 1e-13 && missing < 1e-13, "{off}, {impulse}");
    let held = format!("[drive]\nmean_velocity = {{ axis = \"x\", value = 0.3, {FLOOD} }}\n");
    for body in ["", &(DISC.to_owned() + SHARP), &(DISC.to_owned() + MIXING)] {
        let text = box_case([1.4, 1.0], [28, 20], 0.01, walls, &format!("{held}{body}"));
        let mut scene: Scene<2> = petsc.scene(&text);
        assert!(scene.limits().unwrap().courant_rate >= 0.45 * 20.0 * (1.0 - 1e-12));
        let mut off = 0.0f64;
        for _ in 0..50 {
            scene.step(0.01).unwrap();
            let mean = mean(&petsc.session, &scene.domain.grid, 0, &scene.state.faces).unwrap();
            off = off.max((mean - 0.3 * flood(scene.state.time)).abs());
        }
        println!("mean velocity: off by {off:.1e} m/s");
        assert!(off < 1e-12, "{body}: {off}");
    }
}

/// Power of a force that varies, and of the disc that the fluid meets: the budget of energy closes
/// as with a steady one.
#[test]
fn energy_budget_closes_with_a_force_over_time_beside_fixed_disc() {
    let petsc = petsc();
    let walls = ["\"periodic\""; 4];
    for wall in [SHARP, MIXING] {
        let lost = |force: &str| {
            let more = format!("[drive]\nforce = {force}\n{DISC}{wall}");
            let text = box_case([1.4, 1.0], [28, 20], 0.05, walls, &more);
            let mut scene: Scene<2> = petsc.scene(&text);
            (0..50).for_each(|_| _ = scene.step(0.01).unwrap());
            scene.state.energy.losses.method / scene.state.energy.work.drive
        };
        let steady = lost("[2.0, 0.0]");
        let varying = lost(&format!("{{ value = [2.0, 0.0], {FLOOD} }}"));
        println!(
            "{wall}: the method has {varying:.1e} of the work, of a steady force {steady:.1e}"
        );
        assert!(varying.abs() < 1.5 * steady.abs() + 1e-3, "{wall}: {varying}, {steady}");
    }
}

#[test]
fn hydrograph_file_is_read_once_and_stands_in_the_case_of_a_run() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("case.toml");
    let with = |table: &str| {
        let west = format!(
            "{{ inflow_log = {{ velocity = [0.6, 0.0], roughness = 0.01, over_time = {{ {table} }} \
            }} }}"
        );
        let sides = [&west, "\"outflow\"", "\"wall\"", "\"slip\""];
        std::fs::write(&path, box_case([2.0, 1.0], [32, 16], 0.01, sides, "")).unwrap();
        load(&path, &[])
    };
    let file = "file = \"flood.csv\"";
    let write = |text: &str| std::fs::write(dir.path().join("flood.csv"), text).unwrap();
    write("# a flood\ntime,factor\n0.0, 0.25\n10.0, 1.5\n");
    let read = with(file).unwrap().case;
    assert_eq!(read, with("time = [0.0, 10.0], factor = [0.25, 1.5]").unwrap().case);
    // The start has the inflow's velocity at time 0.
    assert_eq!(read.initial.velocity, [0.15, 0.0]);
    assert_eq!(read.to_toml().parse::<mics::config::Case>().unwrap(), read);
    for (text, says) in [
        ("time,factor\n0.0,1.0\n0.0,2.0\n", "flood.csv:3: column `time` must increase"),
        ("t,factor\n0.0,1.0\n", "flood.csv:1: the header must be time,factor"),
        ("time,factor\n0.0,1.0\n", "needs at least 2 times (s), not 1"),
        ("time,factor\n0.0,high\n", "column `factor` must be a finite number"),
    ] {
        write(text);
        let refused = with(file).unwrap_err().to_string();
        assert!(refused.contains(says) && refused.contains("inflow_log.over_time"), "{refused}");
    }
}
