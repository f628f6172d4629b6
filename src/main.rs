//! The command line.

use clap::{Args, Parser, Subcommand};
use mics::output::{plot, print};
use mics::run::Request;
use mics::{Error, Result, check, run, study};
use std::path::PathBuf;
use std::process::ExitCode;

/// Particle-laden incompressible flow with every particle resolved by the grid.
#[derive(Parser)]
#[command(version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a case into a folder: logs, fields, figures, summary.json.
    Run {
        #[command(flatten)]
        scene: SceneArgs,
        /// The run's folder [default: runs/NAME].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Replace the run that is in the folder.
        #[arg(long)]
        force: bool,
        /// Go on from the newest checkpoint of the run that is in the folder.
        #[arg(long, conflicts_with = "force")]
        resume: bool,
        /// Print errors only.
        #[arg(long)]
        quiet: bool,
    },
    /// Read and check a case and describe it, without running it.
    Check {
        #[command(flatten)]
        scene: SceneArgs,
    },
    /// Run a case over a table of overrides and PETSc options: study.csv, study.md, work-precision figures.
    Study {
        /// The study file (TOML).
        study: PathBuf,
        /// The study's folder [default: runs/NAME].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// List the runs without running them.
        #[arg(long)]
        list: bool,
        /// What the file's [quick] makes of it, into NAME-quick.
        #[arg(long)]
        quick: bool,
        /// Repeat the runs that are finished.
        #[arg(long)]
        force: bool,
    },
    /// Draw the figures of run folders; several together give Cd(Re) and St(Re).
    Plot {
        /// Run folders.
        #[arg(required = true)]
        runs: Vec<PathBuf>,
        /// Where Cd(Re) and St(Re) go [default: the first folder's figures/].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Print the JSON Schema of a case, for editors.
    Schema,
}

#[derive(Args)]
struct SceneArgs {
    /// The case file (TOML).
    case: PathBuf,
    /// Override a key of the case, e.g. fluid.viscosity=2.0 or particle.0.density=1200.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// PETSc options, after --.
    #[arg(last = true, value_name = "PETSC OPTIONS", allow_hyphen_values = true)]
    petsc: Vec<String>,
}

fn main() -> ExitCode {
    // Under mpirun every rank meets the same error. Rank 0 says it; the others leave it the time, since mpirun ends all
    // ranks as soon as one has failed.
    let speaks = !std::env::var("OMPI_COMM_WORLD_RANK").is_ok_and(|rank| rank != "0");
    let fail = |code: u8, say: &dyn Fn()| {
        if speaks {
            say()
        } else {
            std::thread::sleep(std::time::Duration::from_millis(500))
        }
        ExitCode::from(code)
    };
    match Cli::try_parse() {
        // Help and version are "errors" of status 0.
        Err(e) => fail(u8::try_from(e.exit_code()).unwrap_or(2), &|| drop(e.print())),
        Ok(cli) => match act(cli.command) {
            Ok(()) => ExitCode::SUCCESS,
            Err(stop @ Error::Interrupted(_)) => fail(stop.exit_code(), &|| eprintln!("{stop}")),
            Err(error) => fail(error.exit_code(), &|| eprintln!("error: {error}")),
        },
    }
}

fn act(command: Command) -> Result<()> {
    match command {
        Command::Run { scene: SceneArgs { case, set, petsc }, out, force, resume, quiet } => {
            run::run(&Request { case, out, set, force, resume, quiet, petsc })
        }
        Command::Check { scene } => check::check(&scene.case, &scene.set, &scene.petsc),
        Command::Study { study, out, list, quick, force } => {
            study::study(&study::Request { study, out, list, quick, force })
        }
        Command::Plot { runs, out } => {
            plot::draw(&runs, out.as_deref())?.iter().try_for_each(|path| print(&path.display().to_string()))
        }
        Command::Schema => print(&format!("{:#}", mics::case::schema())),
    }
}
