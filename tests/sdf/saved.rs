//! Saved fields, held to bit equality after a round trip, and to the refusal of every damage.
//!
//! The checksum under test is written out by its definition, a bit at a time.

use crate::{meshes::*, support::dice::Dice};
use bevy::math::Vec3;
use bevy_drape::sdf::{DistanceField, PointBlock, SampleBlock, SavedFieldError, SignedDistance};

/// Where the parts of a file are [B], as its format says.
const VERSION: usize = 8;
const LENGTH: usize = 12;
const DIMS: usize = 16;
const ORIGIN: usize = 28;
const CELL: usize = 40;
const LEAST: usize = 44;
const GREATEST: usize = 56;
const HEADER: usize = 72;

fn small() -> DistanceField {
    bake(&sphere_mesh(4, 0.5), 0.25, 0.25)
}

fn refusal(bytes: &[u8]) -> SavedFieldError {
    DistanceField::from_bytes(bytes).expect_err("it is no field")
}

/// The CRC-32 of ISO-HDLC: reflected polynomial, all ones before and after.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |mut sum, &byte| {
        sum ^= u32::from(byte);
        for _ in 0..8 {
            sum = (sum >> 1) ^ if sum & 1 == 1 { 0xEDB8_8320 } else { 0 };
        }
        sum
    })
}

/// The file with other words at a place, and its checksums put right.
fn forged(at: usize, words: &[u32]) -> Vec<u8> {
    let mut bytes = small().to_bytes();
    for (i, word) in words.iter().enumerate() {
        bytes[at + 4 * i..][..4].copy_from_slice(&word.to_le_bytes());
    }
    let end = bytes.len() - 4;
    let sums = [(0..HEADER - 4, HEADER - 4), (HEADER..end, end)];
    for (part, place) in sums {
        let sum = crc(&bytes[part]);
        bytes[place..][..4].copy_from_slice(&sum.to_le_bytes());
    }
    bytes
}

#[test]
fn a_saved_field_comes_back_in_the_same_bits() {
    let mesh = bunny();
    let mut random = Dice(20);
    for field in [small(), bake(&mesh, 1.0 / 24.0, 0.0), bake(&mesh, 1.0 / 16.0, 0.3)] {
        let bytes = field.to_bytes();
        assert_eq!(bytes.len(), HEADER + 4 * field.values().len() + 4);
        let back = DistanceField::from_bytes(&bytes).expect("it is whole");
        assert_eq!(back, field);
        assert_eq!(back.to_bytes(), bytes);
        let bits = |field: &DistanceField| -> Vec<u32> {
            field.values().iter().map(|value| value.to_bits()).collect()
        };
        assert_eq!(bits(&back), bits(&field));
        assert_eq!(back.overestimate(), field.overestimate());
        for _ in 0..500 {
            let mut points = PointBlock::default();
            for lane in 0..16 {
                let p = random.in_box(1.5).as_vec3();
                (points.x[lane], points.y[lane], points.z[lane]) = (p.x, p.y, p.z);
                assert_eq!(back.sample(p), field.sample(p));
            }
            let (mut one, mut other) = (SampleBlock::default(), SampleBlock::default());
            back.sample_block(&points, &mut one);
            field.sample_block(&points, &mut other);
            assert_eq!(one, other);
        }
    }
}

/// The bytes of version 1 are what the format says, so that files stay readable.
#[test]
fn the_format_is_as_written_down() {
    let field = small();
    let bytes = field.to_bytes();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    let place = |at: usize| Vec3::from_array([0, 4, 8].map(|k| f32::from_bits(word(at + k))));
    assert_eq!(&bytes[..8], b"\x89SDF\r\n\x1a\n");
    assert_eq!((word(VERSION), word(LENGTH)), (1, 72));
    assert_eq!([0, 4, 8].map(|k| word(DIMS + k)), field.dims().to_array());
    assert_eq!(place(ORIGIN), field.origin());
    assert_eq!(f32::from_bits(word(CELL)), field.cell_size());
    let bounds = field.bounds().expect("a mesh has bounds");
    assert_eq!((place(LEAST), place(GREATEST)), (bounds.min.into(), bounds.max.into()));
    assert_eq!(word(HEADER - 4), crc(&bytes[..HEADER - 4]));
    for (i, value) in field.values().iter().enumerate() {
        assert_eq!(word(HEADER + 4 * i), value.to_bits());
    }
    let end = bytes.len() - 4;
    assert_eq!(word(end), crc(&bytes[HEADER..end]));
    assert_eq!(crc(b"123456789"), 0xCBF4_3926, "the check value of CRC-32");
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let bytes = small().to_bytes();
    for found in 0..bytes.len() {
        match refusal(&bytes[..found]) {
            SavedFieldError::Truncated { expected, found: told } => {
                assert!(told == found && expected > found && expected <= bytes.len(), "{found}");
                assert!(found < HEADER || expected == bytes.len());
            }
            other => panic!("{found}: {other}"),
        }
    }
    let longer = [&bytes[..], &[0, 0, 0]].concat();
    assert_eq!(refusal(&longer), SavedFieldError::Overlong { excess: 3 });
}

