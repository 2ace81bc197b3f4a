//! Real data, which the project does not ship: read through `WHITEFURNACE_DATA`, or where it lies beside the project.
#![allow(clippy::print_stderr, reason = "a test that is skipped says so")]

use std::path::PathBuf;

/// The file or folder `name` of the data; None, with a line, where it is absent.
pub(crate) fn data(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("WHITEFURNACE_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    let path = root.join(name);
    if !path.exists() {
        eprintln!("skipped: {} is absent; WHITEFURNACE_DATA names the folder of real data", path.display());
    }
    path.exists().then_some(path)
}
