//! Bytes as a mesh: any bytes are one. For the fuzzer, and for what it has found.

use super::soup::Soup;
use arbitrary::{Arbitrary, Result, Unstructured};
use bevy_drape::prelude::*;

/// The mesh of some bytes.
pub fn soup_of(bytes: &[u8]) -> Soup {
    // What bytes do not say is zero; that they end is no error.
    read(&mut Unstructured::new(bytes)).unwrap_or_else(|_| Soup {
        positions: Vec::new(),
        indices: Vec::new(),
        strip: false,
        pin: 0,
        material: ClothMaterial::default(),
    })
}

fn read(bytes: &mut Unstructured<'_>) -> Result<Soup> {
    let flags = u8::arbitrary(bytes)?;
    let material = if flags & 2 == 0 { ClothMaterial::default() } else { material(bytes)? };
    let pin = u8::arbitrary(bytes)?.into();
    let count = bytes.int_in_range(0..=40)?;
    let positions = (0..count).map(|_| position(bytes, flags)).collect::<Result<_>>()?;
    let mut indices = Vec::new();
    while !bytes.is_empty() && indices.len() < 240 {
        indices.push(u32::from(u8::arbitrary(bytes)?) % (count as u32 + 1));
    }
    Ok(Soup { positions, indices, strip: flags & 1 == 1, pin, material })
}

/// Any bits, or a place of a coarse grid, where corners coincide and lie on lines.
fn position(bytes: &mut Unstructured<'_>, flags: u8) -> Result<[f32; 3]> {
    let mut position = [0.0; 3];
    for x in &mut position {
        *x = if flags & 4 == 0 {
            f32::from(i8::arbitrary(bytes)?) / 16.0
        } else {
            f32::from_bits(u32::arbitrary(bytes)?)
        };
    }
    Ok(position)
}

/// Any bits: most are refused.
fn material(bytes: &mut Unstructured<'_>) -> Result<ClothMaterial> {
    let mut number = || Ok(f32::from_bits(u32::arbitrary(bytes)?));
    Ok(ClothMaterial {
        area_density: number()?,
        thread_stiffness: number()?,
        shear_stiffness: number()?,
        flexural_rigidity: number()?,
        damping: number()?,
        max_strain: number()?,
        ..ClothMaterial::default()
    })
}
