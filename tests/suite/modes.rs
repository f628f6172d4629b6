//! The operator `A + sum_k w_k j_k j_k^T` against a dense solve: with every kind of solver, and on
//! two ranks.

use crate::allocation::count;
use crate::support::{mpirun, petsc};
use mics::Result;
use mics::grid::{Boundaries, BoundaryKind, GHOSTS, Grid};
use mics::kernels::faces::FaceCoefficient;
use mics::petsc::{Choice, Layout, LinearSolver, Session};
use mics::poisson::{MatrixRows, ModeFace, Poisson};
use mics::sharing::Sharing;
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;
use std::env;
use std::rc::Rc;

const NX: usize = 14;
const NY: usize = 12;
const N: usize = NX * NY;

/// Number of modes: two for each of three bodies, and as many again for the one that turns.
const MODES: usize = 8;
/// The bodies that turn, where all modes are there.
const TURNING: [u32; 1] = [1];

/// A face that a mode has: the low one of the cell along an axis, and the part.
#[derive(Clone, Copy)]
struct Face {
    mode: usize,
    axis: usize,
    cell: usize,
    part: f64,
}

/// The five-point Laplacian; cells are numbered x fastest. The pressure is given on the west side,
/// or nowhere.
struct System {
    session: Session,
    solver: LinearSolver,
    operator: Rc<RefCell<Poisson>>,
    grid: Grid<2>,
    /// The cells that this rank owns.
    cells: Vec<usize>,
    singular: bool,
}

/// The matrix's value between two cells. What the singular one has on its diagonal in addition, as
/// the pressure's own does, lets it be factorised.
fn laplacian(a: usize, b: usize, singular: bool) -> f64 {
    let ([ax, ay], [bx, by]) = ([a % NX, a / NX], [b % NX, b / NX]);
    let inner = |at: usize, n: usize| f64::from(u8::from(at > 0) + u8::from(at + 1 < n));
    match ax.abs_diff(bx) + ay.abs_diff(by) {
        0 if singular => (inner(ax, NX) + inner(ay, NY)) * (1.0 + 1e-13),
        0 => inner(ax, NX) + inner(ay, NY) + if ax == 0 { 2.0 } else { 0.0 },
        1 => -1.0,
        _ => 0.0,
    }
}

/// All modes. Rings of faces, other parts in each `step`; the bodies sit in the middle, where ranks
/// meet, and share cells.
fn modes(step: usize) -> Vec<Face> {
    let ring = |k: usize, axis: usize| {
        let body = if k < 6 { k / 2 } else { TURNING[0] as usize };
        let centre = [[4.6, 5.4], [9.3, 6.1], [6.7, 8.2]][body];
        let arm = move |c: usize| [((c % NX) as f64) - centre[0], ((c / NX) as f64) - centre[1]];
        let part = move |c: usize| {
            0.6 + 0.39 * (1.3 * k as f64 + 2.1 * c as f64 + 0.7 * step as f64).sin()
        };
        let turning = move |c: usize| if axis == 0 { -arm(c)[1] } else { arm(c)[0] };
        (0..N).filter(move |c| (1.2..3.2).contains(&arm(*c)[0].hypot(arm(*c)[1]))).map(
            move |cell| {
                let part = if k < 6 { part(cell) } else { part(cell) * turning(cell) / 3.0 };
                Face { mode: k, axis, cell, part }
            },
        )
    };
    let moving = (0..6).flat_map(|k| ring(k, k % 2));
    moving.chain(ring(6, 0)).chain(ring(6, 1)).collect()
}

/// The right side, with a mean of zero, as the singular system needs it.
fn right_side(c: usize) -> f64 {
    let wave = |c: usize| (3.7 * c as f64).cos();
    wave(c) - (0..N).map(wave).sum::<f64>() / N as f64
}

