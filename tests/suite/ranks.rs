//! A run on 1, 2 and 4 ranks gives the same answer to the solver's tolerance, in 2D and 3D,
//! periodic and not.

use crate::modes::in_processes;
use crate::support::{columns, run_on_ranks, summary};
use mics::grid::Grid;
use mics::petsc::Layout;
use mics_run::snapshot::Snapshot;
use std::path::{Path, PathBuf};

fn snapshots(out: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(out.join("fields")).unwrap().map(|e| e.unwrap().path());
    let mut paths: Vec<_> = entries.filter(|p| p.extension().unwrap() == "vti").collect();
    paths.sort();
    paths
}

/// Runs a case on 1, 2 and 4 ranks and compares forces, divergence and fields.
fn expect_the_same(text: &str) {
    expect_the_same_on([1, 2, 4], text);
}

/// Runs a case on other numbers of ranks, and compares with the first of them.
fn expect_the_same_on<const N: usize>(ranks: [usize; N], text: &str) {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    std::fs::write(&case, text).unwrap();
    let out = ranks.map(|ranks| {
        let out = dir.path().join(ranks.to_string());
        run_on_ranks(ranks, &case, &out);
        summary(&out);
        out
    });
    let alone = columns(&out[0].join("particles.csv"));
    let fields: Vec<Snapshot> =
        snapshots(&out[0]).iter().map(|p| Snapshot::read(p).unwrap()).collect();
    for shared in &out[1..] {
        let together = columns(&shared.join("particles.csv"));
        assert_eq!(alone["step"], together["step"]);
        let scale = alone["fluid_fx"].iter().skip(1).map(|f| f.abs()).fold(0.0, f64::max);
        for name in [
            "fluid_fx",
            "fluid_fy",
            "fluid_fz",
            "pressure_fx",
            "viscous_fx",
            "convective_fx",
            "fluid_tz",
        ] {
            let gap = alone[name]
                .iter()
                .zip(&together[name])
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(
                gap < 1e-6 * scale,
                "{name} differs by {gap:e} of {scale:e} in {}",
                shared.display()
            );
        }
        // A contact tells by its force where it begins, and passes small differences on.
        for name in ["x", "y", "z", "angle", "vx", "vy", "wz"] {
            let gap = alone[name]
                .iter()
                .zip(&together[name])
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(gap < 1e-6, "{name} differs by {gap:e} in {}", shared.display());
        }
        for (a, path) in fields.iter().zip(snapshots(shared)) {
            let b = Snapshot::read(&path).unwrap();
            for (a, b) in a.arrays.iter().zip(&b.arrays) {
                let size = a.values.iter().map(|v| v.abs()).fold(0.0, f64::max);
                let gap =
                    a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                // Vorticity divides velocities by a cell's width.
                assert!(gap <= 1e-6 * size.max(1e-6), "{} differs by {gap:e} of {size:e}", a.name);
            }
        }
    }
}

const DISC: &str = "shape = { disc = { diameter = 0.3 } }";

#[test]
fn ranks_agree_2d_inflow_outflow() {
    expect_the_same(&format!(
        "name = \"r\"\n[domain]\nsize = [2.0, 1.0]\ncells = [48, 24]\n[fluid]\ndensity = 1.0\n\
        viscosity = 0.01\n[boundary]\n\
         west = {{ inflow_parabola = [1.0, 0.0] }}\neast = \"outflow\"\nsouth = \"wall\"\n\
             north = \"wall\"\n\
         [[particle]]\n{DISC}\nposition = [0.97, 0.51]\nmotion = \"fixed\"\n[initial]\n\
             perturbation = 0.1\n\
         [coupling]\nwall = \"sharp\"\n[time]\nend = 0.1\nstep = 0.01\n[pressure]\n\
             divergence_limit = 1.0e-9"
    ));
}

#[test]
fn ranks_agree_2d_periodic_mixing() {
    expect_the_same(&format!(
        "name = \"r\"\n[domain]\nsize = [1.0, 1.0]\ncells = [24, 24]\n[fluid]\ndensity = 1.0\n\
        viscosity = 0.01\n[boundary]\n\
         west = \"periodic\"\neast = \"periodic\"\nsouth = \"periodic\"\nnorth = \"periodic\"\n\
         [[particle]]\n{DISC}\nposition = [0.9, 0.45]\ndensity = 2.65\nviscosity = 0.0\n\
         motion = {{ prescribed = {{ velocity = [1.0, 0.3], spin = 3.0 }} }}\n[coupling]\n\
         wall = \"mixing\"\n\
         [time]\nend = 0.15\nstep = 0.01\n[pressure]\ndivergence_limit = 1.0e-9"
    ));
}

#[test]
fn ranks_agree_3d_inflow_outflow() {
    expect_the_same(
        "name = \"r\"\n[domain]\nsize = [1.5, 1.0, 1.0]\ncells = [24, 16, 16]\n[fluid]\n\
        density = 1.0\nviscosity = 0.02\n\
         [boundary]\nwest = { inflow = [1.0, 0.0, 0.0] }\neast = \"outflow\"\nsouth = \"wall\"\n\
             north = \"slip\"\n\
         bottom = \"wall\"\ntop = \"slip\"\n[[particle]]\nshape = { sphere = { diameter = 0.4 } }\n\
         position = [0.72, 0.5, 0.55]\nmotion = \"fixed\"\n[coupling]\nwall = \"sharp\"\n[time]\n\
             end = 0.08\nstep = 0.01\n\
         [pressure]\ndivergence_limit = 1.0e-9",
    );
}

