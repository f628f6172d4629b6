//! Puts the shipped cases into the binary, for `mics cases` and `mics new`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Files of a case that a copy needs: no pictures.
const KEPT: [&str; 3] = ["toml", "csv", "md"];

fn main() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=cases");
    let top = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut table = String::from("&[\n");
    for folder in sorted(&top.join("cases"))?.into_iter().filter(|p| p.join("case.toml").is_file())
    {
        let kept = |file: &PathBuf| {
            file.extension().is_some_and(|e| KEPT.iter().any(|kept| *kept == e)) && file.is_file()
        };
        let _ = write!(table, "    ({:?}, &[", name(&folder));
        for file in sorted(&folder)?.iter().filter(|file| kept(file)) {
            let _ = write!(table, "({:?}, include_str!({file:?})), ", name(file));
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
