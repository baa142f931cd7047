//! Voxels as few boxes.

use std::collections::BTreeSet;

use bevy::prelude::*;

/// A box of voxels: the first and the last along each axis.
pub(crate) type VoxelBox = [IVec3; 2];

/// Boxes that hold each voxel once: each is grown as far as it goes along x, then along z, then along y.
pub(crate) fn boxes_of(voxels: impl Iterator<Item = IVec3>) -> Vec<VoxelBox> {
    let mut left: BTreeSet<[i32; 3]> = voxels.map(|it| it.to_array()).collect();
    let mut boxes = Vec::new();
    while let Some(first) = left.first() {
        let first = IVec3::from_array(*first);
        let mut grown = [first, first];
        for step in [IVec3::X, IVec3::Z, IVec3::Y] {
            while let Some(next) = beyond(grown, step, &left) {
                grown[1] = next;
            }
        }
        for voxel in inside(grown) {
            left.remove(&voxel.to_array());
        }
        boxes.push(grown);
    }
    boxes
}

/// The last voxel of a box that is a layer longer, if all of that layer is there.
fn beyond([first, last]: VoxelBox, step: IVec3, left: &BTreeSet<[i32; 3]>) -> Option<IVec3> {
    let next = last + step;
    let layer = [first + step * (next - first), next];
    inside(layer).all(|voxel| left.contains(&voxel.to_array())).then_some(next)
}

fn inside([first, last]: VoxelBox) -> impl Iterator<Item = IVec3> {
    let rows = (first.y..=last.y).flat_map(move |y| (first.z..=last.z).map(move |z| (y, z)));
    rows.flat_map(move |(y, z)| (first.x..=last.x).map(move |x| IVec3::new(x, y, z)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_one_box() {
        let block = [IVec3::new(-1, 2, 3), IVec3::new(3, 4, 9)];
        assert_eq!(boxes_of(inside(block)), [block]);
        assert_eq!(boxes_of(core::iter::empty()), [] as [VoxelBox; 0]);
    }

    #[test]
    fn every_voxel_is_in_one_box() {
        // Every seventh is missing.
        let block = [IVec3::ZERO, IVec3::new(8, 6, 5)];
        let voxels: Vec<_> = inside(block).enumerate().filter(|(i, _)| i % 7 > 0).collect();
        let boxes = boxes_of(voxels.iter().map(|(_, voxel)| *voxel));
        let mut held: Vec<_> =
            boxes.iter().flat_map(|it| inside(*it)).map(|it| it.to_array()).collect();
        held.sort_unstable();
        let mut expected: Vec<_> = voxels.iter().map(|(_, voxel)| voxel.to_array()).collect();
        expected.sort_unstable();
        assert_eq!(held, expected);
    }
}
