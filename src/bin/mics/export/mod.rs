//! `mics export-system`: the linear system of one pressure solve, in files that others read.

mod readme;
mod whole;

use clap::builder::RangedU64ValueParser;
use clap::{Args, value_parser};
use mics::petsc::Solved;
use mics::poisson::{Factor, OwnSolve, System};
use mics::run::{self, Exported, Moment, Wanted, system_of};
use mics::scene::read_case;
use mics::{Error, Result};
use mics_plot::plot;
use mics_run::file::replace;
use mics_run::print;
use mics_run::sparse::{Sparse, write_vector_market, write_vector_petsc};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Says what the system is, and that the folder is one of ours.
const MARK: &str = "system.json";
/// Files beside it; each but the first in MatrixMarket's text and in PETSc's binary form.
const README: &str = "README.md";
const MATRICES: [&str; 7] = ["A", "A_fluid", "J", "w", "b", "x", "null"];

/// Command line of `mics export-system`.
#[derive(Args)]
pub struct Request {
    #[command(flatten)]
    scene: crate::SceneArgs,
    #[command(flatten)]
    moment: MomentArgs,
    /// Which solve of that step: C-HSMAC solves until the divergence of every cell is below its
    /// limit.
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = from_one())]
    solve: u64,
    /// The folder of the system [default: systems/NAME].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the system that is in the folder.
    #[arg(long)]
    force: bool,
    /// Write A up to so many nonzeros; where it has more, by its parts alone.
    #[arg(long, value_name = "N", default_value_t = 10_000_000)]
    most_nonzeros: usize,
    /// Print errors only.
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
#[group(required = true, multiple = false)]
struct MomentArgs {
    /// The step in which the run comes to the time T (s).
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    at: Option<f64>,
    /// The step of this number, the first one being 1.
    #[arg(long, value_name = "N", value_parser = from_one())]
    step: Option<u64>,
}

fn from_one() -> RangedU64ValueParser {
    value_parser!(u64).range(1..)
}

/// Runs a case to a solve and writes its system.
///
/// # Errors
/// When the case or the command is wrong, the run fails or does not come there, or a file cannot
/// be written.
pub fn export(request: &Request) -> Result<()> {
    let crate::SceneArgs { case, set, petsc } = &request.scene;
    let name = read_case(case, set)?.case.name;
    let out = request.out.clone().unwrap_or_else(|| Path::new("systems").join(&name));
    may_use(&out, request.force)?;
    let moment = match (request.moment.step, request.moment.at) {
        (Some(step), _) => Moment::Step(step),
        (None, time) => Moment::Time(time.unwrap_or(f64::NAN)),
    };
    let run = run::Request {
        case: case.clone(),
        out: None,
        set: set.clone(),
        force: false,
        resume: false,
        quiet: request.quiet,
        petsc: petsc.clone(),
        draw: plot::draw_run,
        commit: crate::COMMIT,
    };
    let exported = system_of(&run, Wanted { moment, solve: request.solve })?;
    let system = &exported.system;
    let at_most = whole::at_most(system);
    let small = at_most <= request.most_nonzeros || system.factors.is_empty();
    let whole = small.then(|| whole::sum(system));
    let about = About { name: &name, solve: request.solve, exported: &exported, whole, at_most };
    clear(&out)?;
    about.write(&out)?;
    if request.quiet { Ok(()) } else { print(&about.words(&out)) }
}

/// Whether a system may be written to a folder.
///
/// # Errors
/// When it holds one and `force` is not set, or anything but a system.
fn may_use(path: &Path, force: bool) -> Result<()> {
    let refuse = |why: &str| Err(Error::Usage(format!("{}: {why}", path.display())));
    match fs::read_dir(path).map(Iterator::count) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return refuse(&format!("cannot be used as a system's folder: {e}")),
        Ok(0) => return Ok(()),
        Ok(_) => {}
    }
    match (path.join(MARK).exists(), force) {
        (true, true) => Ok(()),
        (true, false) => refuse(
            "the folder exists and holds a system; give another with --out, or --force to replace \
            it",
        ),
        (false, _) => refuse(&format!(
            "the folder exists and holds no system (no {MARK}); give another folder with --out"
        )),
    }
}

/// Deletes the matrices and vectors of an earlier export, and nothing else.
fn clear(path: &Path) -> Result<()> {
    for file in MATRICES.iter().flat_map(|m| ["mtx", "petsc"].map(|e| format!("{m}.{e}"))) {
        match fs::remove_file(path.join(file)) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(path)(e)),
            _ => {}
        }
    }
    Ok(())
}

/// A system, where it is from, and its matrix as a whole.
struct About<'a> {
    name: &'a str,
    solve: u64,
    exported: &'a Exported,
    /// `None` where it would have too many nonzeros.
    whole: Option<Sparse>,
    /// A bound on its nonzeros.
    at_most: usize,
}

