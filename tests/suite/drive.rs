//! Drives of the fluid besides its boundaries: exact channel flow, a mean velocity that is held in
//! every step, and the force on bodies.

use crate::box_measures::measures;
use crate::support::{Petsc, box_case, columns, order, petsc, run};
use mics::drive::{box_volume, mean};
use mics::scene::Scene;
use nalgebra::Vector3;
use std::f64::consts::PI;

const PERIODIC: [&str; 4] = ["\"periodic\""; 4];
pub const CHANNEL: [&str; 4] = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];

/// Kinematic viscosity and the force over density of a channel 1 m high whose mean velocity is 1
/// m/s.
const NU: f64 = 0.05;
const PUSH: f64 = 12.0 * NU;

pub fn disc(place: [f64; 2], density: f64, more: &str) -> String {
    format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 0.6 }} }}\nposition = {place:?}\n\
        density = {density:?}\n{more}\n"
    )
}

/// The largest error of the cells' velocity, and the force found (N/m3), of a channel of so many
/// cells once it is steady.
pub fn channel(cells: usize, drive: &str, gravity: &str) -> (f64, f64) {
    let petsc = petsc();
    let text = box_case([1.0, 1.0], [8, cells], 2.0 * NU, CHANNEL, &format!("[drive]\n{drive}"));
    let text = text
        .replace("density = 1.0", "density = 2.0")
        .replace("viscosity", &format!("{gravity}\nviscosity"));
    let mut scene: Scene<2> = petsc.scene(&text);
    let dt = 0.15 / (NU * (cells * cells) as f64);
    for _ in 0..(32.0 / dt) as usize {
        scene.step(dt).unwrap();
    }
    // The mean over a cell: 1/24 h^2 of the second derivative beyond its middle.
    let exact = |y: f64| 6.0 * y * (1.0 - y) - 0.5 / (cells * cells) as f64;
    let grid = &scene.domain.grid;
    let error =
        grid.rows().flatten().map(|c| (scene.state.u[0][c] - exact(grid.centre(c)[1])).abs());
    (error.fold(0.0, f64::max), scene.state.drive.unwrap().x)
}

#[test]
fn poiseuille_exact_by_force_slope_and_flow_rate() {
    let slope = format!("gravity = [{PUSH:?}, -9.81]");
    for (drive, gravity) in [
        (format!("force = [{:?}, 0.0]", 2.0 * PUSH), ""),
        ("gravity = true".to_owned(), slope.as_str()),
        ("mean_velocity = { axis = \"x\", value = 1.0 }".to_owned(), ""),
    ] {
        for cells in [8, 16] {
            let (off, force) = channel(cells, &drive, gravity);
            println!("{drive}, {cells} cells: off by {off:.1e} m/s; force {force:.7} N/m3");
            assert!(
                off < 1e-6 && (force / (2.0 * PUSH) - 1.0).abs() < 1e-6,
                "{drive}: {off} m/s, {force} N/m3"
            );
        }
    }
}

/// Two discs, one heavy and one light, that fall and meet in a periodic box with this drive and
/// wall.
fn pair(petsc: &Petsc, drive: &str, wall: &str) -> Scene<2> {
    let bodies = disc([1.03, 1.02], 3.0, "velocity = [0.0, -0.4]")
        + &disc([1.13, 0.32], 0.5, "velocity = [0.0, 0.4]");
    let more = format!(
        "[drive]\n{drive}\n[coupling]\nwall = \"{wall}\"\n{bodies}[contact]\n[pressure]\n\
        divergence_limit = 1e-6\n"
    );
    let text = box_case([2.0, 2.0], [32, 32], 0.05, PERIODIC, &more);
    petsc.scene(&text.replace("viscosity", "gravity = [0.0, -1.0]\nviscosity"))
}

