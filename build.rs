//! Puts into the binary the git commit, for `run.json`, and the shipped cases, for `mics cases` and
//! `mics new`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Files of a case that a copy needs: no pictures.
const KEPT: [&str; 4] = ["toml", "csv", "md", "stl"];

/// What git answers; `None` outside a repository.
fn git(words: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(words).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}

fn main() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    name_commit();
    keep_cases()
}

/// Names the commit that the program is built from.
fn name_commit() {
    // In a worktree these lie elsewhere, and a path that is not there would build anew every time.
    for place in ["HEAD", "refs/heads"] {
        if let Some(path) = git(&["rev-parse", "--git-path", place]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]);
    println!("cargo::rustc-env=MICS_GIT_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}

/// Writes the table of the shipped cases and their files.
fn keep_cases() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=cases");
    let top = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut table = String::from("&[\n");
    for folder in sorted(&top.join("cases"))?.into_iter().filter(|p| p.join("case.toml").is_file())
    {
        let kept = |file: &&PathBuf| {
            file.extension().is_some_and(|e| KEPT.iter().any(|kept| *kept == e)) && file.is_file()
        };
        let _ = write!(table, "    ({:?}, &[", name(&folder));
        let mut files = sorted(&folder)?;
        for within in files.clone().iter().filter(|path| path.is_dir()) {
            files.extend(sorted(within)?);
        }
        for file in files.iter().filter(kept) {
            let within = file.strip_prefix(&folder).unwrap_or(file);
            let _ = write!(table, "({within:?}, include_str!({file:?})), ");
        }
        table += "]),\n";
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    std::fs::write(out.join("cases.rs"), table + "]")
}

/// What is in a folder, in the order of its names.
fn sorted(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let found = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut found = found.collect::<std::io::Result<Vec<_>>>()?;
    found.sort();
    Ok(found)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
