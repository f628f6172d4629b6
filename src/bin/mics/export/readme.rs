//! The `README.md` of an exported system: what it is, its files, and how to read and solve them.

use super::{About, MARK};
use mics::run::Exported;
use mics_run::words::rounded;

/// How to read and solve it, with places for what depends on the system.
const READING: &str = include_str!("reading.md");

/// What is solved.
const EQUATION: &str = "x = phi, the change of the pressure, solves in every cell
`-div(beta grad phi) + the response of free bodies = -D/dt`, with beta = 1/rho on faces (times the
open part of a face that a sharp body surface cuts) and D the divergence that is left.";

/// The page.
pub fn page(about: &About) -> String {
    let Exported { step, .. } = about.exported;
    let head =
        format!("# The pressure system of {}, step {step}, solve {}", about.name, about.solve);
    [head, what(about), files(about), reading(about)].join("\n\n")
}

/// What the system is, as a table.
fn what(about: &About) -> String {
    let rows = scene(about).into_iter().chain(numbers(about)).chain(run(about));
    let rows: String = rows.map(|(name, text)| format!("| {name} | {text} |\n")).collect();
    let from = format!(
        "One linear solve of the pressure iteration (C-HSMAC) of a run of\nmics {}:",
        env!("CARGO_PKG_VERSION")
    );
    format!(
        "    A x = b,    A = A_fluid + J diag(w) J^T\n\n\
        {from} {EQUATION}\n\n| | |\n|---|---|\n{rows}"
    )
    .trim_end()
    .to_owned()
}

