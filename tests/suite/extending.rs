//! What a library's user can add without a change of the library: a force, a measure, a side of the
//! domain, an output; a shape is added in [`ellipse`](crate::ellipse). `docs/extending.md` quotes
//! the parts between the marks.

use crate::allocation::count;
use crate::extending_force::Kolmogorov;
use crate::modes::in_processes;
use crate::support::{MIXING, SHARP, box_case, case, order, petsc, shipped, summary};
use mics::grid::SideVelocity;
use mics::output::measure::Measure;
use mics::output::{Output, Rows};
use mics::petsc::Session;
use mics::run::{Extensions, Request, run_with};
use mics::scene::{Additions, Scene};
use mics::state::State;
use mics::{Error, Result};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

// [side]
/// A wall that swings along itself with a speed `speed cos(rate t)` (m/s).
struct Swinging {
    speed: f64,
    rate: f64,
}

impl SideVelocity for Swinging {
    fn at(&self, _place: &Vector3<f64>, time: f64) -> Vector3<f64> {
        Vector3::new(self.speed * (self.rate * time).cos(), 0.0, 0.0)
    }
}
// [end]

/// A side's velocity of any form.
struct Side<F>(F);

impl<F: Fn(&Vector3<f64>, f64) -> Vector3<f64> + Send + Sync> SideVelocity for Side<F> {
    fn at(&self, place: &Vector3<f64>, time: f64) -> Vector3<f64> {
        (self.0)(place, time)
    }
}

fn sided(name: &str, side: impl SideVelocity + 'static) -> Additions {
    Additions { sides: vec![(name.to_owned(), Arc::new(side))], ..Additions::default() }
}

/// Stokes' second problem: `u = U exp(-y/d) cos(w t - y/d)`, `d = sqrt(2 nu/w)`.
#[test]
fn external_oscillating_wall_stokes_layer_second_order() {
    let petsc = petsc();
    let (nu, rate) = (0.05, TAU);
    let thickness = (2.0 * nu / rate).sqrt();
    let exact = |y: f64, t: f64| (-y / thickness).exp() * (rate * t - y / thickness).cos();
    let profile = |cells: usize, steps: u32| -> Vec<(f64, f64)> {
        let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];
        let text = box_case([0.25, 2.0], [8, cells], nu, sides, "");
        let swing = sided("south", Swinging { speed: 1.0, rate });
        let mut scene = Scene::<2>::extended(&petsc.session, &case(&text), swing).unwrap();
        let cells: Vec<usize> = scene.domain.grid.rows().flatten().collect();
        for &c in &cells {
            scene.state.u[0][c] = exact(scene.domain.grid.centre(c)[1], 0.0);
        }
        scene.start().unwrap();
        (0..steps).for_each(|_| _ = scene.step(1.0 / f64::from(steps)).unwrap());
        let at = |c: &usize| (scene.domain.grid.centre(*c)[1], scene.state.u[0][*c]);
        cells.iter().map(at).collect()
    };
    let error = |profile: &[(f64, f64)]| {
        profile.iter().map(|(y, u)| (u - exact(*y, 1.0)).abs()).fold(0.0, f64::max)
    };
    let [coarse, fine] = [error(&profile(64, 320)), error(&profile(128, 1280))];
    let [long, short, shorter] = [320, 640, 1280].map(|steps| profile(64, steps));
    let change = |a: &[(f64, f64)], b: &[(f64, f64)]| {
        a.iter().zip(b).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max)
    };
    let [first, second] = [change(&long, &short), change(&short, &shorter)];
    println!("Stokes layer: errors {coarse:.2e}, {fine:.2e}; of the step {first:.2e} {second:.2e}");
    assert!(order(coarse, fine, 2.0) > 1.8 && fine < 5e-3, "{coarse} {fine}");
    assert!(order(first, second, 2.0) > 1.8, "{first} {second}");
}

/// Between slip walls the whole flow pulsates with its inflow.
#[test]
fn external_pulsating_inflow_between_slip_walls() {
    let petsc = petsc();
    let speed = |t: f64| 1.0 + 0.5 * (3.0 * t).sin();
    let sides = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];
    let text = box_case([2.0, 1.0], [32, 16], 0.01, sides, "");
    let inflow = Side(move |_: &Vector3<f64>, t: f64| Vector3::new(speed(t), 0.0, 0.0));
    let mut scene =
        Scene::<2>::extended(&petsc.session, &case(&text), sided("west", inflow)).unwrap();
    for _ in 0..100 {
        scene.step(0.01).unwrap();
        let (now, grid) = (speed(scene.state.time), &scene.domain.grid);
        let off = |field: &[f64]| {
            grid.rows().flatten().map(|c| (field[c] - now).abs()).fold(0.0, f64::max)
        };
        let [faces, cells] = [off(&scene.state.faces[0]), off(&scene.state.u[0])];
        assert!(faces < 1e-5 && cells < 2e-3, "{faces} {cells} at {}", scene.state.time);
    }
}

