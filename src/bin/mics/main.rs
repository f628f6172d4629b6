//! The command line.

mod cases;
mod export;
mod ranks;
mod study;
mod validate;

use clap::{Args, CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use mics::launch::Ranks;
use mics::run::Request;
use mics::{Error, Result, check, run};
use mics_plot::{film, plot, report};
use mics_run::print;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

/// The git commit that the program was built from.
const COMMIT: &str = env!("MICS_GIT_COMMIT");

/// The end of the manual page.
const EXIT_STATUS: &str = ".SH \"EXIT STATUS\"
0: done. 1: `mics validate` ran, and values fall short of their references or have moved from the \
page they are compared with; or `mics study` ran, and some of its runs are not done. 2: the case \
or the command line is wrong, and \
nothing was written. 3: the run failed, with the state before the failing step kept and named. \
130: interrupted by Ctrl-C, SIGTERM or SIGUSR1 after writing a checkpoint, from which --resume \
goes on.
.SH \"SEE ALSO\"
The method, the keys of a case and what was measured: README.md and the book beside it, docs/, in \
/usr/share/doc/mics where Debian's package is installed.";

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
        /// On so many ranks, by mpirun; auto: as many as there are cores, as far as cells and
        /// bodies are work for them [default: auto, and 1 where options or the case choose a
        /// solver].
        #[arg(long, value_name = "N|auto")]
        ranks: Option<Ranks>,
    },
    /// Read and check a case and describe it, without running it.
    Check {
        #[command(flatten)]
        scene: SceneArgs,
        /// Say what is wrong, and nothing else; no step is tried.
        #[arg(long)]
        quiet: bool,
    },
    /// Run a case over a table of overrides: study.csv, study.md, figures of values and errors.
    Study(study::Request),
    /// Write the linear system of one pressure solve of a case, for other programs to read and
    /// solve.
    ///
    /// The case is run up to that step, and leaves no run. The folder then holds the matrix with
    /// the free bodies in it, its sparse part and the bodies' factors apart, the right side, the
    /// exact solution and the null space, each in MatrixMarket's and in PETSc's form, and a
    /// README.md that says how to read and solve them in PETSc, Python and MATLAB. The step is
    /// solved by the options after --, and how many iterations that took is said.
    ExportSystem(export::Request),
    /// Draw the figures of run folders, each as PNG and SVG.
    ///
    /// Without --figure: the last state's vorticity and streamlines, forces, speeds, paths, profile
    /// and probes of each run, and Cd(Re) and St(Re) of all where they are measured. Of a run that
    /// goes on, what there is.
    Plot(plot::Request),
    /// Make a film of a run: an animated PNG, or a GIF, with a frame for each snapshot of its
    /// fields, all in the same colours.
    ///
    /// It shows the vorticity, the speed or the pressure, with the bodies coloured by size, speed
    /// or material; one half of each that moves is darker and turns with it. Browsers and most
    /// viewers play it. --strip sets frames beside each other instead, for a paper.
    Film(film::Request),
    /// Sum up a run in one self-contained HTML file.
    Report {
        /// The run's folder.
        run: PathBuf,
        /// The file [default: DIR/report.html].
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
    /// Begin a case of your own, DIR/case.toml, as a shipped one.
    New {
        /// The folder, which must not be there yet; the case is named as it.
        dir: PathBuf,
        /// The shipped case that it begins as; `mics cases` lists them.
        #[arg(long, value_name = "NAME", default_value = "cylinder-wake")]
        template: String,
    },
    /// List the shipped cases, or copy one.
    Cases {
        #[command(subcommand)]
        action: Option<cases::Action>,
    },
    /// Run the shipped cases and compare them with their references; status 1 where any falls
    /// short.
    Validate(validate::Request),
    /// Print the JSON Schema of a case, for editors.
    Schema {
        /// The keys in words instead, as the page docs/keys.md of the book.
        #[arg(long)]
        markdown: bool,
    },
    /// Print the completions of a shell.
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Print the manual page (troff).
    Man,
}

#[derive(Args)]
struct SceneArgs {
    /// The case file (TOML).
    case: PathBuf,
    /// Override a key of the case, e.g. fluid.viscosity=2.0, or particle.0.density=1200: entries of
    /// a list count from 0.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// PETSc options, after --.
    #[arg(last = true, value_name = "PETSC OPTIONS", allow_hyphen_values = true)]
    petsc: Vec<String>,
}