/// The solution by elimination, with a mean of zero where the system is singular.
fn dense_solution(weights: &[f64], modes: &[Face], singular: bool) -> DVector<f64> {
    let mut matrix = DMatrix::from_fn(N, N, |a, b| laplacian(a, b, singular));
    let b = DVector::from_fn(N, |c, _| right_side(c));
    for (k, w) in weights.iter().enumerate() {
        let mut j = DVector::zeros(N);
        for Face { axis, cell, part, .. } in modes.iter().filter(|m| m.mode == k) {
            j[*cell] -= part;
            j[cell - [1, NX][*axis]] += part;
        }
        matrix += *w * &j * j.transpose();
    }
    if singular {
        matrix.add_scalar_mut(1.0 / N as f64);
    }
    matrix.lu().solve(&b).unwrap()
}

impl System {
    fn new(session: &Session, singular: bool) -> Result<System> {
        let layout = Layout::new(session, &[NX, NY], &[false, false], GHOSTS)?;
        let grid = Grid::<2>::new([NX, NY], [NX as f64, NY as f64], [false; 2], &layout);
        let west = if singular { BoundaryKind::Slip } else { BoundaryKind::Outflow };
        let kinds = [
            [Some(west), Some(BoundaryKind::Slip)],
            [Some(BoundaryKind::Slip), Some(BoundaryKind::Slip)],
        ];
        let boundaries = Boundaries::new(session, &layout, &grid, kinds, true);
        let operator = Rc::new(RefCell::new(Poisson::new(session, &layout, &grid, &boundaries)?));
        operator.borrow_mut().set(&grid, &FaceCoefficient::Uniform(1.0))?;
        let cells: Vec<usize> =
            grid.rows().flatten().map(|c| grid.global_cell(c)).map(|[x, y]| x + NX * y).collect();
        let mut matrix = None;
        let pattern = || {
            let (rows, pattern) = MatrixRows::new(&layout, &grid);
            matrix = Some(rows);
            pattern
        };
        let mut solver = LinearSolver::new(
            session,
            Choice::BcgsBoomeramg,
            &layout,
            operator.clone(),
            singular,
            pattern,
        )?;
        if let Some(mut rows) = matrix {
            solver.set_values(rows.fill(&mut operator.borrow_mut()))?;
        }
        solver.set_right_side(|b| cells.iter().zip(b).for_each(|(c, b)| *b = right_side(*c)))?;
        let session = session.clone();
        Ok(System { session, solver, operator, grid, cells, singular })
    }

    fn set_modes(&self, weights: &[f64], covered: &[ModeFace]) -> Result<()> {
        let turning = if weights.len() == MODES { &TURNING[..] } else { &[] };
        let bodies = weights.len() / 2 - turning.len();
        let sharing = Sharing::among_all(&self.session, bodies);
        self.operator.borrow_mut().set_modes(weights, covered, turning, &sharing)
    }

    /// This rank's part of `modes`: faces with a cell of its own on either side.
    fn own(&self, modes: &[Face]) -> Vec<ModeFace> {
        let face = |Face { mode, axis, cell, part }: &Face| {
            let (axis, at) = (*axis, [cell % NX, cell / NX]);
            let within = |a: usize, more: usize| {
                let low = self.grid.start[a];
                (low..low + self.grid.local[a] + more).contains(&at[a])
            };
            let here = within(axis, 1) && within(1 - axis, 0);
            let index = (0..2).map(|a| (at[a] + GHOSTS - self.grid.start[a]) * self.grid.stride[a]);
            let face = index.sum::<usize>() as u32;
            here.then_some(ModeFace { mode: *mode as u32, axis: axis as u8, face, part: *part })
        };
        modes.iter().filter_map(face).collect()
    }

    /// Solves, to what the rounding of a product leaves at weights of 1e4, and returns the largest
    /// difference from the dense solution, relative to that.
    fn gap(&mut self, weights: &[f64], modes: &[Face]) -> Result<f64> {
        let solved = self.solver.solve(1e-11, 0.0)?;
        println!("weights {weights:?}: {} iterations", solved.iterations);
        let exact = dense_solution(weights, modes, self.singular);
        let mut sum = [self.solver.solution(|x| x.iter().sum::<f64>())?];
        self.session.sum(&mut sum)?;
        let mean = if self.singular { sum[0] / N as f64 } else { 0.0 };
        let gap = |x: &[f64]| {
            x.iter().zip(&self.cells).map(|(x, c)| (x - mean - exact[*c]).abs()).fold(0.0, f64::max)
        };
        Ok(self.solver.solution(gap)? / exact.amax())
    }
}