/// A lid with a profile in space, where the case has a wall: its corners are at rest.
#[test]
fn external_lid_velocity_profile_in_space() {
    let petsc = petsc();
    let text = box_case([1.0, 1.0], [32, 32], 0.1, ["\"wall\""; 4], "");
    let lid = |x: &Vector3<f64>, _: f64| Vector3::new((TAU * x.x / 2.0).sin().powi(2), 0.0, 0.0);
    let mut scene =
        Scene::<2>::extended(&petsc.session, &case(&text), sided("north", Side(lid))).unwrap();
    (0..300).for_each(|_| _ = scene.step(0.002).unwrap());
    let speeds = &scene.state.u[0];
    let at = |x: f64, y: f64| {
        let grid = &scene.domain.grid;
        let cell = [x, y].map(|x| (x * 32.0) as usize);
        speeds[grid.owned_index(cell).unwrap()]
    };
    let (middle, corner, low) = (at(0.51, 0.99), at(0.01, 0.99), at(0.51, 0.3));
    println!("lid: {middle:.3} in the middle, {corner:.3} in the corner, {low:.3} below");
    assert!(middle > 0.8 && corner.abs() < 0.02 && low < 0.0, "{middle} {corner} {low}");
}

/// With no bodies, sharp surfaces and the mixing, in 2D and 3D.
#[test]
fn a_side_from_outside_that_is_steady_does_what_a_moving_wall_of_the_case_does() {
    let petsc = petsc();
    fn fields<const D: usize>(session: &Session, text: &str, added: Additions) -> Vec<f64> {
        let mut scene = Scene::<D>::extended(session, &case(text), added).unwrap();
        (0..5).for_each(|_| _ = scene.step(2e-3).unwrap());
        let State { u, faces, p, .. } = scene.state;
        u.into_iter().chain(faces).flatten().chain(p).collect()
    }
    let lid = || sided("north", Side(|_: &Vector3<f64>, _: f64| Vector3::new(0.7, 0.0, -0.3)));
    let disc = "[[particle]]\nshape.disc.diameter = 0.4\nposition = [0.5, 0.6]\n";
    for more in [String::new(), format!("{SHARP}{disc}"), format!("{MIXING}{disc}")] {
        let text = |north: &str| {
            let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", north];
            box_case([1.0, 1.0], [24, 24], 0.05, sides, &more)
        };
        let own = text("{ moving_wall = [0.7, 0.0] }");
        let of_case = fields::<2>(&petsc.session, &own, Additions::default());
        assert!(of_case == fields::<2>(&petsc.session, &text("\"wall\""), lid()), "{more}");
    }
    let text = |north: &str| {
        format!(
            "name = \"box\"\ndomain = {{ size = [1.0, 0.8, 1.2], cells = [10, 8, 12] }}\n\
             fluid = {{ density = 1.0, viscosity = 0.05 }}\ntime.end = 1.0\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", \
             north = {north}, bottom = \"periodic\", top = \"periodic\" }}\n"
        )
    };
    let own = text("{ moving_wall = [0.7, 0.0, -0.3] }");
    let of_case = fields::<3>(&petsc.session, &own, Additions::default());
    assert!(of_case == fields::<3>(&petsc.session, &text("\"wall\""), lid()));
    assert!(of_case.iter().any(|value| value.abs() > 0.1));
}

#[test]
fn external_velocity_of_open_or_missing_side_is_refused() {
    let petsc = petsc();
    let sides = ["\"wall\"", "\"outflow\"", "\"slip\"", "\"wall\""];
    let case = case(&box_case([1.0, 1.0], [16, 16], 0.1, sides, ""));
    for name in ["east", "south", "top", "nowhere"] {
        let added = sided(name, Swinging { speed: 1.0, rate: 1.0 });
        let refused = Scene::<2>::extended(&petsc.session, &case, added).err().unwrap();
        assert!(refused.to_string().contains(name), "{refused}");
    }
}

// [measure]
/// The mean of `u^2/2` over the cells of a periodic box (J/kg), and its largest value so far.
#[derive(Default)]
struct LargestEnergy {
    largest: Option<f64>,
}

impl<const D: usize> Measure<D> for LargestEnergy {
    fn name(&self) -> &str {
        "largest_energy"
    }

    fn unit(&self) -> &str {
        "J/kg"
    }