fn main() -> ExitCode {
    // Under mpirun every rank meets the same error. Rank 0 says it; the others leave it the time,
    // since mpirun ends all ranks as soon as one has failed.
    let speaks = !std::env::var("OMPI_COMM_WORLD_RANK").is_ok_and(|rank| rank != "0");
    let fail = |code: u8, say: &dyn Fn()| {
        if !speaks {
            std::thread::sleep(std::time::Duration::from_secs(3));
        }
        // Still there: only this rank has met it.
        say();
        ExitCode::from(code)
    };
    match Cli::try_parse() {
        // Help and version are "errors" of status 0.
        Err(e) => fail(u8::try_from(e.exit_code()).unwrap_or(2), &|| drop(e.print())),
        Ok(cli) => match act(cli.command) {
            Ok(status) => ExitCode::from(status),
            Err(stop @ Error::Interrupted(_)) => {
                fail(stop.exit_code(), &|| complain(&stop.to_string()))
            }
            Err(error) => fail(error.exit_code(), &|| complain(&format!("error: {error}"))),
        },
    }
}

/// Says it on standard error; one that takes nothing must not hide the status.
fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Does what the command line says, and returns the exit status.
fn act(command: Command) -> Result<u8> {
    let done = match command {
        Command::Run { scene, out, force, resume, quiet, ranks } => {
            return run_case(scene, out, force, resume, quiet, ranks);
        }
        Command::Check { scene, quiet } => {
            ranks::check(&scene.case, &scene.set)?;
            check::check(&scene.case, &scene.set, &scene.petsc, quiet)
        }
        Command::Study(request) => study::study(&request),
        Command::ExportSystem(request) => export::export(&request),
        Command::Plot(request) => {
            let drawn = plot::draw(&request)?;
            drawn.notes.iter().for_each(|note| complain(note));
            drawn.files.iter().try_for_each(|path| print(&path.display().to_string()))
        }
        Command::Film(request) => {
            film::make(&request)?.iter().try_for_each(|path| print(&path.display().to_string()))
        }
        Command::Report { run, out } => {
            print(&report::write(&run, out.as_deref())?.display().to_string())
        }
        Command::New { dir, template } => cases::begin(&dir, &template),
        Command::Cases { action } => cases::cases(action),
        Command::Validate(request) => validate::validate(&request),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "mics", &mut script);
            print(String::from_utf8_lossy(&script).trim_end())
        }
        Command::Man => manual(),
        Command::Schema { markdown: true } => print(mics::config::reference().trim_end()),
        Command::Schema { markdown: false } => print(&format!("{:#}", mics::config::schema())),
    };
    done.map(|()| 0)
}

/// Runs a case, here or on ranks of its own, and returns the exit status.
fn run_case(
    scene: SceneArgs,
    out: Option<PathBuf>,
    force: bool,
    resume: bool,
    quiet: bool,
    ranks: Option<Ranks>,
) -> Result<u8> {
    let SceneArgs { case, set, petsc } = scene;
    let choice = ranks::Choice {
        ranks,
        case: &case,
        set: &set,
        options: !petsc.is_empty(),
        out: out.as_deref(),
        shown: !quiet,
    };
    if let Some(status) = ranks::run(&choice)? {
        return Ok(status);
    }
    let draw = plot::draw_run;
    let commit = COMMIT;
    run::run(&Request { case, out, set, force, resume, quiet, petsc, draw, commit }).map(|()| 0)
}

/// The manual page: the program's, with every command's options.
fn manual() -> Result<()> {
    let mut page = Vec::new();
    let mut command = Cli::command();
    command.build();
    let failed = mics::Error::io("the manual page");
    let render = |page: &mut Vec<u8>| -> std::io::Result<()> {
        let man = clap_mangen::Man::new(command.clone());
        man.render_title(page)?;
        man.render_name_section(page)?;
        man.render_synopsis_section(page)?;
        man.render_description_section(page)?;
        for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
            let name = format!("mics {}", sub.get_name());
            writeln!(page, ".SH \"{}\"", name.to_uppercase())?;
            let man = clap_mangen::Man::new(sub.clone());
            let mut part = Vec::new();
            man.render_synopsis_section(&mut part)?;
            man.render_description_section(&mut part)?;
            man.render_options_section(&mut part)?;
            page.extend(String::from_utf8_lossy(&part).replace(".SH ", ".SS ").bytes());
        }
        writeln!(page, "{EXIT_STATUS}")
    };
    render(&mut page).map_err(failed)?;
    print(String::from_utf8_lossy(&page).trim_end())
}
