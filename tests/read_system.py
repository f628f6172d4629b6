"""Reads systems that `mics export-system` wrote with SciPy and petsc4py, solves them with both, and runs the programs of their
README.md as printed: the same x, and as many iterations of cg with icc as mics took."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy
import petsc4py
from scipy import io, sparse
from scipy.sparse import linalg

petsc4py.init([])
from petsc4py import PETSc

passed = 0


def expect(condition, message):
    global passed
    if not condition:
        sys.exit(f"read_system: {message}")
    passed += 1


def size(x):
    return numpy.linalg.norm(x)


def load(kind, path):
    return kind().create().load(PETSc.Viewer().createBinary(str(path), "r"))


def in_scipy(matrix):
    begins, columns, values = matrix.getValuesCSR()
    return sparse.csr_matrix((values, columns, begins), matrix.getSize())


def without_mean(x, singular):
    return x - x.mean() if singular else x


def read(folder, about):
    """Both formats hold the same; returns A (PETSc's), A_fluid, b, x, and A's product in SciPy."""
    name = folder.name
    matrices = {}
    for what in ("A", "A_fluid", "J"):
        if (folder / f"{what}.mtx").exists():
            text, binary = io.mmread(folder / f"{what}.mtx").tocsr(), load(PETSc.Mat, folder / f"{what}.petsc")
            expect((text != in_scipy(binary)).nnz == 0, f"{name}: {what} in both formats")
            matrices[what] = text, binary
    vectors = {}
    for what in ("b", "x", "w", "null"):
        if (folder / f"{what}.mtx").exists():
            text, binary = io.mmread(folder / f"{what}.mtx").ravel(), load(PETSc.Vec, folder / f"{what}.petsc")
            expect(numpy.array_equal(text, binary.getArray()), f"{name}: {what} in both formats")
            vectors[what] = text, binary
    fluid = matrices["A_fluid"][0]
    expect(("J" in matrices) == bool(about["factors"]), f"{name}: J")
    if "J" in matrices:
        J, w = matrices["J"][0], vectors["w"][0]
        by_parts = lambda x: fluid @ x + J @ (w * (J.T @ x))
    else:
        by_parts = lambda x: fluid @ x
    b, x = vectors["b"][0], vectors["x"][0]
    expect(size(by_parts(x) - b) < 1e-12 * size(b), f"{name}: A x = b, by its parts")
    if "null" in vectors:
        expect(size(by_parts(vectors["null"][0])) < 1e-10 * abs(fluid).max(), f"{name}: A null = 0")
    if "A" in matrices:
        A = matrices["A"][0]
        expect((A != A.T).nnz == 0 and size(A @ x - b) < 1e-12 * size(b), f"{name}: A x = b")
        whole = matrices["A"][1]
    else:
        whole = PETSc.Mat().createLRC(matrices["A_fluid"][1], matrices["J"][1].convert("dense"), vectors["w"][1], None)
    return whole, matrices, vectors, by_parts


def solve_in_scipy(folder, about, matrices, b, x):
    """A direct solve of the assembled matrix; of a singular one with an unknown held."""
    A = matrices["A"][0]
    if about["singular"]:
        found = numpy.concatenate([[0.0], linalg.spsolve(A[1:, 1:].tocsc(), b[1:])])
    else:
        found = linalg.spsolve(A.tocsc(), b)
    error = size(without_mean(found, about["singular"]) - x) / size(x)
    expect(error < 1e-10, f"{folder.name}: SciPy's x differs by {error:.1e}")
    return error


def solve_in_petsc(about, A, A_fluid, b, tolerance):
    """cg with icc, built from A_fluid, in the norm that mics tests; returns x and the iterations."""
    for matrix in (A, A_fluid):
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        if about["singular"]:
            matrix.setNullSpace(PETSc.NullSpace().create(constant=True))
    ksp = PETSc.KSP().create()
    ksp.setType("cg")
    ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
    ksp.getPC().setType("icc")
    ksp.setTolerances(rtol=tolerance, atol=about["run"]["atol"], max_it=2000)
    ksp.setOperators(A, A_fluid)
    found = b.duplicate()
    ksp.solve(b, found)
    expect(ksp.getConvergedReason() > 0, f"petsc4py: {ksp.getConvergedReason()}")
    return without_mean(found.getArray(), about["singular"]), ksp.getIterationNumber()


def run_readme(folder, iterations):
    """The programs and commands of its README, but for MATLAB's."""
    page = (folder / "README.md").read_text()
    for language, body in re.findall(r"```(\w+)\n(.*?)```", page, re.S):
        name = re.match(r"(?:# |/\* )(\S+\.(?:py|c))", body)
        if name:
            (folder / name[1]).write_text(body)
        if language != "sh":
            continue
        ran = subprocess.run(["bash", "-e", "-c", body], cwd=folder, capture_output=True, text=True)
        expect(ran.returncode == 0, f"{folder.name}: {body}{ran.stdout}{ran.stderr}")
        if "-pc_type icc" in body:
            expect(f"iterations {iterations}," in ran.stdout, f"{folder.name}: {ran.stdout}, not {iterations}")
        else:
            expect("converged" in ran.stdout, f"{folder.name}: {ran.stdout}")


for folder in map(Path, sys.argv[1:]):
    about = json.loads((folder / "system.json").read_text())
    words = shlex.split(about["run"]["petsc_options"])
    expect({"cg", "icc", "unpreconditioned"} <= set(words), f"{folder.name}: options {words}")
    A, matrices, vectors, by_parts = read(folder, about)
    (b, petsc_b), (x, _) = vectors["b"], vectors["x"]
    direct = ""
    if "A" in matrices:
        direct = f", directly within {solve_in_scipy(folder, about, matrices, b, x):.1e}"
    A_fluid = matrices["A_fluid"][1]
    _, iterations = solve_in_petsc(about, A, A_fluid, petsc_b, about["run"]["rtol"])
    own = about["run"]["outcome"]["iterations"]
    expect(iterations == own, f"{folder.name}: {iterations} iterations, and mics takes {own}")
    found, _ = solve_in_petsc(about, A, A_fluid, petsc_b, 1e-13)
    error = size(found - x) / size(x)
    expect(error < 1e-10, f"{folder.name}: PETSc's x differs by {error:.1e}")
    run_readme(folder, own)
    print(f"{folder.name}: {own} iterations in mics and in PETSc; x the same within {error:.1e}{direct}")
print(f"{passed} passed, 0 failed")