#[test]
fn mean_velocity_held_in_every_step_with_colliding_bodies() {
    for wall in ["sharp", "mixing"] {
        let petsc = petsc();
        let mut scene = pair(&petsc, "mean_velocity = { axis = \"y\", value = 0.2 }", wall);
        let mut touched = false;
        for _ in 0..60 {
            scene.step(0.01).unwrap();
            let held =
                mean(&scene.domain.session, &scene.domain.grid, 1, &scene.state.faces).unwrap();
            assert!(
                (held - 0.2).abs() < 1e-13,
                "{wall}: {held} m/s after {} steps",
                scene.state.steps
            );
            if wall == "sharp" {
                let error = scene.state.balance.unwrap().error.amax();
                assert!(error < 1e-12, "{error} kg m/s are missing");
            }
            touched |= scene.state.exchange[0].contact.norm() > 0.0;
        }
        assert!(touched, "{wall}: they never met");
        let e = scene.state.energy;
        // The mixing takes a fourth of the energy where it cuts cells.
        let taken = if wall == "sharp" { 0.05 } else { 0.3 };
        assert!(e.work.drive != 0.0 && e.losses.method.abs() < taken * e.scale(), "{wall}: {e:?}");
    }
}

/// A disc of next to no weight that a heavy one presses against a wall: pressure and drive are
/// found together, in two iterations. The drive's part went by the discs' own volume and the
/// pressure's by the volume that faces show, which is less where they touch, and 20 iterations were
/// not enough.
#[test]
fn mean_velocity_drive_with_light_body_pressed_by_heavy_one() {
    let petsc = petsc();
    let text = format!(
        "name = \"t\"\ndomain = {{ size = [0.012, 0.017], cells = [12, 17] }}\n\
         fluid = {{ density = 1000.0, viscosity = 5e-4, gravity = [0.0, -9.81] }}\n\
         boundary = {{ west = \"wall\", east = \"wall\", south = \"periodic\", north = \
             \"periodic\" }}\n\
         contact = {{ friction = 0.0 }}\ndrive = {{ mean_velocity = {{ axis = \"y\", value = 0.0 \
             }} }}\ntime = {{ end = 0.02, step = 1e-3 }}\n{}{}",
        "[[particle]]\nshape.disc.diameter = 0.0042\ndensity = 1.0\nposition = [0.0094, 0.0157]\n",
        "[[particle]]\nshape.disc.diameter = 0.0048\ndensity = 1e5\nposition = [0.0082, 0.0035]\n"
    );
    let mut scene: Scene<2> = petsc.scene(&text);
    let (mut most, mut met) = (0, false);
    for _ in 0..20 {
        let report = scene.step(1e-3).unwrap();
        met |= scene.state.exchange.iter().any(|e| e.contact.norm() > 0.0);
        most = most.max(report.projected.outer);
    }
    println!("at most {most} iterations");
    assert!(met && most < 8, "{most} iterations");
}

#[test]
fn force_on_fixed_body_balances_drive() {
    let petsc = petsc();
    let (area, force) = (0.25 * PI * 0.36, 0.5);
    for wall in ["sharp", "mixing"] {
        let body = disc([1.03, 1.02], 1.0, "motion = \"fixed\"");
        let steady = |drive: &str| {
            let more = format!(
                "[drive]\n{drive}\n[coupling]\nwall = \"{wall}\"\n{body}[pressure]\n\
                divergence_limit = 1e-7\n"
            );
            let text = box_case([2.0, 2.0], [20, 20], 1.0, PERIODIC, &more);
            let mut scene: Scene<2> =
                petsc.scene(&text.replace("viscosity", "gravity = [0.5, 0.0]\nviscosity"));
            for _ in 0..2000 {
                scene.step(2e-3).unwrap();
            }
            let mean =
                mean(&scene.domain.session, &scene.domain.grid, 0, &scene.state.faces).unwrap();
            (
                scene.state.exchange[0].momentum.x,
                mean,
                scene.state.drive.unwrap().x,
                box_volume(&scene.domain.grid),
            )
        };
        // On the fluid alone, the body has what the fluid has got; as a gradient of the pressure,
        // its own volume's as well.
        let (on_fluid, flow, _, volume) = steady("force = [0.5, 0.0]");
        assert!((on_fluid / (force * (volume - area)) - 1.0).abs() < 5e-3, "{wall}: {on_fluid} N");
        let (on_all, flow_of_slope, _, _) = steady("gravity = true");
        assert!((on_all / (force * volume) - 1.0).abs() < 5e-3, "{wall}: {on_all} N");
        // The mixing shares a force on the fluid out in the cells that it cuts.
        let tolerance = if wall == "sharp" { 1e-9 } else { 0.02 };
        assert!(
            (flow / flow_of_slope - 1.0).abs() < tolerance,
            "{wall}: {flow} and {flow_of_slope} m/s"
        );
        let (_, held, found, _) =
            steady(&format!("mean_velocity = {{ axis = \"x\", value = {flow_of_slope:?} }}"));
        assert!(
            (held - flow_of_slope).abs() < 1e-13 && (found / force - 1.0).abs() < 5e-3,
            "{wall}: {found} N/m3"
        );
    }
}