/// A row of the table.
type Row = (&'static str, String);

/// Grid, time and bodies.
fn scene(about: &About) -> [Row; 3] {
    let Exported { time, dt, cells, spacing, bodies, free_bodies, .. } = about.exported;
    let times = |numbers: Vec<String>| numbers.join(" x ");
    let cells = times(cells.iter().map(usize::to_string).collect());
    let spacing = times(spacing.iter().map(|h| rounded(*h)).collect());
    let bodies = match about.exported.density_ratios {
        None => "none in the box".into(),
        Some((least, most)) => format!(
            "{bodies} in the box, {free_bodies} of them free; density over the fluid's: {}",
            if least == most { rounded(least) } else { [least, most].map(rounded).join(" to ") }
        ),
    };
    [
        ("grid", format!("{cells} cells of {spacing} m")),
        ("time", format!("the step from t = {} to {} s", rounded(time - dt), rounded(*time))),
        ("bodies", bodies),
    ]
}

/// The system itself.
fn numbers(about: &About) -> [Row; 7] {
    let system = &about.exported.system;
    let singular = if system.singular {
        "yes: no boundary fixes the pressure, and constants are the null space (`null`); the mean \
        is taken out of b, and x is the solution whose mean is zero"
    } else {
        "no: an outflow fixes the pressure"
    };
    let negative = if system.factors.iter().any(|factor| factor.weight < 0.0) {
        "; of the held mean velocity m2/kg, and its weight kg/m3, which is negative"
    } else {
        ""
    };
    let shift = "none (mics gives preconditioners a matrix whose diagonal is larger by 1e-13 where \
                 the system is singular; this is the operator itself)";
    [
        ("unknowns", format!("{}: a row a cell, x fastest, then y, then z", system.fluid.rows())),
        ("nonzeros", about.nonzeros()),
        (
            "units",
            format!(
                "those of the case, by SI names: A and w in m/kg (A_fluid is 1/(rho h^2)), x in \
                Pa, b in 1/s2, J none{negative}"
            ),
        ),
        ("symmetric", "yes, to the last digit".into()),
        ("singular", singular.into()),
        ("shift of the diagonal", shift.into()),
        (
            "x",
            format!(
                "exact to double precision, found by iterative refinement: b - A x is {:.1e} of b",
                system.relative_residual()
            ),
        ),
    ]
}

/// How the run solved it.
fn run(about: &About) -> [Row; 2] {
    let Exported { solver, options, petsc, .. } = about.exported;
    [
        ("the run", format!("{solver}: {}", about.own_solve())),
        ("its options", format!("`{}` (PETSc {petsc})", options.trim())),
    ]
}

/// The files.
fn files(about: &About) -> String {
    let system = &about.exported.system;
    let mut rows = String::new();
    let mut row = |name: &str, what: &str| {
        rows += &format!("| `{name}.mtx`, `{name}.petsc` | {what} |\n");
    };
    if about.whole.matrix.is_some() {
        row("A", "the matrix, the bodies' dense blocks in it");
    }
    row("A_fluid", "its sparse part, from which preconditioners are built");
    if !system.factors.is_empty() {
        row("J", "a column a motion of a free body, in the cells that its surface cuts");
        row("w", "the weights");
    }
    row("b", "the right side");
    row("x", "the exact solution");
    if system.singular {
        row("null", "the null space: one vector of length 1");
    }
    let missing = match about.whole.matrix {
        Some(_) => String::new(),
        None => format!(
            "\n\nA itself is not written: its dense blocks would give it up to {} nonzeros, more \
            than `--most-nonzeros`.\nIts parts are all of it.",
            about.whole.at_most
        ),
    };
    format!(
        "| file | holds |\n|---|---|\n{rows}| `{MARK}` | all numbers of this page, what each \
        column of J stands for, and how the run solved the system |\n\n`.mtx` is MatrixMarket's \
        text (of symmetric matrices the lower part), `.petsc` PETSc's binary form: 32-bit integers \
        and\ndoubles, big endian.{missing}"
    )
}

/// Unknowns up to which a direct solve of SciPy's takes seconds: in space factors fill up.
const DIRECT: [usize; 2] = [300_000, 20_000];

/// Whether SciPy solves it directly within seconds.
fn goes_direct(about: &About) -> bool {
    let Exported { system, cells, .. } = about.exported;
    system.fluid.rows() <= DIRECT[usize::from(cells.len() == 3)]
}

/// How to read and solve it.
fn reading(about: &About) -> String {
    let (whole, singular) = (about.whole.matrix.is_some(), about.exported.system.singular);
    let when = |is: bool, text: &'static str| if is { text } else { "" };
    let places = [
        ("@PY_A@", if whole { PY_WHOLE } else { PY_PARTS }),
        ("@PY_NULL@", when(singular, PY_NULL)),
        ("@PY_MEAN@", when(singular, "constants.remove(x)\n")),
        ("@C_A@", if whole { C_WHOLE } else { C_PARTS }),
        ("@C_NULL@", when(singular, C_NULL)),
        ("@C_MEAN@", when(singular, "  PetscCall(MatNullSpaceRemove(constants, x));\n")),
        ("@SCIPY_A@", if whole { SCIPY_WHOLE } else { SCIPY_PARTS }),
        (
            "@SCIPY_DIRECT@",
            match (whole && goes_direct(about), singular) {
                (true, true) => SCIPY_SINGULAR,
                (true, false) => SCIPY_REGULAR,
                _ => "",
            },
        ),
        ("@MATLAB_A@", if whole { MATLAB_WHOLE } else { MATLAB_PARTS }),
    ];
    places.iter().fold(READING.to_owned(), |text, (place, with)| text.replace(place, with))
}

const PY_WHOLE: &str = "A = load(PETSc.Mat, \"A.petsc\")";
const PY_PARTS: &str = "J, w = load(PETSc.Mat, \"J.petsc\"), load(PETSc.Vec, \"w.petsc\")
A = PETSc.Mat().createLRC(A_fluid, J.convert(\"dense\"), w, None)";
const PY_NULL: &str = "constants = PETSc.NullSpace().create(constant=True)
for matrix in (A, A_fluid):
    matrix.setNullSpace(constants)
";

const C_WHOLE: &str = "  PetscCall(load_matrix(\"A.petsc\", &A));";
const C_PARTS: &str = "  Mat J;
  Vec w;
  PetscCall(load_matrix(\"J.petsc\", &J));
  PetscCall(load_vector(\"w.petsc\", &w));
  PetscCall(MatConvert(J, MATDENSE, MAT_INPLACE_MATRIX, &J));
  PetscCall(MatCreateLRC(A_fluid, J, w, NULL, &A));";
const C_NULL: &str = "  MatNullSpace constants;
  PetscCall(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_TRUE, 0, NULL, &constants));
  PetscCall(MatSetNullSpace(A, constants));
  PetscCall(MatSetNullSpace(A_fluid, constants));
";

const SCIPY_WHOLE: &str = "A = io.mmread(\"A.mtx\").tocsr()";
const SCIPY_PARTS: &str = "J, w = io.mmread(\"J.mtx\").tocsr(), vector(\"w.mtx\")
A = linalg.LinearOperator(A_fluid.shape, lambda x: A_fluid @ x + J @ (w * (J.T @ x)), dtype=float)";
const SCIPY_REGULAR: &str = "x = linalg.spsolve(A.tocsc(), b)
print(f\"direct: error of x {numpy.linalg.norm(x - exact) / numpy.linalg.norm(exact):.1e}\")
";
const SCIPY_SINGULAR: &str =
    "# Singular: with one unknown held at zero, the rest is not; then the mean is taken out.
x = numpy.concatenate([[0.0], linalg.spsolve(A[1:, 1:].tocsc(), b[1:])])
x -= x.mean()
print(f\"direct: error of x {numpy.linalg.norm(x - exact) / numpy.linalg.norm(exact):.1e}\")
";

const MATLAB_WHOLE: &str = "A = PetscBinaryRead('A.petsc');
product = @(x) A * x;
L = ichol(A_fluid);";
const MATLAB_PARTS: &str = "J = PetscBinaryRead('J.petsc');
w = PetscBinaryRead('w.petsc');
product = @(x) A_fluid * x + J * (w .* (J' * x));
L = ichol(A_fluid);";