impl About<'_> {
    /// Writes all files; the mark is there from the first moment to the last.
    fn write(&self, out: &Path) -> Result<()> {
        let system = &self.exported.system;
        replace(&out.join(MARK), format!("{:#}\n", self.json()).as_bytes())?;
        let file = |name: &str, ending: &str| out.join(format!("{name}.{ending}"));
        let place = format!("{}, step {}, solve {}", self.name, self.exported.step, self.solve);
        let comment = |what: &str| format!("{what} ({place}; README.md)");
        let matrix = |name: &str, matrix: &Sparse, symmetric: bool, what: &str| {
            matrix.write_market(&file(name, "mtx"), symmetric, &comment(what))?;
            matrix.write_petsc(&file(name, "petsc"))
        };
        let vector = |name: &str, vector: &[f64], what: &str| {
            write_vector_market(&file(name, "mtx"), vector, &comment(what))?;
            write_vector_petsc(&file(name, "petsc"), vector)
        };
        vector("b", &system.right_side, "right side b (1/s2)")?;
        vector("x", &system.solution, "solution x of A x = b (Pa)")?;
        matrix("A_fluid", &system.fluid, true, "the fluid's part of A (m/kg)")?;
        if let Some(whole) = &self.whole {
            matrix("A", whole, true, "A = A_fluid + J diag(w) J^T (m/kg)")?;
        }
        if !system.factors.is_empty() {
            let weights: Vec<f64> = system.factors.iter().map(|factor| factor.weight).collect();
            let columns = whole::columns(system);
            matrix("J", &columns, false, "J in A = A_fluid + J diag(w) J^T, a column a factor")?;
            vector("w", &weights, "w in A = A_fluid + J diag(w) J^T")?;
        }
        if system.singular {
            let n = system.right_side.len();
            let null = vec![1.0 / (n as f64).sqrt(); n];
            vector("null", &null, "null space of A: A null = 0, of length 1")?;
        }
        replace(&out.join(README), readme::page(self).as_bytes())
    }

    /// The content of `system.json`.
    fn json(&self) -> Value {
        let at = self.exported;
        let system = &at.system;
        let System { fluid, factors, singular, own, .. } = system;
        let OwnSolve { rtol, atol, outcome } = own;
        let outcome = match outcome {
            Ok(solved) => json!({ "iterations": solved.iterations, "repeated": solved.retried }),
            Err(failure) => json!({ "failure": failure }),
        };
        let factor = |(factor, words): (&Factor, &String)| {
            let weight = factor.weight;
            let nonzeros = factor.entries.len();
            json!({ "weight": weight, "nonzeros": nonzeros, "of": words })
        };
        json!({
            "case": self.name,
            "step": at.step, "time": at.time, "dt": at.dt, "solve": self.solve,
            "cells": at.cells, "spacing": at.spacing,
            "unknowns": fluid.rows(),
            "nonzeros": {
                "A": self.whole.as_ref().map(Sparse::entries),
                "A_at_most": self.at_most,
                "A_fluid": fluid.entries(),
            },
            "singular": singular,
            "diagonal_shift": 0.0,
            "relative_residual_of_x": system.residual,
            "bodies": at.bodies.count, "free_bodies": at.bodies.free,
            "density_ratios": at.bodies.density_ratios.map(|(least, most)| [least, most]),
            "factors": factors.iter().zip(&at.factors).map(factor).collect::<Vec<_>>(),
            "run": {
                "solver": at.solver, "rtol": rtol, "atol": atol, "outcome": outcome,
                "petsc_options": at.options, "petsc_version": at.petsc,
            },
            "version": env!("CARGO_PKG_VERSION"), "git_commit": crate::COMMIT,
        })
    }

    /// Words for the screen.
    fn words(&self, out: &Path) -> String {
        let Exported { system, step, time, .. } = self.exported;
        format!(
            "{}: solve {} of step {step}, to t = {time:.6} s: {} unknowns, {}\nnonzeros: {}\n\
            b - A x is {:.1e} of b\n{}\n{}: {README} says how to read and solve it",
            self.name,
            self.solve,
            system.fluid.rows(),
            if system.singular { "singular" } else { "not singular" },
            self.nonzeros(),
            system.residual,
            self.own_solve(),
            out.display()
        )
    }

    /// Numbers of nonzeros of the matrices, in words.
    fn nonzeros(&self) -> String {
        let system = &self.exported.system;
        let whole = match &self.whole {
            Some(whole) => whole.entries().to_string(),
            None => format!("up to {} (not written: --most-nonzeros)", self.at_most),
        };
        let of_factors: usize = system.factors.iter().map(|factor| factor.entries.len()).sum();
        let columns = system.factors.len();
        let fluid = system.fluid.entries();
        format!("A {whole}, A_fluid {fluid}, J {of_factors} in {columns} columns")
    }

    /// The run's own solve of it, in words.
    fn own_solve(&self) -> String {
        let OwnSolve { rtol, atol, outcome } = &self.exported.system.own;
        let absolute = if *atol > 0.0 { format!(" or is {atol:.3e}") } else { String::new() };
        let to = format!("until the residual is {rtol:.3e} of b{absolute}");
        match outcome {
            Ok(Solved { iterations, retried, .. }) => {
                let tries = if *retried { " in two tries" } else { "" };
                let s = if *iterations == 1 { "" } else { "s" };
                format!("the run's solver takes {iterations} iteration{s}{tries}, {to}")
            }
            Err(failure) => format!("the run's solver fails: {failure}"),
        }
    }
}
