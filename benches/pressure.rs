//! The pressure solve by itself: assembly, setup and C-HSMAC to the same D0 while discs move, for each choice of solver.
//!
//! `cargo bench --bench pressure [-- FILTER]`; the names are `grid/coefficient/solver`.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use mics::case::load;
use mics::fluid::faces::FaceCoefficient;
use mics::grid::{Coefficient, VectorField};
use mics::petsc::Session;
use mics::scene::Scene;
use std::time::{Duration, Instant};

/// D0 over the largest divergence at the start.
const REDUCTION: f64 = 1e-6;

/// How far discs move in a step, in spacings.
const STEP: f64 = 0.05;

/// What fills a quarter (2D) or a sixth (3D) of the box: balls of five spacings' radius on a disturbed lattice.
#[derive(Clone, Copy)]
enum Coefficients {
    Uniform,
    /// A mixture of this ratio of densities.
    Ratio(f64),
    /// Closed inside.
    Closed,
}

struct Bench<const D: usize> {
    scene: Scene<D>,
    start: VectorField<D>,
    coefficients: Coefficients,
    moved: f64,
}

impl<const D: usize> Bench<D> {
    fn new(session: &Session, cells: [usize; D], coefficients: Coefficients, solver: &str) -> Bench<D> {
        let size = cells.map(|n| n as f64 / cells[0] as f64);
        let gravity = vec![0.0; D];
        let walls = if D == 3 { "bottom = \"wall\"\ntop = \"wall\"" } else { "" };
        let text = format!(
            "name = \"bench\"\n[domain]\nsize = {size:?}\ncells = {cells:?}\n[fluid]\ndensity = 1.0\nviscosity = 0.0\n\
             gravity = {gravity:?}\n[boundary]\nwest = \"wall\"\neast = \"wall\"\nsouth = \"wall\"\nnorth = \"wall\"\n{walls}\n\
             [time]\nend = 1.0\n[pressure]\nmax_iterations = 50\nsolver = \"{solver}\"\ndivergence_limit = {:e}",
            REDUCTION * cells[0] as f64
        );
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("case.toml");
        std::fs::write(&path, text).expect("a file");
        let case = load(&path, &[]).unwrap_or_else(|e| panic!("{e}")).case;
        let mut scene = Scene::<D>::new(session, &case).unwrap_or_else(|e| panic!("{e}"));
        let grid = scene.grid.clone();
        for axis in 0..D {
            for c in grid.face_rows(axis).flatten() {
                let at = grid.centre(c);
                scene.faces[axis][c] = (0..D).map(|a| ((7.3 + a as f64 + axis as f64) * at[a] * 5.0).sin()).product();
            }
        }
        scene.boundaries.set_faces(&mut scene.faces);
        let start = scene.faces.clone();
        Bench { scene, start, coefficients, moved: 0.0 }
    }

    /// Moves the discs on, and sets the coefficient there.
    fn advance(&mut self) {
        self.moved += STEP;
        let (grid, moved) = (self.scene.grid.clone(), self.moved);
        let pitch = if D == 2 { 17.7 } else { 14.6 };
        // The part of a ball about a point, smoothed over a spacing.
        let inside = |at: [f64; D]| {
            let mut square = 0.0;
            let mut shift = 0.0;
            for a in (0..D).rev() {
                let x = at[a] / grid.h[a] + if a == 0 { moved + shift } else { 0.37 * shift };
                let n = (x / pitch).floor();
                shift += 7.9 * n;
                square += (x - (n + 0.5) * pitch).powi(2);
            }
            (5.5 - square.sqrt()).clamp(0.0, 1.0)
        };
        match self.coefficients {
            Coefficients::Uniform => {}
            Coefficients::Ratio(ratio) => {
                let mut density = grid.field();
                for c in grid.rows().flatten() {
                    density[c] = 1.0 + (ratio - 1.0) * inside(grid.centre(c));
                }
                self.scene.boundaries.fill_property(&mut density).expect("ghosts");
                let density = Coefficient::Field(density);
                self.scene.beta = FaceCoefficient::new(&grid, &density);
                self.scene.beta.update(&grid, &density);
            }
            Coefficients::Closed => {
                let mut beta = grid.vector_field();
                for axis in 0..D {
                    for c in grid.face_rows(axis).flatten() {
                        let mut at = grid.centre(c);
                        at[axis] -= 0.5 * grid.h[axis];
                        beta[axis][c] = (1.0 - inside(at)).max(1e-6);
                    }
                }
                self.scene.beta = FaceCoefficient::Field(beta);
            }
        }
    }

    /// A step's work for the pressure: what it took.
    fn solve(&mut self) -> Duration {
        self.advance();
        for (faces, start) in self.scene.faces.iter_mut().zip(&self.start) {
            faces.copy_from_slice(start);
        }
        let scene = &mut self.scene;
        let begin = Instant::now();
        if !matches!(self.coefficients, Coefficients::Uniform) {
            scene.projection.assemble(&scene.grid, &scene.beta).expect("assembled");
        }
        let (p, faces) = (&mut scene.p, &mut scene.faces);
        let done = scene.projection.project(&scene.grid, &mut scene.boundaries, &scene.beta, 1e-3, p, faces, None);
        let took = begin.elapsed();
        if std::env::var_os("MICS_BENCH_ITERATIONS").is_some() {
            println!("{done:?}");
        }
        done.expect("solved");
        took
    }
}

fn run<const D: usize>(c: &mut Criterion, session: &Session, cells: [usize; D]) {
    let size = cells.map(|n| n.to_string()).join("x");
    let mut group = c.benchmark_group(&size);
    group.sample_size(10).measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(300));
    for (name, coefficients, solvers) in [
        ("uniform", Coefficients::Uniform, &["direct", "multigrid", "bcgs-boomeramg"][..]),
        ("s2.65", Coefficients::Ratio(2.65), &["multigrid", "bcgs-boomeramg"]),
        ("s1000", Coefficients::Ratio(1000.0), &["multigrid", "bcgs-boomeramg"]),
        ("closed", Coefficients::Closed, &["multigrid", "bcgs-boomeramg"]),
    ] {
        for solver in solvers {
            let mut bench = None;
            group.bench_function(BenchmarkId::new(name, solver), |b| {
                let bench = bench.get_or_insert_with(|| Bench::new(session, cells, coefficients, solver));
                b.iter_custom(|times| (0..times).map(|_| bench.solve()).sum());
            });
        }
    }
    group.finish();
}

fn pressure(c: &mut Criterion) {
    let session = Session::start(&[]).expect("PETSc starts");
    run(c, &session, [160, 64]);
    run(c, &session, [1024, 1024]);
    run(c, &session, [64, 64, 64]);
}

criterion_group!(benches, pressure);
criterion_main!(benches);
