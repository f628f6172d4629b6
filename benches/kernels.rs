//! The kernels of a step, each by itself, and whole steps; the pressure solve has a bench of its
//! own.
//!
//! `cargo bench --bench kernels [-- FILTER]`; the names are `kernel/size`. About a second each.

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mics::config::load;
use mics::contact::{Contacts, Damping, Laws, Material, Substeps, Touching};
use mics::geometry::fraction::{self, Rule};
use mics::geometry::{Cuts, Disc, Placed, Pose, Shape, Sphere, aperture};
use mics::grid::Coefficient;
use mics::kernels::advection::{Carrier, Fluxes, upwind5};
use mics::kernels::diffusion;
use mics::kernels::faces;
use mics::method::MethodKind;
use mics::method::sharp::cut::CutBodies;
use mics::particles::velocities;
use mics::particles::{Accelerations, Body, Freedom, Motion};
use mics::petsc::Session;
use mics::scene::Scene;
use nalgebra::{Vector3, vector};
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The cylinder in a stream that is shipped: 160 x 64 cells, 8 across the disc.
const CYLINDER: &str = "cases/cylinder-wake/case.toml";

/// The cylinder swung about its place.
const SWINGS: &str = "particle.0.motion={ prescribed = { oscillation = { amplitude = [0.05, 0.02], \
    frequency = 1.0 } } }";

/// A sphere of 12 cells across in a stream, 64 x 32 x 32 cells.
const SPHERE: &str = r#"name = "bench"
domain = { size = [2.0, 1.0, 1.0], cells = [64, 32, 32] }
fluid = { density = 1.0, viscosity = 0.01 }
time.end = 1.0
[boundary]
west = { inflow = [1.0, 0.0, 0.0] }
east = "outflow"
south = "slip"
north = "slip"
bottom = "slip"
top = "slip"
[[particle]]
shape = { sphere = { diameter = 0.375 } }
position = [0.61, 0.52, 0.49]
motion = "fixed"
"#;

fn scene<const D: usize>(session: &Session, case: &Path, overrides: &[&str]) -> Scene<D> {
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    let case = load(case, &overrides).unwrap_or_else(|e| panic!("{e}")).case;
    Scene::new(session, &case).unwrap_or_else(|e| panic!("{e}"))
}

fn cylinder(session: &Session, overrides: &[&str]) -> Scene<2> {
    scene(session, &Path::new(env!("CARGO_MANIFEST_DIR")).join(CYLINDER), overrides)
}

fn sphere(session: &Session) -> Scene<3> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.toml");
    std::fs::write(&path, SPHERE).expect("a file");
    scene(session, &path, &[])
}

/// Kernels that go through all cells or faces.
fn fluid<const D: usize>(c: &mut Criterion, scene: &mut Scene<D>) {
    let size = scene.domain.grid.cells.map(|n| n.to_string()).join("x");
    let grid = scene.domain.grid.clone();
    let (mut rate, mut fluxes) = (grid.vector_field(), Fluxes::new(&grid));
    let mut divergence = grid.field();
    let mut group = c.benchmark_group("fluid");
    group.throughput(Throughput::Elements(grid.total_cells() as u64));
    group.bench_function(BenchmarkId::new("advection-diffusion", &size), |b| {
        let carrier = Carrier { now: &scene.state.faces, before: None };
        b.iter(|| {
            upwind5(
                &grid,
                &carrier,
                black_box(&scene.state.u),
                0.01,
                1.0,
                true,
                &mut rate,
                &mut fluxes,
            )
        });
    });
    let (density, p) = (Coefficient::Uniform(1.0), grid.field());
    group.bench_function(BenchmarkId::new("diffusion-alone", &size), |b| {
        b.iter(|| {
            diffusion::laplacian(
                &grid,
                0.01,
                &density,
                black_box(&scene.state.u[0]),
                1.0,
                &mut rate[0],
            )
        });
    });
    group.bench_function(BenchmarkId::new("faces-predict", &size), |b| {
        b.iter(|| {
            faces::predict(
                &grid,
                black_box(&scene.state.u),
                true,
                0.01,
                &rate,
                &mut scene.state.faces,
            )
        });
    });
    group.bench_function(BenchmarkId::new("faces-acceleration", &size), |b| {
        b.iter(|| faces::acceleration(&grid, scene.method.beta(), black_box(&p), &mut rate));
    });
    group.bench_function(BenchmarkId::new("faces-divergence", &size), |b| {
        b.iter(|| faces::divergence(&grid, black_box(&scene.state.faces), &mut divergence));
    });
    group.bench_function(BenchmarkId::new("cells", &size), |b| {
        b.iter(|| faces::add_to_cells(&grid, 0.0, black_box(&rate), &mut scene.state.u));
    });
    group.finish();
}