#[test]
fn every_damaged_byte_is_noticed() {
    let bytes = small().to_bytes();
    for at in 0..bytes.len() {
        for change in [0x01, 0x80, 0xFF] {
            let mut damaged = bytes.clone();
            damaged[at] ^= change;
            let error = refusal(&damaged);
            let named = match error {
                SavedFieldError::Foreign => at < VERSION,
                SavedFieldError::Truncated { .. } => (LENGTH..DIMS).contains(&at),
                SavedFieldError::Damaged { part: "header" } => (VERSION..HEADER).contains(&at),
                SavedFieldError::Damaged { part: "distances" } => at >= HEADER,
                _ => false,
            };
            assert!(named, "byte {at}: {error}");
        }
    }
}

#[test]
fn bytes_of_any_kind_are_refused_without_panic() {
    let mut random = Dice(21);
    let bytes = small().to_bytes();
    for round in 0..20_000 {
        let mut noise: Vec<u8> =
            (0..(200.0 * random.unit()) as usize).map(|_| (256.0 * random.unit()) as u8).collect();
        // As far into a good file as one gets.
        let kept = [0, 8, 16, 60, 72][round % 5].min(noise.len());
        noise[..kept].copy_from_slice(&bytes[..kept]);
        refusal(&noise);
    }
    for foreign in [&b"\x89PNG\r\n\x1a\n rest"[..], b"v 0 0 0\n", b"\x89SDF\n\x1a\n", &[0; 1000]] {
        assert_eq!(refusal(foreign), SavedFieldError::Foreign);
    }
}

#[test]
fn newer_versions_are_told_by_their_number() {
    for version in [2, 7, u32::MAX] {
        let error = refusal(&forged(VERSION, &[version]));
        assert_eq!(error, SavedFieldError::Version { version, known: 1 });
        assert!(error.to_string().contains(&format!("version {version}")), "{error}");
    }
    // A newer header may be longer, and still says what it is.
    let mut longer = small().to_bytes();
    longer[VERSION] = 2;
    longer[LENGTH] = 80;
    let sum = crc(&longer[..76]).to_le_bytes();
    longer[76..80].copy_from_slice(&sum);
    assert_eq!(refusal(&longer), SavedFieldError::Version { version: 2, known: 1 });
}

/// Headers that are whole, and say what cannot be: refused before memory is taken for them.
#[test]
fn impossible_headers_are_refused() {
    let real = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let table = [
        ("dimensions", DIMS, vec![0]),
        ("dimensions", DIMS + 4, vec![1]),
        ("dimensions", DIMS, vec![u32::MAX; 3]),
        ("dimensions", DIMS, vec![1 << 16, 1 << 16, 2]),
        ("dimensions", DIMS, vec![1 << 31, 1 << 31, 4]),
        ("cells", CELL, real(&[0.0])),
        ("cells", CELL, real(&[-0.25])),
        ("cells", CELL, real(&[nan])),
        ("cells", CELL, real(&[inf])),
        ("cells", CELL, real(&[1e-30])),
        ("cells", CELL, real(&[1e30])),
        ("places", ORIGIN, real(&[nan])),
        ("places", ORIGIN + 8, real(&[inf])),
        ("places", ORIGIN, real(&[f32::MIN, f32::NEG_INFINITY, 0.0])),
        ("bounds", ORIGIN, real(&[f32::MAX])),
        ("bounds", LEAST, real(&[nan])),
        ("bounds", LEAST, real(&[0.6])),
        ("bounds", LEAST + 4, real(&[-1e3])),
        ("bounds", GREATEST, real(&[inf])),
        ("bounds", GREATEST + 8, real(&[1e3])),
        ("distances", HEADER, real(&[nan])),
        ("distances", HEADER + 40, real(&[inf])),
        ("distances", HEADER + 4, real(&[-1e30])),
        ("a header", LENGTH, vec![76]),
    ];
    for (what, at, words) in table {
        let mut bytes = forged(at, &words);
        if at == LENGTH {
            let sum = crc(&bytes[..72]).to_le_bytes();
            bytes[72..76].copy_from_slice(&sum);
        }
        let error = refusal(&bytes);
        assert_eq!(error, SavedFieldError::Impossible { what }, "{at} {words:?}");
        assert!(error.to_string().contains("bake it again"), "{error}");
    }
    // As many nodes as may be, in a file without them.
    let error = refusal(&forged(DIMS, &[1 << 8, 1 << 9, 1 << 9]));
    let found = small().to_bytes().len();
    assert_eq!(error, SavedFieldError::Truncated { expected: HEADER + (4 << 26) + 4, found });
    assert_eq!(DistanceField::from_bytes(&forged(DIMS, &[])), Ok(small()));
}