/// Largest gap of solves without modes, with modes that change from one to the next, and with none
/// again.
fn largest_gap(session: &Session, singular: bool) -> Result<f64> {
    let mut system = System::new(session, singular)?;
    let mut largest = system.gap(&[], &[])?;
    let steps = [
        vec![1.0; MODES],
        vec![1e4; 6],
        vec![1e2; MODES],
        vec![1e-3, 1e4, 0.0, 1.0, 30.0, 1e3],
        vec![1e-3, 1e4, 0.0, 1.0, 30.0, 1e3, 1e2, 0.0],
        vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0],
        vec![0.0; MODES],
        vec![2.0; 4],
        vec![],
    ];
    for (step, weights) in steps.iter().enumerate() {
        let mut modes = modes(step);
        modes.retain(|m| m.mode < weights.len());
        let own = system.own(&modes);
        system.set_modes(weights, &own)?;
        largest = largest.max(system.gap(weights, &modes)?);
    }
    Ok(largest)
}

#[test]
fn rigid_body_modes_equal_elimination() {
    let petsc = petsc();
    for singular in [false, true] {
        let gap = largest_gap(&petsc.session, singular).unwrap();
        assert!(gap < 1e-8, "{gap:e}, singular: {singular}");
    }
}

/// Set for the processes of [`in_processes`]: PETSc's options.
const OPTIONS: &str = "MICS_TEST_MODES_OPTIONS";

/// Runs a test's `body` in processes of its own, with numbers of ranks and PETSc's options; `test`
/// is the caller's name. Returns what each kind printed (in those processes nothing).
pub fn in_processes(test: &str, kinds: &[(usize, &str)], body: impl Fn(&Session)) -> Vec<String> {
    if let Ok(options) = env::var(OPTIONS) {
        let options: Vec<String> = options.split_whitespace().map(str::to_owned).collect();
        body(&Session::start(&options).unwrap());
        return Vec::new();
    }
    let this = env::current_exe().unwrap();
    let kind = |(ranks, options): &(usize, &str)| {
        let mut command = mpirun(*ranks, this.to_str().unwrap());
        command.args([test, "--exact", "--nocapture"]).env(OPTIONS, options);
        let output = command.output().expect("mpirun starts");
        let said = [output.stdout, output.stderr]
            .map(|text| String::from_utf8_lossy(&text).into_owned())
            .concat();
        let passed = said.matches("1 passed").count();
        assert!(output.status.success() && passed == *ranks, "{ranks} ranks, {options}: {said}");
        said
    };
    kinds.iter().map(kind).collect()
}

#[test]
fn rigid_body_modes_with_every_solver_on_two_ranks() {
    let kinds = [
        (2, ""),
        (1, "-ksp_type cg -pc_type boxmg"),
        (2, "-ksp_type cg -pc_type boxmg"),
        (4, "-ksp_type cg -pc_type boxmg"),
        (1, "-ksp_type bicg -pc_type boxmg"),
        (2, "-ksp_type cg -pc_type gamg"),
        (2, "-ksp_type cg -pc_type bjacobi"),
        (2, "-ksp_type gmres -pc_type jacobi -ksp_gmres_restart 200"),
        (1, "-ksp_type cg -pc_type icc"),
        (1, "-ksp_type gmres -pc_type lu"),
        (1, "-ksp_type bicg -pc_type jacobi"),
    ];
    in_processes("modes::rigid_body_modes_with_every_solver_on_two_ranks", &kinds, |session| {
        for singular in [false, true] {
            let gap = largest_gap(session, singular).unwrap();
            // No rank may stop before all have come this far.
            let too_large = session.anywhere(gap >= 1e-8).unwrap();
            assert!(!too_large, "{gap:e}, singular: {singular}");
        }
    });
}

