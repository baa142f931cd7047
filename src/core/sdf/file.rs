//! Saved fields: bytes that say what they are, and are refused if they are not whole.
//!
//! All numbers are little-endian. Version 1:
//!
//! | offset \[B\] | content |
//! | --- | --- |
//! | 0 | the eight bytes of [`MAGIC`] |
//! | 8 | version, `u32` |
//! | 12 | length of the header \[B\], `u32` |
//! | 16 | nodes along each axis, three `u32` |
//! | 28 | position of the first node \[m\], three `f32` |
//! | 40 | spacing of the nodes \[m\], `f32` |
//! | 44 | smallest box around the mesh \[m\], its least and its greatest corner, six `f32` |
//! | 68 | CRC-32 of the header so far, `u32` |
//! | 72 | distances at the nodes \[m\], `f32`, x fastest, then y, then z |
//! | end - 4 | CRC-32 of the distances, `u32` |
//!
//! In every version the magic, the version and the header's length stay where they are, and the header
//! ends with its checksum: so a newer file is known for one, and not taken for a damaged one. What the
//! header says is checked before anything is allocated by it.

use super::{DistanceField, MAX_NODES, bake::is_usable_cell_size};
use bevy_math::{UVec3, Vec3};
use thiserror::Error;

/// Like that of PNG: not text, and it shows when a transfer has changed line ends.
const MAGIC: [u8; 8] = [0x89, b'S', b'D', b'F', b'\r', b'\n', 0x1a, b'\n'];
/// The version that is written, and the newest that is read.
const VERSION: u32 = 1;
/// Magic, version and the header's length \[B\].
const PREFIX: usize = 16;
/// Header of version 1 \[B\].
const HEADER: usize = 72;
/// No version's header will be longer \[B\]: a number beyond it is damaged.
const LONGEST_HEADER: usize = 4096;
/// A CRC-32 \[B\].
const CHECKSUM: usize = 4;

/// Why bytes are no [`DistanceField`].
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SavedFieldError {
    /// It does not begin as a saved field does.
    #[error("it is not a saved distance field: bake one, and give the file that came of it")]
    Foreign,
    /// It was written by a newer version.
    #[error(
        "it is a distance field of version {version}, and only up to {known} can be read: bake it again, or update \
         `bevy_drape`, or `bevy_drape_core`"
    )]
    Version {
        /// The file's version.
        version: u32,
        /// The newest that is known.
        known: u32,
    },
    /// It ends too early.
    #[error(
        "it is cut short, {found} bytes of at least {expected}: copy it again, or bake it again"
    )]
    Truncated {
        /// Least length that it should have \[B\].
        expected: usize,
        /// Length that it has \[B\].
        found: usize,
    },
    /// It goes on behind its end.
    #[error("{excess} bytes follow behind its end: copy it again, or bake it again")]
    Overlong {
        /// Bytes too many.
        excess: usize,
    },
    /// A checksum differs.
    #[error("its {part} was damaged, the checksum differs: copy it again, or bake it again")]
    Damaged {
        /// Which part: the header or the distances.
        part: &'static str,
    },
    /// Its checksums are right, but it says what no field can be.
    #[error("no distance field has such {what}: bake it again")]
    Impossible {
        /// The problem.
        what: &'static str,
    },
}

impl DistanceField {
    /// The field as the bytes of an `.sdf` file: 76 and four for each node.
    ///
    /// The file is the same on every platform, and [`from_bytes`](Self::from_bytes) makes of it a field
    /// of the same bits.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER + size_of_val(&*self.values) + CHECKSUM);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((HEADER as u32).to_le_bytes());
        bytes.extend(self.dims.to_array().map(u32::to_le_bytes).as_flattened());
        let cell_size = [self.cell_size];
        let place = [self.origin, self.surface_min, self.surface_max].map(|place| place.to_array());
        for numbers in [&place[0][..], &cell_size, &place[1], &place[2]] {
            bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        }
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes.extend(self.values.iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend(crc32fast::hash(&bytes[HEADER..]).to_le_bytes());
        bytes
    }