/// Fractions of cells and covered parts of faces of one body, so many cells across.
fn cuts<const D: usize>(c: &mut Criterion, scene: &Scene<D>, across: &[f64]) {
    let (grid, name) = (&scene.domain.grid, if D == 2 { "disc" } else { "sphere" });
    let centre = Vector3::from_fn(|a, _| if a < D { 0.497 * grid.size[a] } else { 0.0 });
    let (mut cells, mut cuts, mut arms) = (Vec::new(), Cuts::with_capacity(0), Vec::new());
    let mut group = c.benchmark_group("geometry");
    for across in across {
        let radius = 0.5 * across * grid.h[0];
        let mut planes = std::array::from_fn(|_| Vec::new());
        let shape: &dyn Shape = if D == 2 { &Disc { radius } } else { &Sphere { radius } };
        let body = Placed { shape, pose: Pose { place: centre, ..Pose::default() } };
        let id = |what: &str| BenchmarkId::new(what, format!("{name}-{across}"));
        group.bench_function(id("fractions"), |b| {
            b.iter(|| {
                fraction::overlaps(grid, black_box(&body), Rule::Exact, &mut planes, &mut cells)
            });
        });
        group.bench_function(id("apertures"), |b| {
            b.iter(|| {
                let planes = &mut planes;
                (0..D).for_each(|a| {
                    aperture::cuts(grid, a, black_box(&body), planes, &mut cuts, &mut arms)
                })
            });
        });
    }
    group.finish();
}

/// The cut bodies of a scene rebuilt, and the wall imposed by them.
fn walls<const D: usize>(c: &mut Criterion, scene: &mut Scene<D>) {
    let size = scene.domain.grid.cells.map(|n| n.to_string()).join("x");
    let Scene { domain, state, method, .. } = scene;
    assert_eq!(method.kind(), MethodKind::Sharp);
    let mut group = c.benchmark_group("sharp");
    group.bench_function(BenchmarkId::new("settle", &size), |b| {
        b.iter(|| method.place(domain, state))
    });
    let mut cut = CutBodies::new(domain, &state.bodies);
    cut.settle(domain, &state.bodies, &[], None);
    group.bench_function(BenchmarkId::new("impose", &size), |b| {
        b.iter(|| cut.set_ghost_cells(domain, velocities(&state.bodies), true, None, &mut state.u));
    });
    group.finish();
}

/// A crowd of discs in a square lattice with walls nowhere, every one in touch with four.
fn contacts(c: &mut Criterion) {
    const N: usize = 20;
    let pitch = 0.999;
    let motion =
        Motion::Free(Freedom { translation: [true, true, false], rotation: [false, false, true] });
    let disc = |k: usize| {
        let centre = pitch * vector![(k % N) as f64 + 0.5, (k / N) as f64 + 0.5, 0.0];
        let mut body = Body::new(Arc::new(Disc { radius: 0.5 }), 2500.0, 1.0, centre);
        (body.velocity, body.motion) =
            (0.1 * vector![(k as f64).sin(), (k as f64).cos(), 0.0], motion);
        body
    };
    let bodies: Vec<Body> = (0..N * N).map(disc).collect();
    let law = Material {
        normal_stiffness: 1e6,
        exponent: 1.0,
        tangential_ratio: 2.0 / 7.0,
        friction: 0.4,
        rolling_friction: 0.0,
        damping: Damping::Restitution(0.8),
        printed_sign: false,
    };
    let size = pitch * N as f64;
    let (laws, periods) = (Laws::new(1, |_, _| law), [Some(size), Some(size), None]);
    let materials = vec![0; bodies.len()];
    let made = Contacts::new(
        &bodies,
        materials,
        Vec::new(),
        laws,
        [size, size, 1.0],
        periods,
        Substeps::Fixed(10),
    );
    let accelerations = vec![Accelerations::default(); bodies.len()];
    c.bench_function("contacts/400-discs-10-substeps", |b| {
        let start = || (made.clone(), made.untouched(), bodies.clone());
        let step = |(mut contacts, mut touching, mut bodies): (Contacts, Touching, Vec<Body>)| {
            contacts
                .advance(&mut bodies, &mut touching, &accelerations, |_, body| body.inertia(), 1e-3)
                .expect("moved");
            (contacts, touching, bodies)
        };
        b.iter_batched(start, step, BatchSize::SmallInput);
    });
}

fn steps<const D: usize>(c: &mut Criterion, name: &str, scene: &mut Scene<D>) {
    let dt = 0.4 * scene.limits().expect("limits").tightest().1;
    c.bench_function(&format!("step/{name}"), |b| b.iter(|| scene.step(dt).expect("a step")));
}

fn kernels(c: &mut Criterion) {
    let session = Session::start(&[]).expect("PETSc starts");
    let (mut flat, mut round) = (cylinder(&session, &[]), sphere(&session));
    steps(c, "cylinder-160x64", &mut flat);
    steps(c, "swinging-cylinder-160x64", &mut cylinder(&session, &[SWINGS]));
    walls(c, &mut flat);
    walls(c, &mut round);
    cuts(c, &flat, &[8.0, 32.0]);
    cuts(c, &round, &[8.0, 16.0]);
    contacts(c);
    fluid(c, &mut flat);
    fluid(c, &mut round);
}

fn short() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .measurement_time(Duration::from_millis(400))
        .warm_up_time(Duration::from_millis(100))
}

criterion_group!(name = benches; config = short(); targets = kernels);
criterion_main!(benches);
