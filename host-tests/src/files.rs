//! Results -> files: each is written beside its place and moved there when it is whole.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file as a whole or not at all: `fill` writes to a temporary file in the same folder, which takes the
/// place of `path` when `fill` has succeeded and is removed when it has not. Folders are made as needed.
pub fn write_whole(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    if let Some(folder) = folder {
        fs::create_dir_all(folder)?;
    }
    let part = Part(part_name(path)?);
    let mut out = BufWriter::with_capacity(1 << 20, File::create(&part.0)?);
    fill(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?;
    fs::rename(&part.0, path)
}

fn part_name(path: &Path) -> io::Result<PathBuf> {
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "a file name is expected"))?;
    let mut part = std::ffi::OsString::from(".");
    part.push(name);
    part.push(format!(".{}.part", std::process::id()));
    Ok(path.with_file_name(part))
}

/// A temporary file, removed when it has not been moved to its place.
struct Part(PathBuf);

impl Drop for Part {
    fn drop(&mut self) {
        // After a successful move there is nothing left to remove, and that is no failure.
        let _ = fs::remove_file(&self.0);
    }
}
