//! Where the repository's files lie.

use std::path::PathBuf;

/// A file or folder of the repository.
///
/// Cargo says where that is when it runs one of its programs. What was known when the program was compiled comes second:
/// clones that share a target folder share what is in it.
pub fn repository(path: &str) -> PathBuf {
    let root = std::env::var_os("CARGO_MANIFEST_DIR");
    root.map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../.."), PathBuf::from)
        .join(path)
}
