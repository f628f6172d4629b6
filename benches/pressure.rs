//! The pressure solve by itself: assembly, setup and C-HSMAC to the same D0 while discs move, for
//! each choice of solver.
//!
//! `cargo bench --bench pressure [-- FILTER]`; the names are `grid/coefficient/solver`.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use mics::config::load;
use mics::grid::{Coefficient, Grid, VectorField};
use mics::kernels::faces::FaceCoefficient;
use mics::method::flow::Flow;
use mics::petsc::Session;
use mics::poisson::ModeFace;
use mics::poisson::pressure::Coupled;
use mics::scene::Scene;
use mics::sharing::Sharing;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::time::{Duration, Instant};

/// D0 over the largest divergence at the start.
const REDUCTION: f64 = 1e-6;

/// Displacement of the discs in a step, in spacings.
const STEP: f64 = 0.05;

/// Coefficients in the balls that fill a quarter (2D) or a sixth (3D) of the box, of five spacings'
/// radius on a disturbed lattice.
#[derive(Clone, Copy)]
enum Coefficients {
    Uniform,
    /// A mixture of this ratio of densities.
    Ratio(f64),
    /// Closed inside.
    Closed,
    /// Closed inside, and free to move: bodies of this density over the fluid's.
    Free(f64),
}

struct Bench<const D: usize> {
    scene: Scene<D>,
    start: VectorField<D>,
    coefficients: Coefficients,
    moved: f64,
    /// Free bodies in the operator: weights of their modes, and the faces that they cover.
    weights: Vec<f64>,
    covered: Vec<ModeFace>,
}

/// The free bodies, whose velocity follows the pressure.
struct Bodies<'a, const D: usize> {
    weights: &'a [f64],
    covered: &'a [ModeFace],
    faces: &'a mut VectorField<D>,
}

impl<const D: usize> Coupled<D> for Bodies<'_, D> {
    fn faces(&mut self) -> &mut VectorField<D> {
        self.faces
    }

    fn begin(&mut self, _: &Grid<D>, _: f64) -> mics::Result<()> {
        Ok(())
    }

    fn follow(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64]) -> mics::Result<()> {
        for mode in self.covered.chunk_by(|a, b| a.mode == b.mode) {
            let k = mode[0].mode as usize;
            let (axis, h) = (k % D, grid.h[k % D]);
            let slope =
                |e: &ModeFace| phi[e.face as usize] - phi[e.face as usize - grid.stride[axis]];
            let change =
                -dt * self.weights[k] * mode.iter().map(|e| e.part * slope(e) / h).sum::<f64>();
            mode.iter().for_each(|e| self.faces[axis][e.face as usize] += e.part * change);
        }
        Ok(())
    }
}

impl<const D: usize> Bench<D> {
    fn new(
        session: &Session,
        cells: [usize; D],
        coefficients: Coefficients,
        solver: &str,
    ) -> Bench<D> {
        let size = cells.map(|n| n as f64 / cells[0] as f64);
        let gravity = vec![0.0; D];
        let walls = if D == 3 { "bottom = \"wall\"\ntop = \"wall\"" } else { "" };
        let text = format!(
            "name = \"bench\"\n[domain]\nsize = {size:?}\ncells = {cells:?}\n[fluid]\n\
            density = 1.0\nviscosity = 0.0\n\
             gravity = {gravity:?}\n[boundary]\nwest = \"wall\"\neast = \"wall\"\n\
                 south = \"wall\"\nnorth = \"wall\"\n{walls}\n\
             [time]\nend = 1.0\n[pressure]\nmax_iterations = 50\nsolver = \"{solver}\"\n\
                 divergence_limit = {:e}",
            REDUCTION * cells[0] as f64
        );
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("case.toml");
        std::fs::write(&path, text).expect("a file");
        let case = load(&path, &[]).unwrap_or_else(|e| panic!("{e}")).case;
        let mut scene = Scene::<D>::new(session, &case).unwrap_or_else(|e| panic!("{e}"));
        let grid = scene.domain.grid.clone();
        for axis in 0..D {
            for c in grid.face_rows(axis).flatten() {
                let at = grid.centre(c);
                scene.state.faces[axis][c] =
                    (0..D).map(|a| ((7.3 + a as f64 + axis as f64) * at[a] * 5.0).sin()).product();
            }
        }
        scene.domain.boundaries.set_faces(&mut scene.state.faces);
        let start = scene.state.faces.clone();
        Bench { scene, start, coefficients, moved: 0.0, weights: Vec::new(), covered: Vec::new() }
    }

