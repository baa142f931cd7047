//! Materials as files in RON, to be read and edited by hand.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::cloth::material::ClothMaterial;

/// Why a material was not saved or loaded.
#[derive(Debug, thiserror::Error)]
pub enum MaterialFileError {
    /// The file cannot be read or written.
    #[error("{path}: {error}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why not.
        error: io::Error,
    },
    /// The file does not hold a material.
    #[error("{path} is no material: {error}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The problem, and its line.
        error: Box<ron::error::SpannedError>,
    },
    /// A number cannot be written: it is no number.
    #[error(transparent)]
    Write(Box<ron::Error>),
}

/// Writes a material to a file.
///
/// # Errors
/// [`MaterialFileError`].
pub fn save_material(path: &Path, material: &ClothMaterial) -> Result<(), MaterialFileError> {
    let text = ron::ser::to_string_pretty(material, ron::ser::PrettyConfig::default())
        .map_err(|error| MaterialFileError::Write(Box::new(error)))?;
    fs::write(path, text + "\n")
        .map_err(|error| MaterialFileError::Io { path: path.to_owned(), error })
}

/// Reads a material from a file. Whether its numbers can be used is found where it is.
///
/// # Errors
/// [`MaterialFileError`].
pub fn load_material(path: &Path) -> Result<ClothMaterial, MaterialFileError> {
    let text = fs::read_to_string(path)
        .map_err(|error| MaterialFileError::Io { path: path.to_owned(), error })?;
    ron::from_str(&text).map_err(|error| MaterialFileError::Format {
        path: path.to_owned(),
        error: Box::new(error),
    })
}