/// A second try, too, is one with the modes: without them a factorised matrix would need no
/// iteration more.
#[test]
fn failed_solve_is_retried_with_rigid_body_modes() {
    let test = "modes::failed_solve_is_retried_with_rigid_body_modes";
    in_processes(test, &[(1, "-ksp_type cg -pc_type lu -ksp_max_it 4")], |session| {
        let mut system = System::new(session, false).unwrap();
        let modes: Vec<_> = modes(0).into_iter().filter(|m| m.mode < 6).collect();
        let weights = [1.0, 1e2, 1e3, 1e4, 1e5, 1e6];
        system.set_modes(&weights, &system.own(&modes)).unwrap();
        let error = system.gap(&weights, &modes).unwrap_err().to_string();
        assert!(error.contains("failed twice: DIVERGED_ITS after 4 iterations"), "{error}");
        system.set_modes(&[], &[]).unwrap();
        assert!(system.gap(&[], &[]).unwrap() < 1e-8);
    });
}

#[test]
fn solver_that_ignores_rigid_body_modes_is_refused() {
    let test = "modes::solver_that_ignores_rigid_body_modes_is_refused";
    in_processes(test, &[(1, "-ksp_type preonly -pc_type lu")], |session| {
        let system = System::new(session, false).unwrap();
        let error = system.solver.refuse_without_low_rank().unwrap_err();
        assert!(error.to_string().contains("preonly") && error.exit_code() == 2, "{error}");
    });
}

#[test]
fn global_preconditioner_refuses_sub_blocks() {
    let test = "modes::global_preconditioner_refuses_sub_blocks";
    in_processes(
        test,
        &[(1, "-pc_type bjacobi -pc_bjacobi_blocks 2 -sub_pc_type boxmg")],
        |session| {
            let error = System::new(session, false).unwrap().gap(&[], &[]).unwrap_err();
            assert!(error.to_string().contains("whole system only"), "{error}");
        },
    );
}

#[test]
fn solve_with_rigid_body_modes_allocates_nothing() {
    let petsc = petsc();
    let mut system = System::new(&petsc.session, true).unwrap();
    let steps = [0, 1, 2].map(|step| system.own(&modes(step)));
    let mut solve = |own: &[ModeFace]| {
        system.set_modes(&[2.0; MODES], own).unwrap();
        system.solver.solve(1e-8, 0.0).unwrap();
    };
    solve(&steps[0]);
    let before = count();
    steps.iter().for_each(|own| solve(own));
    assert_eq!(count() - before, 0);
}

#[test]
fn invalid_rigid_body_modes_are_refused() {
    let petsc = petsc();
    let system = System::new(&petsc.session, false).unwrap();
    let face = (5 + GHOSTS) + (5 + GHOSTS) * (NX + 2 * GHOSTS);
    let good = ModeFace { mode: 0, axis: 0, face: face as u32, part: 1.0 };
    for (weights, covered) in [
        (vec![-1.0, 0.0], vec![good]),
        (vec![f64::NAN, 0.0], vec![good]),
        (vec![1.0], vec![good]),
        (vec![1.0, 1.0], vec![ModeFace { mode: 2, ..good }]),
        (vec![1.0, 1.0], vec![ModeFace { face: 1 << 20, ..good }]),
        (vec![1.0, 1.0], vec![ModeFace { axis: 1, ..good }]),
        (vec![1.0, 1.0], vec![ModeFace { axis: 2, ..good }]),
        (vec![1.0, 1.0], vec![ModeFace { part: -1.0, ..good }]),
        (vec![1.0; MODES], vec![ModeFace { mode: 6, part: f64::NAN, ..good }]),
        (vec![1.0, 1.0], vec![ModeFace { part: f64::INFINITY, ..good }]),
        (vec![1.0; 4], vec![ModeFace { mode: 2, ..good }, good]),
    ] {
        let error = system.set_modes(&weights, &covered).unwrap_err().to_string();
        assert!(error.contains("free bod"), "{weights:?} {covered:?}: {error}");
    }
    system.set_modes(&[1.0, 1.0], &[good]).unwrap();
    system.set_modes(&[1.0; MODES], &[ModeFace { mode: 6, axis: 1, part: -1.0, ..good }]).unwrap();
    assert!(
        system
            .operator
            .borrow_mut()
            .set_modes(&[1.0; 4], &[good], &[1], &Sharing::default())
            .is_err(),
        "there is one body"
    );
}
