//! Pressure and shear on the surfaces of bodies and obstacles, and the files that have them.

use crate::support::{MIXING, STREAM, box_case, petsc, run, run_on_ranks};
use mics::scene::Scene;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// The largest difference of the pressure on the bodies from that of a fluid at rest under a
/// uniform force (N/m3), over the largest difference of that between two points, and the largest
/// shear over the same.
fn errors<const D: usize>(scene: &mut Scene<D>, force: Vector3<f64>) -> [f64; 2] {
    let all = scene.method.tractions(&mut scene.domain, &mut scene.state).unwrap();
    let exact = |k: usize| {
        let t = &all[k];
        force.dot(&(scene.state.bodies[t.body].centre + t.arm))
    };
    // The pressure of a closed box is known up to a constant.
    let errors: Vec<f64> = (0..all.len()).map(|k| all[k].pressure - exact(k)).collect();
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let ends = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        high - low
    };
    let shear = all.iter().map(|t| t.shear.norm()).fold(0.0, f64::max);
    let largest = range(&mut (0..all.len()).map(exact));
    let error = range(&mut errors.into_iter()) / largest;
    println!("{} points: error {error:.1e}, shear {:.1e}", all.len(), shear / largest);
    assert!(all.len() > 100);
    [error, shear / largest]
}

/// Gives the cells the pressure of a fluid at rest under a uniform force (N/m3).
fn rest<const D: usize>(scene: &mut Scene<D>, force: Vector3<f64>) {
    let grid = &scene.domain.grid;
    let exact = |c: usize| (0..D).map(|a| force[a] * grid.centre(c)[a]).sum::<f64>();
    grid.rows().flatten().for_each(|c| scene.state.p[c] = exact(c));
}

/// Discs, a sphere and bodies with flat sides, near to each other and to the sides of the box: by
/// the exact pressure of the cells, and by that which the method finds.
#[test]
fn surface_pressure_of_fluid_at_rest_is_linear() {
    let petsc = petsc();
    let sides = ["\"wall\""; 4];
    let square = "polygon = { points = [[0, 0], [0.3, 0], [0.3, 0.2], [0, 0.2]] }";
    let body = |shape: &str, place: &str, more: &str| {
        format!(
            "[[particle]]\nshape = {{ {shape} }}\nposition = {place}\nmotion = \"fixed\"\n{more}\n"
        )
    };
    let flat = body("disc = { diameter = 0.3 }", "[0.3, 0.4]", "")
        + &body("disc = { diameter = 0.3 }", "[0.62, 0.4]", "")
        + &body(square, "[0.7, 0.8]", "orientation = 30.0")
        + "[drive]\nforce = [50.0, 30.0]\n[pressure]\ndivergence_limit = 1e-10\n";
    let text = box_case([1.0, 1.0], [32, 32], 0.1, sides, &flat);
    let force = Vector3::new(50.0, 30.0, 0.0);
    let mut scene = petsc.scene::<2>(&text);
    rest(&mut scene, force);
    assert!(errors(&mut scene, force).iter().all(|error| *error < 1e-6));
    let mut scene = petsc.scene::<2>(&text);
    (0..1000).for_each(|_| _ = scene.step(1e-3).unwrap());
    assert!(errors(&mut scene, force).iter().all(|error| *error < 2e-3));
    let space = body("sphere = { diameter = 0.4 }", "[0.3, 0.3, 0.4]", "")
        + &body("ellipsoid = { axes = [0.4, 0.3, 0.2] }", "[0.7, 0.7, 0.6]", "")
        + "[drive]\nforce = [50.0, 30.0, -20.0]\n[pressure]\ndivergence_limit = 1e-10\n";
    let text = box_case([1.0, 1.0], [20, 20], 0.1, sides, &space)
        .replace("size = [1.0, 1.0]", "size = [1.0, 1.0, 1.0]")
        .replace("cells = [20, 20]", "cells = [20, 20, 20]")
        .replace("[boundary]", "[boundary]\nbottom = \"wall\"\ntop = \"wall\"");
    let force = Vector3::new(50.0, 30.0, -20.0);
    let mut scene = petsc.scene::<3>(&text);
    rest(&mut scene, force);
    assert!(errors(&mut scene, force).iter().all(|error| *error < 1e-6));
}

const DISC: &str = "[[particle]]\nshape = { disc = { diameter = 0.25 } }\nposition = [0.61, 0.47]\n\
    motion = \"fixed\"\n";