    /// The field of an `.sdf` file's bytes.
    ///
    /// # Errors
    ///
    /// [`SavedFieldError`] for a file of another kind, a newer or damaged one, and one cut short. No bytes
    /// make it panic, or take more memory than they themselves do.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SavedFieldError> {
        let header = Header::new(bytes)?;
        let node_count = header.check()?;
        let distances = &bytes[HEADER..];
        let expected = HEADER + node_count * size_of::<f32>() + CHECKSUM;
        if bytes.len() < expected {
            return Err(SavedFieldError::Truncated { expected, found: bytes.len() });
        }
        if bytes.len() > expected {
            return Err(SavedFieldError::Overlong { excess: bytes.len() - expected });
        }
        let distances = check_sum(distances, "distances")?;
        let (numbers, _) = distances.as_chunks();
        let values: Box<[f32]> = numbers.iter().map(|number| f32::from_le_bytes(*number)).collect();
        // The mesh lies within the grid: nothing in it is further from it than the grid is long.
        let farthest = 1.001 * header.cell_size * header.dims.as_vec3().length();
        if !values.iter().all(|value| value.abs() <= farthest) {
            return Err(SavedFieldError::Impossible { what: "distances" });
        }
        let Header { dims, origin, cell_size, surface_min, surface_max } = header;
        Ok(Self { origin, cell_size, dims, values, surface_min, surface_max })
    }
}

/// A header of version 1.
struct Header {
    dims: UVec3,
    origin: Vec3,
    cell_size: f32,
    surface_min: Vec3,
    surface_max: Vec3,
}

impl Header {
    /// Reads the header and holds it against its checksum.
    fn new(bytes: &[u8]) -> Result<Self, SavedFieldError> {
        let found = bytes.len();
        let begun = found.min(MAGIC.len());
        if bytes[..begun] != MAGIC[..begun] {
            return Err(SavedFieldError::Foreign);
        }
        if found < PREFIX {
            return Err(SavedFieldError::Truncated { expected: HEADER, found });
        }
        let mut numbers = Numbers(&bytes[MAGIC.len()..]);
        let version = numbers.whole();
        let length = numbers.whole() as usize;
        if !(PREFIX + CHECKSUM..=LONGEST_HEADER).contains(&length) {
            return Err(SavedFieldError::Damaged { part: "header" });
        }
        if found < length {
            return Err(SavedFieldError::Truncated { expected: length, found });
        }
        check_sum(&bytes[..length], "header")?;
        if version != VERSION {
            return Err(SavedFieldError::Version { version, known: VERSION });
        }
        if length != HEADER {
            return Err(SavedFieldError::Impossible { what: "a header" });
        }
        Ok(Self {
            dims: UVec3::from_array(core::array::from_fn(|_| numbers.whole())),
            origin: numbers.place(),
            cell_size: numbers.real(),
            surface_min: numbers.place(),
            surface_max: numbers.place(),
        })
    }

    /// Checks every number, and counts the nodes.
    fn check(&self) -> Result<usize, SavedFieldError> {
        let impossible = |what| Err(SavedFieldError::Impossible { what });
        let [x, y, z] = self.dims.to_array().map(u64::from);
        let node_count = x.checked_mul(y).and_then(|area| area.checked_mul(z));
        let Some(node_count) = node_count.filter(|count| *count <= MAX_NODES as u64) else {
            return impossible("dimensions");
        };
        if self.dims.min_element() < 2 {
            return impossible("dimensions");
        }
        if !is_usable_cell_size(self.cell_size) {
            return impossible("cells");
        }
        let end = self.origin + self.cell_size * self.dims.as_vec3();
        if !(self.origin.is_finite() && end.is_finite()) {
            return impossible("places");
        }
        // The far end has a cell more than the grid, for what rounding may add. NaN is in no box.
        let (min, max) = (self.surface_min, self.surface_max);
        let in_order = min.cmple(max) & min.cmpge(self.origin) & max.cmple(end);
        if !in_order.all() {
            return impossible("bounds");
        }
        Ok(node_count as usize)
    }
}

/// Splits off the checksum that `bytes` end with, and holds the rest against it.
fn check_sum<'a>(bytes: &'a [u8], part: &'static str) -> Result<&'a [u8], SavedFieldError> {
    let damaged = SavedFieldError::Damaged { part };
    let (rest, sum) = bytes.split_last_chunk::<CHECKSUM>().ok_or(damaged.clone())?;
    if crc32fast::hash(rest) == u32::from_le_bytes(*sum) { Ok(rest) } else { Err(damaged) }
}

/// Numbers read one after the other, from bytes that are long enough.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn whole(&mut self) -> u32 {
        let Some((number, rest)) = self.0.split_first_chunk::<4>() else {
            return 0;
        };
        self.0 = rest;
        u32::from_le_bytes(*number)
    }

    fn real(&mut self) -> f32 {
        f32::from_bits(self.whole())
    }

    fn place(&mut self) -> Vec3 {
        Vec3::from_array(core::array::from_fn(|_| self.real()))
    }
}
