//! Times of the passes over the grid, beside what the memory of the machine allows.
//!
//! `cargo bench --bench roofline [-- CELLS]` prints, for boxes of CELLS x CELLS x CELLS cells (128
//! by default) and of as many cells in a square, what each pass reads and writes at least (bytes a
//! cell, every number once), its time (the least of several), its bandwidth, and the part that this
//! is of the bandwidth of `a = b + s c` over arrays that no cache holds. A pass that reads
//! neighbours in other planes reads them again where a cache does not keep them, and computes
//! meanwhile; far below the bandwidth it is bound by that. On one core, as long as the machine does
//! nothing else.

use mics::config::load;
use mics::kernels::advection::{Carrier, Fluxes, upwind5};
use mics::kernels::faces;
use mics::petsc::Session;
use mics::scene::Scene;
use std::hint::black_box;
use std::time::Instant;

/// Numbers of each array of the yardstick: 64 MB, and three of them.
const NUMBERS: usize = 8 << 20;
/// Times that each pass is taken.
const TIMES: usize = 7;

/// The least seconds of several.
fn seconds(mut pass: impl FnMut()) -> f64 {
    let once = |_| {
        let began = Instant::now();
        pass();
        began.elapsed().as_secs_f64()
    };
    (0..TIMES).map(once).fold(f64::INFINITY, f64::min)
}

/// Bytes a second of `a = b + s c`, where each number is read or written once.
fn bandwidth() -> f64 {
    let (mut a, b, c) = (vec![0.0; NUMBERS], vec![1.0; NUMBERS], vec![2.0; NUMBERS]);
    let taken = seconds(|| {
        let s = black_box(3.0);
        a.iter_mut().zip(b.iter().zip(&c)).for_each(|(a, (b, c))| *a = b + s * c);
        black_box(&a);
    });
    3.0 * 8.0 * NUMBERS as f64 / taken
}

/// Prints a row: a pass that reads and writes so many numbers a cell.
fn row(name: &str, cells: usize, numbers: usize, bandwidth: f64, pass: impl FnMut()) {
    let (taken, bytes) = (seconds(pass), 8 * numbers);
    let reached = (bytes * cells) as f64 / taken;
    println!(
        "| {name} | {bytes} | {:.2} | {:.1} | {:.0} % |",
        1e9 * taken / cells as f64,
        1e-9 * reached,
        100.0 * reached / bandwidth
    );
}

/// The passes over a closed box of this case.
fn passes<const D: usize>(session: &Session, text: &str, bandwidth: f64) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.toml");
    std::fs::write(&path, text).expect("a file");
    let case = load(&path, &[]).unwrap_or_else(|e| panic!("{e}")).case;
    let mut scene = Scene::<D>::new(session, &case).unwrap_or_else(|e| panic!("{e}"));
    let (grid, cells) = (scene.domain.grid.clone(), scene.domain.grid.total_cells());
    let (mut rate, mut fluxes) = (grid.vector_field(), Fluxes::new(&grid));
    let (mut out, beta) = (grid.field(), scene.method.beta().clone());
    let state = &mut scene.state;
    println!("\n{}:\n", grid.cells.map(|n| n.to_string()).join(" x "));
    println!(
        "| pass | bytes a cell | ns a cell | GB/s | of the bandwidth |\n|---|---|---|---|---|"
    );
    for (name, fresh, numbers) in
        [("first stage of the momentum", true, 3 * D), ("a later stage", false, 4 * D)]
    {
        let carrier = Carrier { now: &state.faces, before: None };
        let u = &state.u;
        row(name, cells, numbers, bandwidth, || {
            upwind5(&grid, &carrier, u, 0.01, 0.5, fresh, &mut rate, &mut fluxes)
        });
    }
    let a = grid.vector_field();
    let mut next = grid.vector_field();
    row("the sum of the stages", cells, 4 * D, bandwidth, || {
        faces::step_cells(&grid, &state.u, 1e-9, &rate, 1e-9, &a, &mut next)
    });
    row("faces from cells", cells, 3 * D, bandwidth, || {
        faces::predict(&grid, &state.u, true, 1e-9, &a, &mut state.faces)
    });
    row("divergence", cells, D + 1, bandwidth, || faces::divergence(&grid, &state.faces, &mut out));
    row("gradient of the pressure", cells, 2 * D + 1, bandwidth, || {
        faces::add_gradient(&grid, &beta, 1e-9, &state.p, &mut state.faces)
    });
    row("cells by their faces", cells, 3 * D, bandwidth, || {
        faces::add_to_cells(&grid, 1e-9, &a, &mut state.u)
    });
    row("the largest speed", cells, D, bandwidth, || {
        black_box(faces::fastest(&grid, &state.faces));
    });
    // Ghosts take by far the most time where they lie at the ends of rows.
    row("ghosts of a velocity, by cell", cells, 0, bandwidth, || {
        scene.domain.boundaries.fill_stencils(&mut state.u).unwrap_or_else(|e| panic!("{e}"))
    });
}

/// A fluid at rest in a closed box.
fn closed_box(cells: usize, dimension: usize) -> String {
    let sides = ["west", "east", "south", "north", "bottom", "top"];
    let walls: String =
        sides[..2 * dimension].iter().map(|s| format!("{s} = \"wall\"\n")).collect();
    format!(
        "name = \"roofline\"\ntime.end = 1.0\nfluid = {{ density = 1.0, viscosity = 0.01 }}\n\
         domain = {{ size = {:?}, cells = {:?} }}\n[boundary]\n{walls}",
        vec![1.0; dimension],
        vec![cells; dimension]
    )
}

fn main() {
    let given = std::env::args().filter_map(|word| word.parse().ok()).next();
    let cells: usize = given.unwrap_or(128);
    let session = Session::start(&[]).unwrap_or_else(|e| panic!("{e}"));
    let bandwidth = bandwidth();
    println!("a = b + s c: {:.1} GB/s", 1e-9 * bandwidth);
    passes::<3>(&session, &closed_box(cells, 3), bandwidth);
    passes::<2>(&session, &closed_box((cells as f64).powf(1.5) as usize, 2), bandwidth);
}
