//! What the fuzzer found worth keeping, once more. Truth: nothing panics, and what is a field or a cloth is a
//! sound one.

use super::{
    decode::soup_of,
    field::check_field,
    soup::{app, check_soup},
};
use crate::support::repository::repository;
use std::path::PathBuf;

/// The files of a target, by name.
fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = repository("tests/corpus").join(target);
    let files = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    assert!(paths.len() > 20, "{folder:?} holds {}", paths.len());
    paths.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

#[test]
fn fields_of_the_corpus() {
    let found = corpus("saved_field").into_iter().map(|(path, bytes)| {
        check_field(&bytes).unwrap_or_else(|problem| panic!("{path:?}: {problem}"))
    });
    assert!(found.filter(|is_field| *is_field).count() > 0);
}

#[test]
fn meshes_of_the_corpus() {
    let mut app = app();
    let found = corpus("mesh_intake").into_iter().map(|(path, bytes)| {
        check_soup(&mut app, &soup_of(&bytes))
            .unwrap_or_else(|problem| panic!("{path:?}: {problem}"))
    });
    assert!(found.filter(|is_cloth| *is_cloth).count() > 0);
}
