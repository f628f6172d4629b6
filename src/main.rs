//! The command line.

use clap::{Args, Parser, Subcommand};
use mics::run::Request;
use mics::{Result, check, output::plot, run};
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
        /// Print errors only.
        #[arg(long)]
        quiet: bool,
    },
    /// Read and check a case and describe it, without running it.
    Check {
        #[command(flatten)]
        scene: SceneArgs,
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
    match act(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Under mpirun every rank meets the same error. Rank 0 says it; the others leave it the time, since mpirun
            // ends all ranks as soon as one has failed.
            if std::env::var("OMPI_COMM_WORLD_RANK").is_ok_and(|rank| rank != "0") {
                std::thread::sleep(std::time::Duration::from_millis(500));
            } else {
                eprintln!("error: {error}");
            }
            ExitCode::from(error.exit_code())
        }
    }
}

fn act(command: Command) -> Result<()> {
    match command {
        Command::Run { scene: SceneArgs { case, set, petsc }, out, force, quiet } => {
            run::run(&Request { case, out, set, force, quiet, petsc })
        }
        Command::Check { scene } => check::check(&scene.case, &scene.set, &scene.petsc),
        Command::Plot { runs, out } => {
            for path in plot::draw(&runs, out.as_deref())? {
                println!("{}", path.display());
            }
            Ok(())
        }
        Command::Schema => {
            println!("{:#}", mics::case::schema());
            Ok(())
        }
    }
}
