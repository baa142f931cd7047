//! Bytes as a saved field: what must hold of them. For the property tests and for the fuzzer.

use bevy::math::Vec3;
use bevy_drape::sdf::{DistanceField, PointBlock, SampleBlock, SignedDistance};

/// Where a file's header ends, its checksum included \[B\].
const HEADER: usize = 72;

/// Looks at bytes as they are, and at the same with their checksums put right. Tells whether one of both is a
/// field.
///
/// # Errors
/// What did not hold.
pub fn check_field(bytes: &[u8]) -> Result<bool, String> {
    let as_it_is = look(bytes)?;
    Ok(look(&summed(bytes))? || as_it_is)
}

/// With checksums that are right, or it would be refused for them alone.
pub fn summed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let end = bytes.len();
    if end >= HEADER + 4 {
        for (from, to) in [(0, HEADER - 4), (HEADER, end - 4)] {
            let sum = crc32fast::hash(&bytes[from..to]).to_le_bytes();
            bytes[to..to + 4].copy_from_slice(&sum);
        }
    }
    bytes
}

fn look(bytes: &[u8]) -> Result<bool, String> {
    let field = match DistanceField::from_bytes(bytes) {
        Ok(field) => field,
        Err(error) if error.to_string().is_empty() => return Err("it is not told why".into()),
        Err(_) => return Ok(false),
    };
    if field.to_bytes() != bytes {
        return Err("it is saved in other bytes".into());
    }
    let cell = field.cell_size();
    let size = field.dims().as_vec3() * cell;
    let mut points = PointBlock::default();
    for lane in 0..16 {
        let part = Vec3::new((lane % 3) as f32, (lane / 3 % 3) as f32, (lane / 9) as f32) * 0.49;
        let p = field.origin() + size * part;
        (points.x[lane], points.y[lane], points.z[lane]) = (p.x, p.y, p.z);
    }
    let mut block = SampleBlock::default();
    field.sample_block(&points, &mut block);
    for lane in 0..16 {
        let at = points.point(lane);
        let sample = field.sample(at);
        let length = sample.normal.length();
        if !sample.distance.is_finite() || (length - 1.0).abs() > 1e-3 {
            return Err(format!("{sample:?} at {at}"));
        }
        if sample.distance.to_bits() != block.distance[lane].to_bits() {
            return Err(format!("in a block it is {} at {at}", block.distance[lane]));
        }
    }
    if !(field.overestimate() >= 0.0 && field.overestimate().is_finite()) {
        return Err(format!("it overestimates by {}", field.overestimate()));
    }
    Ok(true)
}