/// K of flow at a superficial velocity (m/s) through a cubic array of fixed spheres, one to a box
/// of 1 m, in a fluid of 1 kg/m3 and 1 Pa s.
fn drag_of_array(diameter: f64, cells: usize, speed: f64, end: f64) -> f64 {
    let text = format!(
        "name = \"array\"\ndomain = \
        {{ size = [1.0, 1.0, 1.0], cells = [{cells}, {cells}, {cells}] }}\n\
         fluid = {{ density = 1.0, viscosity = 1.0 }}\npressure = {{ divergence_limit = 1e-6 }}\n\
         time = {{ end = {end:?}, cfl = 0.4 }}\n\
         boundary = {{ west = \"periodic\", east = \"periodic\", south = \"periodic\", north = \
             \"periodic\", bottom = \"periodic\", top = \"periodic\" }}\n\
         drive = {{ mean_velocity = {{ axis = \"x\", value = {speed:?} }} }}\n[output]\n\
             figures = false\n[[particle]]\n\
         shape = {{ sphere = {{ diameter = {diameter:?} }} }}\nposition = [0.5, 0.5, 0.5]\n\
         motion = \"fixed\"\n\
         [[measure]]\nname = \"drag\"\nkind = \"force\"\nfrom = {0:?}\n[[measure]]\n\
             name = \"gradient\"\nkind = \"drive_force\"\nfrom = {0:?}\n",
        0.95 * end
    );
    let found = measures(&text);
    let k = ["drag", "gradient"]
        .map(|name| found[name].as_f64().unwrap() / (6.0 * PI * 0.5 * diameter * speed));
    println!(
        "d = {diameter} m, {cells} cells: K = {:.5} by the force, {:.5} by the gradient",
        k[0], k[1]
    );
    assert!((k[0] / k[1] - 1.0).abs() < 0.01, "the two differ: {k:?}");
    k[1]
}

#[test]
fn stokes_drag_of_cubic_sphere_array_up_to_touching_spheres() {
    // Zick & Homsy 1982, at solid fractions of 0.125 and 0.343 and where they touch.
    let error =
        |diameter, cells, k: f64| (drag_of_array(diameter, cells, 0.01, 0.15) / k - 1.0).abs();
    let [coarse, fine] = [10, 18].map(|cells| error(0.868491, cells, 15.4));
    assert!(coarse < 0.065 && fine < 0.006 && order(coarse, fine, 1.8) > 1.8, "{coarse}, {fine}");
    let [coarse, fine] = [12, 16].map(|cells| error(0.99999, cells, 42.1));
    assert!(
        coarse < 0.035 && fine < 0.01 && order(coarse, fine, 4.0 / 3.0) > 1.8,
        "{coarse}, {fine}"
    );
    let [coarse, fine] = [13, 26].map(|cells| error(0.62035, cells, 4.292));
    assert!(coarse < 0.016 && fine < 0.004 && order(coarse, fine, 2.0) > 1.8, "{coarse}, {fine}");
}

/// Where the third image point came near to what lies across, the cubic extrapolation into cells
/// inside fed itself, beside slip boundaries first.
#[test]
fn undriven_flow_past_fixed_disc_decays_near_slip_side() {
    let petsc = petsc();
    for gap in [2.16, 2.8, 3.2, 3.6, 4.5] {
        let place = [1.0, 2.0 - 0.4 - 0.05 * gap];
        let mut scene: Scene<2> = petsc.scene(&format!(
            "name = \"slip\"\ndomain = {{ size = [2.0, 2.0], cells = [20, 20] }}\n\
            fluid = {{ density = 1.0, viscosity = 20.0 }}\n\
             pressure = {{ divergence_limit = 1e-9 }}\ntime = {{ end = 1.0 }}\n\
             initial = {{ perturbation = 1.0 }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"slip\" \
                 }}\n\
             [[particle]]\nshape = {{ disc = {{ diameter = 0.8 }} }}\nposition = {place:?}\n\
             motion = \"fixed\"\n"
        ));
        let mut fastest = Vec::new();
        for _ in 0..40 {
            scene.step(1e-3).unwrap();
            let speeds = scene
                .domain
                .grid
                .rows()
                .flatten()
                .map(|c| scene.state.u[0][c].hypot(scene.state.u[1][c]));
            fastest.push(speeds.fold(0.0, f64::max));
        }
        println!(
            "{gap} spacings from its image: {:.1e} m/s, {:.1e} of the start",
            fastest[39],
            fastest[39] / fastest[3]
        );
        assert!(fastest[39] < 0.05 * fastest[3], "at {gap}: {fastest:?}");
    }
}