    fn take(&mut self, scene: &Scene<D>, _largest_speed: f64) -> Result<()> {
        let (grid, u) = (&scene.domain.grid, &scene.state.u);
        let squares = |c: usize| u.iter().map(|u| u[c] * u[c]).sum::<f64>();
        let mut sum = [grid.rows().flatten().map(squares).sum::<f64>()];
        scene.domain.session.sum(&mut sum)?;
        let energy = 0.5 * sum[0] / grid.total_cells() as f64;
        self.largest = Some(self.largest.map_or(energy, |largest| largest.max(energy)));
        Ok(())
    }

    fn value(&self) -> Option<f64> {
        self.largest
    }

    fn kept(&self) -> String {
        self.largest.map_or(String::new(), |largest| format!("{largest:?}"))
    }

    fn go_on(&mut self, kept: &str) -> Result<()> {
        self.largest = kept.parse().ok();
        Ok(())
    }
}
// [end]

// [output]
/// `momentum.csv`: what the fluid has along x after every step (kg m/s), in a uniform fluid.
#[derive(Default)]
struct MomentumTable {
    rows: Option<Rows>,
}

impl<const D: usize> Output<D> for MomentumTable {
    fn name(&self) -> &str {
        "momentum.csv"
    }

    fn begin(&mut self, folder: &Path, scene: &mut Scene<D>, kept: Option<&str>) -> Result<()> {
        let path = folder.join("momentum.csv");
        let misfit = |_| Error::Usage(format!("{}: not of this run", path.display()));
        if scene.domain.session.rank() == 0 {
            self.rows = Some(match kept {
                None => Rows::create(&path, "step,time,momentum")?,
                Some(length) => Rows::go_on(&path, length.parse().map_err(misfit)?)?,
            });
        }
        Ok(())
    }

    fn take(&mut self, scene: &mut Scene<D>) -> Result<()> {
        let (grid, state) = (&scene.domain.grid, &scene.state);
        let mut sum = [grid.rows().flatten().map(|c| state.u[0][c]).sum::<f64>()];
        scene.domain.session.sum(&mut sum)?;
        let momentum = scene.domain.fluid.density * grid.cell_volume() * sum[0];
        self.rows.as_mut().map_or(Ok(()), |rows| {
            rows.add(format_args!("{},{:?},{momentum:?}", state.steps, state.time))
        })
    }

    fn kept(&mut self) -> Result<String> {
        let length = self.rows.as_mut().map_or(Ok(0), Rows::sync)?;
        Ok(length.to_string())
    }

    fn end(&mut self, _folder: &Path, _scene: &mut Scene<D>) -> Result<()> {
        self.rows.as_mut().map_or(Ok(()), Rows::flush)
    }
}
// [end]

/// A case of the text into a folder, to a time (s), with a force, a side, a measure and an output.
fn run_extended(dir: &Path, out: &str, end: f64, resume: bool, bodies: &str) -> Result<()> {
    let path = dir.join("case.toml");
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];
    let more = "[time]\nend = 1.0\nstep = 0.0078125\n[output]\nfigures = false\n";
    let more = format!("{more}{bodies}");
    std::fs::write(&path, box_case([1.0, 1.0], [24, 24], 0.05, sides, &more)).unwrap();
    // [run]
    let request = Request {
        case: path,
        out: Some(dir.join(out)),
        set: vec![format!("time.end={end:?}")],
        force: false,
        resume,
        quiet: true,
        petsc: Vec::new(),
        draw: |_| Ok(Vec::new()),
        commit: "",
    };
    let added = Extensions {
        scene: Additions {
            forces: vec![Arc::new(Kolmogorov { strength: 2.0, wavenumber: TAU })],
            sides: vec![("south".into(), Arc::new(Swinging { speed: 1.0, rate: TAU }))],
            ..Additions::default()
        },
        measures: vec![Box::new(LargestEnergy::default())],
        outputs: vec![Box::new(MomentumTable::default())],
    };
    run_with::<2>(&request, added)
    // [end]
}

/// A free disc beside a fixed one.
const DISCS: &str = "[contact]\nfriction = 0.3\n\
     [[particle]]\nshape.disc.diameter = 0.35\nposition = [0.3, 0.4]\ndensity = 1.2\n\
     [[particle]]\nshape.disc.diameter = 0.35\nposition = [0.72, 0.6]\nmotion = \"fixed\"\n";