/// The shear is that of the force, which is of the step and not of its end; the pressure has
/// another integral than the force on faces.
#[test]
fn tractions_on_disc_in_stream_sum_to_its_force() {
    let petsc = petsc();
    let more = format!("[initial]\nvelocity = [1.0, 0.0]\n{DISC}");
    let mut scene: Scene<2> =
        petsc.scene(&box_case([2.0, 1.0], [128, 64], 0.25 / 40.0, STREAM, &more));
    (0..100).for_each(|_| _ = scene.step(0.005).unwrap());
    let all = scene.method.tractions(&mut scene.domain, &mut scene.state).unwrap();
    let shear: Vector3<f64> = all.iter().map(|t| t.area * t.shear).sum();
    let pressure: Vector3<f64> = all.iter().map(|t| -t.area * t.pressure * t.arm.normalize()).sum();
    let exact = scene.state.exchange[0];
    let apart = (shear - exact.viscous).norm() / exact.viscous.norm();
    let apart_of_pressure = (pressure - exact.pressure).norm() / exact.pressure.norm();
    println!("shear {apart:.1e} from its force, pressure {apart_of_pressure:.1e}");
    assert!(apart < 1e-3, "{shear} {}", exact.viscous);
    assert!(apart_of_pressure < 0.02, "{pressure} {}", exact.pressure);
}

/// The newest file with this beginning of its name.
fn newest(out: &Path, prefix: &str) -> PathBuf {
    let all = std::fs::read_dir(out.join("fields")).unwrap().map(|entry| entry.unwrap().path());
    let own = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().starts_with(prefix);
    all.filter(own).max().unwrap()
}

/// An array of a file of surfaces; `None` where it has none of the name.
fn array(file: &Path, name: &str) -> Option<Vec<f64>> {
    let text = std::fs::read_to_string(file).unwrap();
    let from = text.find(&format!("Name=\"{name}\""))?;
    let values = text[from..].split(['>', '<']).nth(1).unwrap();
    Some(values.split_ascii_whitespace().map(|number| number.parse().unwrap()).collect())
}

/// Couette flow of a lid over a bed: mu U over the depth of 0.079 m.
#[test]
fn shear_on_bed_under_lid_is_exact_in_obstacle_file() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("bed.csv"), "x,y\n0.05,0.021\n0.07,0.021\n").unwrap();
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "{ moving_wall = [0.1, 0.0] }"];
    let more = "[[obstacle]]\nheights = { file = \"bed.csv\" }\n\
        [output]\nfigures = false\nsurfaces = true\n[time]\nend = 1.5\nstep = 0.004\n\
        [[measure]]\nname = \"bed\"\nkind = \"bed_shear_stress\"\nobstacle = 0\nfrom = 1.4\n";
    let text = box_case([0.1, 0.1], [32, 32], 10.0, sides, more)
        .replace("density = 1.0\n", "density = 1000.0\ngravity = [0.0, -9.81]\n");
    let case = dir.path().join("case.toml");
    std::fs::write(&case, text).unwrap();
    let out = dir.path().join("out");
    let summary = run(&case, &out, &[]);
    let exact = 10.0 * 0.1 / 0.079;
    let found = summary["measures"]["bed"].as_f64().unwrap();
    let file = newest(&out, "obstacles-");
    let shear = array(&file, "shear").unwrap();
    let error = shear.chunks(3).map(|s| (s[0] - exact).abs().max(s[1].abs())).fold(0.0, f64::max);
    println!("{exact} Pa: the measure {found}, {} points within {error:.1e}", shear.len() / 3);
    assert!((found / exact - 1.0).abs() < 1e-6 && error < 1e-6 * exact && shear.len() > 30);
    let pressure = array(&file, "pressure").unwrap();
    assert!(pressure.iter().all(|p| p.abs() < 1e-6 * exact), "{pressure:?}");
}

/// The arrays of a disc in a stream, without the key, with the mixture method, and on two ranks.
#[test]
fn surface_arrays_on_ranks_and_where_there_are_none() {
    let dir = tempfile::tempdir().unwrap();
    let written = |name: &str, more: &str| {
        let more = format!(
            "[initial]\nvelocity = [1.0, 0.0]\n{DISC}{more}\n[time]\nend = 0.1\nstep = 0.005\n"
        );
        let text = box_case([1.2, 1.0], [48, 40], 0.01, STREAM, &more);
        let case = dir.path().join(format!("{name}.toml"));
        std::fs::write(&case, text).unwrap();
        case
    };
    let on = "[output]\nfigures = false\nsurfaces = true\n";
    let without = written("without", "[output]\nfigures = false\n");
    let mixture = written("mixture", &format!("{MIXING}{on}"));
    for case in [without, mixture] {
        let out = case.with_extension("out");
        run(&case, &out, &[]);
        let file = newest(&out, "bodies-");
        assert_eq!(array(&file, "id").unwrap().len(), 1, "{}", file.display());
        assert!(array(&file, "pressure").is_none() && array(&file, "shear").is_none());
    }
    let case = written("with", on);
    let files = [1, 2].map(|ranks| {
        let out = dir.path().join(ranks.to_string());
        run_on_ranks(ranks, &case, &out);
        newest(&out, "bodies-")
    });
    for name in ["Points", "pressure", "shear"] {
        let [alone, shared] = [0, 1].map(|k: usize| array(&files[k], name).unwrap());
        let largest = alone.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        let apart = alone.iter().zip(&shared).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{name}: {} numbers, {apart:.1e} of {largest:.1e} apart", alone.len());
        assert!(alone.len() > 30 && alone.len() == shared.len() && apart < 1e-6 * largest);
    }
}