/// The cubic extrapolation into cells inside comes a step late: imposed on every stage it would
/// oscillate for ever in steps as long as these.
#[test]
fn creeping_flow_past_fixed_disc_steady_with_many_stages() {
    let petsc = petsc();
    for place in [[1.0, 1.0], [1.03, 1.05], [1.09, 1.0125]] {
        let mut scene: Scene<2> = petsc.scene(&format!(
            "name = \"disc\"\ndomain = {{ size = [3.0, 2.0], cells = [60, 40] }}\n\
            fluid = {{ density = 1.0, viscosity = 0.2 }}\n\
             pressure = {{ divergence_limit = 1e-9 }}\ntime = {{ end = 8.0 }}\n\
             boundary = {{ west = {{ inflow = [1.0, 0.0] }}, east = \"outflow\", south = \
                 \"periodic\", north = \"periodic\" }}\n\
             [[particle]]\nshape = {{ disc = {{ diameter = 0.4 }} }}\nposition = {place:?}\n\
             motion = \"fixed\"\n"
        ));
        let forces: Vec<Vector3<f64>> = (0..320)
            .map(|_| {
                scene.step(0.025).unwrap();
                scene.state.exchange[0].momentum
            })
            .collect();
        let (last, rest) = forces.split_last().unwrap();
        let swing =
            rest[280..].iter().map(|force| (force - last).amax()).fold(0.0, f64::max) / last.x;
        println!("at {place:?}: {} N, swings by {swing:.1e}", last.x);
        assert!(swing < 1e-6, "at {place:?} the force still changes by {swing:.1e} of itself");
    }
}

/// The array is its own mirror image, so that the reversed flow has the reversed force: of weak
/// inertia K has the even powers of the Reynolds number alone, K = K0 + c Re^2. The upwinding adds
/// a part with its modulus, 0.02 % of K at Re = 1.
#[test]
fn weak_inertia_drag_of_cubic_array_grows_as_reynolds_squared() {
    let diameter = 0.725563;
    let [none, once, twice] =
        [0.01, 1.0, 2.0].map(|reynolds: f64| drag_of_array(diameter, 17, reynolds / diameter, 0.5));
    let (first, second) = (once - none, twice - none);
    println!("K - K0 = {first:.5} at Re = 1, {second:.5} at Re = 2: {:.2} times", second / first);
    assert!(
        (4e-3..7e-3).contains(&first) && (3.5..4.2).contains(&(second / first)),
        "{first}, {second}"
    );
}

/// A drive accelerates the fluid and a body of its density alike.
#[test]
fn driven_neutral_disc_has_velocity_gravity_times_time() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    for (wall, tolerance) in [("sharp", 1e-9), ("mixing", 1e-2)] {
        let disc = "[[particle]]\nshape = { disc = { diameter = 0.25 } }\n\
            position = [0.26, 0.51]\ndensity = 1.0\n";
        let more = format!(
            "{disc}[drive]\ngravity = true\n[coupling]\nwall = \"{wall}\"\n[time]\nend = 0.4\n\
            step = 0.01\n"
        );
        let text = box_case([1.0, 1.0], [32, 32], 0.002, ["\"periodic\""; 4], &more);
        let text = text
            .replace("density = 1.0\nviscosity", "gravity = [0.3, -0.1]\ndensity = 1.0\nviscosity");
        std::fs::write(&case, text).unwrap();
        let out = dir.path().join(wall);
        run(&case, &out, &["--set", "output.figures=false"]);
        let last = |name: &str| *columns(&out.join("particles.csv"))[name].last().unwrap();
        for (velocity, expected) in [(last("vx"), 0.12), (last("vy"), -0.04)] {
            assert!(
                (velocity / expected - 1.0).abs() < tolerance,
                "{wall}: {velocity} m/s, {expected} by g t"
            );
        }
    }
}