    /// Moves the discs on, and sets the coefficient there.
    fn advance(&mut self) {
        self.moved += STEP;
        let (grid, moved) = (self.scene.domain.grid.clone(), self.moved);
        let pitch = if D == 2 { 17.7 } else { 14.6 };
        // The part of a ball about a point, smoothed over a spacing, and which ball that is.
        let near = |at: [f64; D]| {
            let mut square = 0.0;
            let mut shift = 0.0;
            let mut ball = [0; D];
            for a in (0..D).rev() {
                let x = at[a] / grid.h[a] + if a == 0 { moved + shift } else { 0.37 * shift };
                let n = (x / pitch).floor();
                shift += 7.9 * n;
                square += (x - (n + 0.5) * pitch).powi(2);
                ball[a] = n as i64;
            }
            ((5.5 - square.sqrt()).clamp(0.0, 1.0), ball)
        };
        let inside = |at: [f64; D]| near(at).0;
        match self.coefficients {
            Coefficients::Uniform => {}
            Coefficients::Ratio(ratio) => {
                let mut density = grid.field();
                for c in grid.rows().flatten() {
                    density[c] = 1.0 + (ratio - 1.0) * inside(grid.centre(c));
                }
                self.scene.domain.boundaries.fill_property(&mut density).expect("ghosts");
                let density = Coefficient::Field(density);
                let mut beta = FaceCoefficient::new(&grid, &density);
                beta.update(&grid, &density);
                self.set_beta(beta);
            }
            Coefficients::Closed | Coefficients::Free(_) => {
                let mut beta = grid.vector_field();
                let mut balls = BTreeMap::<[i64; D], Vec<(usize, usize, f64)>>::new();
                // A ball that a wall cuts stays: moved, it would take volume along.
                let mut held = BTreeSet::new();
                for axis in 0..D {
                    for c in grid.face_rows(axis).flatten() {
                        let mut at = grid.centre(c);
                        at[axis] -= 0.5 * grid.h[axis];
                        let (part, ball) = near(at);
                        beta[axis][c] = (1.0 - part).max(1e-6);
                        let within = 0.1 * grid.h[axis]..grid.size[axis] - 0.1 * grid.h[axis];
                        if part > 0.0 && within.contains(&at[axis]) {
                            balls.entry(ball).or_default().push((axis, c, part));
                        } else if part > 0.0 {
                            held.insert(ball);
                        }
                    }
                }
                self.set_beta(FaceCoefficient::Field(beta));
                self.covered.clear();
                let Coefficients::Free(ratio) = self.coefficients else { return };
                balls.retain(|ball, _| !held.contains(ball));
                let cells = if D == 2 { PI * 25.0 } else { 4.0 / 3.0 * PI * 125.0 };
                self.weights = vec![1.0 / (ratio * cells); D * balls.len()];
                for (k, faces) in balls.values().enumerate() {
                    let face = |(axis, c, part): &(usize, usize, f64)| ModeFace {
                        mode: (D * k + axis) as u32,
                        axis: *axis as u8,
                        face: *c as u32,
                        part: *part,
                    };
                    self.covered.extend(faces.iter().map(face));
                }
            }
        }
    }

    fn set_beta(&mut self, beta: FaceCoefficient<D>) {
        let Some(flow) = self.scene.method.downcast_mut::<Flow<D>>() else {
            panic!("the case has no bodies")
        };
        flow.beta = beta;
    }

    /// A step's work for the pressure: what it took.
    fn solve(&mut self) -> Duration {
        self.advance();
        for (faces, start) in self.scene.state.faces.iter_mut().zip(&self.start) {
            faces.copy_from_slice(start);
        }
        let scene = &mut self.scene;
        let begin = Instant::now();
        if !matches!(self.coefficients, Coefficients::Uniform) {
            scene
                .domain
                .projection
                .assemble(&scene.domain.grid, scene.method.beta())
                .expect("assembled");
        }
        let (p, faces) = (&mut scene.state.p, &mut scene.state.faces);
        let free = matches!(self.coefficients, Coefficients::Free(_));
        if free {
            scene
                .domain
                .projection
                .set_modes(&self.weights, &self.covered, &[], &Sharing::default())
                .expect("set");
        }
        let mut bodies = Bodies { weights: &self.weights, covered: &self.covered, faces };
        let coupled: &mut dyn Coupled<D> = if free { &mut bodies } else { bodies.faces };
        let done = scene.domain.projection.project(
            &scene.domain.grid,
            &mut scene.domain.boundaries,
            scene.method.beta(),
            1e-3,
            p,
            coupled,
            mics::poisson::pressure::Accuracy::Full,
        );
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
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(2))
        .warm_up_time(Duration::from_millis(300));
    for (name, coefficients, solvers) in [
        ("uniform", Coefficients::Uniform, &["multigrid", "bcgs-boomeramg"][..]),
        ("s2.65", Coefficients::Ratio(2.65), &["multigrid", "bcgs-boomeramg"]),
        ("s1000", Coefficients::Ratio(1000.0), &["multigrid", "bcgs-boomeramg"]),
        ("closed", Coefficients::Closed, &["multigrid", "bcgs-boomeramg"]),
        ("free2.65", Coefficients::Free(2.65), &["multigrid", "bcgs-boomeramg"]),
        ("free0.1", Coefficients::Free(0.1), &["multigrid", "bcgs-boomeramg"]),
    ] {
        for solver in solvers {
            let mut bench = None;
            group.bench_function(BenchmarkId::new(name, solver), |b| {
                let bench =
                    bench.get_or_insert_with(|| Bench::new(session, cells, coefficients, solver));
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