#[test]
fn external_additions_restart_bitwise_identical() {
    let _petsc = petsc();
    for bodies in ["", DISCS] {
        let dir = tempfile::tempdir().unwrap();
        let dir = dir.path();
        let read =
            |out: &str, file: &str| std::fs::read_to_string(dir.join(out).join(file)).unwrap();
        run_extended(dir, "whole", 0.5, false, bodies).unwrap();
        run_extended(dir, "parts", 0.25, false, bodies).unwrap();
        // What a run that was killed had written after its checkpoint.
        let table = dir.join("parts/momentum.csv");
        std::fs::write(&table, read("parts", "momentum.csv") + "33,0.25,9.0\n34,0.26").unwrap();
        run_extended(dir, "parts", 0.5, true, bodies).unwrap();
        let [whole, parts] = ["whole", "parts"].map(|out| read(out, "momentum.csv"));
        assert_eq!(whole, parts);
        assert_eq!(whole.lines().count(), 1 + 65, "the head, the start and 64 steps");
        let [whole, parts] = ["whole", "parts"].map(|out| summary(&dir.join(out)));
        let found = whole["measures"]["largest_energy"].as_f64().unwrap();
        println!("largest_energy = {found} {}", whole["units"]["largest_energy"]);
        assert!(found > 1e-3 && whole["units"]["largest_energy"] == "J/kg", "{whole}");
        assert_eq!(whole["measures"], parts["measures"]);
    }
}

fn swept(session: &Session, bodies: &str) -> Scene<2> {
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];
    let text = box_case([1.0, 1.0], [24, 24], 0.05, sides, bodies);
    let added = Additions {
        forces: vec![Arc::new(Kolmogorov { strength: 2.0, wavenumber: TAU })],
        sides: vec![("south".into(), Arc::new(Swinging { speed: 1.0, rate: TAU }))],
        ..Additions::default()
    };
    Scene::extended(session, &case(&text), added).unwrap()
}

#[test]
fn step_with_external_force_and_side_allocates_nothing() {
    let petsc = petsc();
    for bodies in ["", DISCS] {
        let mut scene = swept(&petsc.session, bodies);
        scene.step(1e-3).unwrap();
        let before = count();
        (0..5).for_each(|_| _ = scene.step(1e-3).unwrap());
        assert_eq!(count() - before, 0);
    }
}

#[test]
fn external_additions_agree_on_any_number_of_ranks() {
    let test = "extending::external_additions_agree_on_any_number_of_ranks";
    let said = in_processes(test, &[(1, ""), (2, ""), (4, "")], |session| {
        let mut scene = swept(session, DISCS);
        (0..10).for_each(|_| _ = scene.step(2e-3).unwrap());
        let (e, free) = (&scene.state.energy, &scene.state.bodies[0]);
        if session.rank() == 0 {
            println!("state {:?}", [e.drive, e.fluid, e.boundaries, free.velocity.x, free.spin.z]);
        }
    });
    let state = |said: &String| -> Vec<f64> {
        let line = said.lines().find_map(|line| line.split("state [").nth(1)).unwrap();
        line.trim_end_matches(']').split(", ").map(|x| x.parse().unwrap()).collect()
    };
    let states: Vec<Vec<f64>> = said.iter().map(state).collect();
    println!("{states:?}");
    for (one, many) in states.iter().skip(1).flat_map(|many| states[0].iter().zip(many)) {
        assert!((one - many).abs() < 1e-6 * one.abs(), "{states:?}");
    }
}

#[test]
fn external_duplicate_measure_and_other_dimension_are_refused() {
    let (_petsc, dir) = (petsc(), tempfile::tempdir().unwrap());
    run_extended(dir.path(), "run", 0.02, false, "").unwrap();
    let request = |out: &str| Request {
        case: dir.path().join("case.toml"),
        out: Some(dir.path().join(out)),
        set: Vec::new(),
        force: false,
        resume: false,
        quiet: true,
        petsc: Vec::new(),
        draw: |_| Ok(Vec::new()),
        commit: "",
    };
    let refused = run_with::<3>(&request("a"), Extensions::default()).unwrap_err().to_string();
    assert!(refused.contains("2 dimensions"), "{refused}");
    let twice: Vec<Box<dyn Measure<2>>> =
        vec![Box::new(LargestEnergy::default()), Box::new(LargestEnergy::default())];
    let added = Extensions { measures: twice, ..Extensions::default() };
    let refused = run_with(&request("b"), added).unwrap_err().to_string();
    assert!(refused.contains("largest_energy"), "{refused}");
}

/// What stands in a source between the marks `// [name]` and `// [end]`, without its indentation.
fn marked(source: &str, name: &str) -> String {
    let (_, rest) = source.split_once(&format!("// [{name}]\n")).expect("the mark is there");
    let (part, _) = rest.split_once("// [end]").expect("the part ends");
    let part = part.trim_end();
    let indent = part.len() - part.trim_start().len();
    let lines = part.lines().map(|line| line.get(indent..).unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn extending_page_quotes_this_file() {
    let page = std::fs::read_to_string(shipped("docs/extending.md")).unwrap();
    for name in ["run", "force", "side", "measure", "output"] {
        let part =
            marked(concat!(include_str!("extending_force.rs"), include_str!("extending.rs")), name);
        assert!(page.contains(&format!("```rust\n{part}\n```")), "{name} of the page differs");
    }
    let words = page.split_whitespace().count();
    assert!(words <= 1200, "{words} words");
}
