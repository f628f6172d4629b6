//! The shipped cases, which the binary holds: a list of them, copies, and cases of one's own that
//! begin as one of them.

use clap::Subcommand;
use mics::config::suggest;
use mics::{Error, Result};
use mics_run::print;
use std::path::{Path, PathBuf};

/// Each case's name and its files, by name.
const SHIPPED: &[(&str, &[(&str, &str)])] = include!(concat!(env!("OUT_DIR"), "/cases.rs"));

/// The file of a case that `mics run` takes.
const CASE: &str = "case.toml";

/// The schema of a case, by which an editor completes its keys.
const SCHEMA: &str = "case.schema.json";

/// Actions on the shipped cases.
#[derive(Subcommand)]
pub enum Action {
    /// Copy a case with its studies and reference data into a folder.
    Copy {
        /// The case's name.
        name: String,
        /// The folder, which must not be there yet [default: NAME].
        dir: Option<PathBuf>,
    },
}

/// Lists the shipped cases, or copies one.
///
/// # Errors
/// When there is no such case, or the folder is there or cannot be written.
pub fn cases(action: Option<Action>) -> Result<()> {
    let Some(Action::Copy { name, dir }) = action else {
        let width = SHIPPED.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        return SHIPPED
            .iter()
            .try_for_each(|(name, files)| print(&format!("{name:<width$}  {}", scene(files))));
    };
    let (name, files) = shipped(&name)?;
    let folder = dir.unwrap_or_else(|| name.into());
    write(&folder, files.iter().map(|(file, text)| (*file, standing_alone(file, text))))?;
    print(&format!("mics run {}", folder.join(CASE).display()))
}

/// Begins a case of one's own, `DIR/case.toml`, named as its folder, with what a shipped one has.
///
/// # Errors
/// When there is no such case, or the folder is there or cannot be written.
pub fn begin(folder: &Path, template: &str) -> Result<()> {
    let (_, files) = shipped(template)?;
    let own = folder.file_name().unwrap_or_default().to_string_lossy();
    let text = |(file, text): &(&'static str, &str)| {
        let self_contained = standing_alone(file, text);
        let renamed = |line: &str| match line.split_once('=') {
            Some((key, _)) if key.trim() == "name" && *file == CASE => format!("name = {own:?}"),
            _ => line.to_owned(),
        };
        // The first name is the case's: those of particles and measures come later.
        let at = self_contained.lines().position(|line| renamed(line) != line);
        let line = |(n, line): (usize, &str)| {
            if Some(n) == at { renamed(line) + "\n" } else { format!("{line}\n") }
        };
        // A case of one's own has no reference yet.
        let own_line = |(_, line): &(usize, &str)| {
            let key = line.split('=').next().unwrap_or_default().trim();
            !["reference", "tolerance", "source"].contains(&key)
        };
        (*file, self_contained.lines().enumerate().filter(own_line).map(line).collect())
    };
    // Studies, pages and reference data are those of the shipped case.
    let read = |file: &str| files.iter().any(|(_, text)| text.contains(&format!("\"{file}\"")));
    let kept = |(file, _): &&(&str, &str)| *file == CASE || file.ends_with(".csv") && read(file);
    write(folder, files.iter().filter(kept).map(text))?;
    print(&format!("mics check {}", folder.join(CASE).display()))
}

/// A shipped case by its name.
fn shipped(name: &str) -> Result<&'static (&'static str, &'static [(&'static str, &'static str)])> {
    SHIPPED.iter().find(|(own, _)| *own == name).ok_or_else(|| {
        let names: Vec<_> = SHIPPED.iter().map(|(name, _)| *name).collect();
        let like = suggest(name, &names);
        Error::Usage(format!("no shipped case is called \"{name}\": {like}"))
    })
}

/// The text of a file of the shipped cases, as `CASE/FILE`; empty where there is none.
pub fn text(file: &str) -> &'static str {
    let (case, file) = file.split_once('/').unwrap_or_default();
    let files = shipped(case).map_or(&[][..], |(_, files)| files);
    files.iter().find(|(name, _)| *name == file).map_or("", |(_, text)| text)
}

/// Scene of a case in words: the first sentence of its first comment.
fn scene(files: &[(&str, &str)]) -> String {
    let text = files.iter().find(|(file, _)| *file == CASE).map_or("", |(_, text)| text);
    let lines = text.lines().skip_while(|line| !line.starts_with("# "));
    let lines = lines.map_while(|line| line.strip_prefix("# "));
    let mut said = String::new();
    for word in lines.flat_map(str::split_whitespace) {
        // A source in brackets has points of its own.
        let within = said.matches('(').count() > said.matches(')').count();
        let capital = word.starts_with(|letter: char| letter.is_uppercase());
        if said.ends_with('.') && capital && !within {
            break;
        }
        said += if said.is_empty() { "" } else { " " };
        said += word;
    }
    said
}

/// The text of a file with, of a case, the name of the schema beside it in place of that beside the
/// repository's cases.
fn standing_alone(file: &str, text: &str) -> String {
    let is_case = file.ends_with(".toml") && !file.ends_with(".study.toml");
    let schema = is_case.then(|| format!("#:schema {SCHEMA}"));
    let lines = text.lines().filter(|line| !line.starts_with("#:schema"));
    schema.as_deref().into_iter().chain(lines).flat_map(|line| [line, "\n"]).collect()
}

/// Writes files into a new folder, and the schema that cases name.
fn write<'a>(folder: &Path, files: impl Iterator<Item = (&'a str, String)>) -> Result<()> {
    if folder.exists() {
        let there = folder.display();
        return Err(Error::Usage(format!("{there} is there already: name another folder")));
    }
    let schema = (SCHEMA, format!("{:#}\n", mics::config::schema()));
    for (name, text) in files.chain([schema]) {
        let file = folder.join(name);
        let within = file.parent().unwrap_or(folder);
        std::fs::create_dir_all(within).map_err(Error::io(within))?;
        std::fs::write(&file, text).map_err(Error::io(&file))?;
    }
    Ok(())
}