#[test]
fn ranks_agree_colliding_discs_crossing_subdomains() {
    let free = |place: [f64; 2], density: f64, velocity: [f64; 2]| {
        format!(
            "[[particle]]\n{DISC}\nposition = {place:?}\ndensity = {density:?}\n\
            velocity = {velocity:?}\n"
        )
    };
    expect_the_same(&format!(
        "name = \"r\"\n[domain]\nsize = [1.2, 1.0]\ncells = [30, 25]\n[fluid]\ndensity = 1.0\n\
        viscosity = 0.01\n\
         gravity = [0.3, -1.0]\n[boundary]\nwest = \"periodic\"\neast = \"periodic\"\n\
             south = \"wall\"\n\
         north = \"slip\"\n{}{}{}[contact]\nnormal_stiffness = 500.0\nfriction = 0.3\n\
             restitution = 0.6\n\
         [coupling]\nwall = \"sharp\"\n[time]\nend = 0.2\nstep = 0.008\n[pressure]\n\
             divergence_limit = 1.0e-9",
        free([1.1, 0.5], 2.65, [0.8, 0.0]),
        free([0.25, 0.5], 50.0, [-0.3, 0.1]),
        free([0.6, 0.16], 0.8, [0.0, -0.2]),
    ));
}

#[test]
fn ranks_agree_colliding_spheres_crossing_subdomains() {
    let free = |place: [f64; 3], density: f64, velocity: [f64; 3]| {
        format!(
            "[[particle]]\nshape = {{ sphere = {{ diameter = 0.4 }} }}\nposition = {place:?}\n\
            density = {density:?}\nvelocity = {velocity:?}\n"
        )
    };
    expect_the_same(&format!(
        "name = \"r\"\n[domain]\nsize = [1.0, 1.0, 1.0]\ncells = [16, 16, 16]\n[fluid]\n\
        density = 1.0\nviscosity = 0.02\n\
         gravity = [0.0, -1.0, 0.0]\n[boundary]\nwest = \"periodic\"\neast = \"periodic\"\n\
             south = \"wall\"\nnorth = \"slip\"\n\
         bottom = \"periodic\"\ntop = \"periodic\"\n{}{}[contact]\nfriction = 0.3\n\
             restitution = 0.6\n\
         [coupling]\nwall = \"sharp\"\n[time]\nend = 0.15\nstep = 0.01\n[pressure]\n\
             divergence_limit = 1.0e-9",
        free([0.85, 0.5, 0.5], 2.65, [0.6, 0.0, 0.1]),
        free([0.32, 0.45, 0.6], 20.0, [-0.3, -0.2, 0.0]),
    ));
}

#[test]
fn division_of_cells_is_petscs_on_six_ranks() {
    in_processes("ranks::division_of_cells_is_petscs_on_six_ranks", &[(6, "")], |session| {
        let cells = [14, 11, 9];
        let layout = Layout::new(session, &cells, &[false; 3], 3).unwrap();
        let Grid { start, local, division, .. } =
            Grid::new(cells, [1.4, 1.1, 0.9], [false; 3], &layout);
        let last = std::array::from_fn(|a| start[a] + local[a] - 1);
        assert_eq!([start, last].map(|cell| division.owner(cell)), [session.rank(); 2]);
        let mut owners = Vec::new();
        division.owners(start, last, |rank| owners.push(rank));
        assert_eq!(owners, [session.rank()]);
    });
}

/// A row of discs that touch lies over three of nine ranks and moves on over the corners between
/// them, with lone discs elsewhere: most bodies reach few of the ranks, some reach four, and which
/// changes.
#[test]
fn ranks_agree_chain_of_discs_over_nine_ranks() {
    let disc = |place: [f64; 2], velocity: [f64; 2]| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.125 }} }}\nposition = {place:?}\n\
            density = 2.65\nvelocity = {velocity:?}\n"
        )
    };
    let chain: String =
        (0..6).map(|k| disc([0.2 + 0.1249 * f64::from(k), 0.37], [0.5, -0.4])).collect();
    let others = disc([0.93, 0.66], [0.8, 0.1]) + &disc([0.5, 0.85], [0.0, -0.6]);
    expect_the_same_on(
        [1, 4, 9],
        &format!(
            "name = \"r\"\n[domain]\nsize = [1.0, 1.0]\ncells = [48, 48]\n[fluid]\n\
            density = 1.0\nviscosity = 0.01\ngravity = [0.3, -1.0]\n[boundary]\n\
            west = \"periodic\"\neast = \"periodic\"\nsouth = \"wall\"\nnorth = \"wall\"\n\
            {chain}{others}[contact]\nnormal_stiffness = 500.0\nfriction = 0.3\n\
            restitution = 0.6\n[coupling]\nwall = \"sharp\"\n[time]\nend = 0.12\n\
            step = 0.004\n[pressure]\ndivergence_limit = 1.0e-10"
        ),
    );
}

#[test]
fn ranks_agree_mean_velocity_drive_with_falling_bodies() {
    for (wall, held) in [
        ("sharp", "mean_velocity = { axis = \"x\", value = 0.3 }"),
        ("mixing", "mean_velocity = { axis = \"x\", value = 0.3 }"),
    ] {
        expect_the_same(&format!(
            "name = \"r\"\n[domain]\nsize = [1.0, 1.0]\ncells = [24, 24]\n[fluid]\ndensity = 1.0\n\
            viscosity = 0.01\n\
             gravity = [0.2, -1.0]\n[drive]\n{held}\n[boundary]\nwest = \"periodic\"\n\
                 east = \"periodic\"\n\
             south = \"wall\"\nnorth = \"wall\"\n[[particle]]\n{DISC}\nposition = [0.9, 0.45]\n\
                 density = 2.65\n\
             [coupling]\nwall = \"{wall}\"\n[time]\nend = 0.1\nstep = 0.01\n[pressure]\n\
                 divergence_limit = 1.0e-9"
        ));
    }
}
