//! Puts the git commit into the binary, for `run.json`.

use std::process::Command;

/// What git answers; `None` outside a repository.
fn git(words: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(words).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // In a worktree these lie elsewhere, and a path that is not there would build anew every time.
    for place in ["HEAD", "refs/heads"] {
        if let Some(path) = git(&["rev-parse", "--git-path", place]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]);
    println!("cargo::rustc-env=MICS_GIT_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}
