//! What the fuzzer found worth keeping, once more. Truth: nothing panics, and what is a field or a cloth is a
//! sound one.

use super::{
    decode::soup_of,
    field::{check_field, summed},
    soup::{app, check_soup},
};
use bevy_drape::sdf::{DistanceField, SavedFieldError};
use examples_common::repository;
use std::{collections::BTreeSet, path::PathBuf};

/// The files of a target, by name.
fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = repository("tests/corpus").join(target);
    let files = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    assert!(paths.len() > 20, "{folder:?} holds {}", paths.len());
    paths.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

/// Why it is no field.
fn reason(bytes: &[u8]) -> Option<&'static str> {
    Some(match DistanceField::from_bytes(bytes).err()? {
        SavedFieldError::Foreign => "foreign",
        SavedFieldError::Version { .. } => "version",
        SavedFieldError::Truncated { .. } => "truncated",
        SavedFieldError::Overlong { .. } => "overlong",
        SavedFieldError::Damaged { part } => part,
        SavedFieldError::Impossible { what } => what,
        error => panic!("{error}: a reason that no file of the corpus is for"),
    })
}

#[test]
fn fields_of_the_corpus() {
    let files = corpus("saved_field");
    let found = files.iter().map(|(path, bytes)| {
        check_field(bytes).unwrap_or_else(|problem| panic!("{path:?}: {problem}"))
    });
    let fields = found.filter(|is_field| *is_field).count();
    let (count, reasons) =
        (files.len(), files.iter().flat_map(|(_, bytes)| [reason(bytes), reason(&summed(bytes))]));
    let reasons: BTreeSet<_> = reasons.flatten().collect();
    // Whoever adds a file tells here what becomes of it.
    assert_eq!((fields, count), (14, 95), "fields of files");
    let all = [
        "a header",
        "bounds",
        "cells",
        "dimensions",
        "distances",
        "foreign",
        "header",
        "overlong",
        "places",
        "truncated",
        "version",
    ];
    assert_eq!(reasons, BTreeSet::from(all), "each reason to refuse one is there");
}

#[test]
fn meshes_of_the_corpus() {
    let mut app = app();
    let files = corpus("mesh_intake");
    let found = files.iter().map(|(path, bytes)| {
        check_soup(&mut app, &soup_of(bytes))
            .unwrap_or_else(|problem| panic!("{path:?}: {problem}"))
    });
    let cloths = found.filter(|is_cloth| *is_cloth).count();
    // Whoever adds a file tells here what becomes of it.
    // Five have T-junctions and no other fault.
    assert_eq!((cloths, files.len()), (308, 465), "cloths of files");
}
