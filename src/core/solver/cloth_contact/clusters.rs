//! The particles of a mesh in compact clusters: what is near each other on the cloth.

use bevy_math::Vec3;

use crate::solver::cloth_contact::faces::FacesAt;

/// Which cluster a particle is in that is in none yet.
const NONE: u32 = u32::MAX;

/// The clusters of a mesh.
#[derive(Debug)]
pub(super) struct Clusters {
    /// Slots of the particles of each cluster, all of them one piece of cloth.
    pub all: Vec<Vec<u32>>,
    /// The cluster of each slot.
    of: Vec<u32>,
}

impl Clusters {
    /// Clusters of so many particles at most, of those at some slots, which are at these places at rest.
    pub fn new(
        faces: &FacesAt,
        slots: impl Iterator<Item = usize>,
        rest: impl Fn(u32) -> Vec3,
        most: usize,
    ) -> Self {
        let mut clusters = Self { all: Vec::new(), of: vec![NONE; faces.slots()] };
        for seed in slots {
            if clusters.of[seed] == NONE {
                clusters.grow(faces, seed as u32, &rest, most);
            }
        }
        clusters
    }

    /// The cluster of the particle at a slot.
    pub fn of(&self, slot: u32) -> u32 {
        self.of[slot as usize]
    }

    /// Grows a cluster from a particle on: each next one is that of its neighbours which shares most faces with it, and of these
    /// the one that is nearest to the first.
    fn grow(&mut self, faces: &FacesAt, seed: u32, rest: impl Fn(u32) -> Vec3, most: usize) {
        let own = self.all.len() as u32;
        let (mut cluster, mut rim) = (Vec::with_capacity(most), Vec::new());
        let mut next = Some(seed);
        while let Some(slot) = next {
            self.of[slot as usize] = own;
            cluster.push(slot);
            if cluster.len() == most {
                break;
            }
            for neighbour in faces.of(slot as usize).flatten() {
                if self.of[neighbour as usize] == NONE && !rim.contains(&neighbour) {
                    rim.push(neighbour);
                }
            }
            rim.retain(|&other| other != slot);
            let shared = |slot: u32| {
                let corners = faces.of(slot as usize).flatten();
                corners.filter(|&corner| self.of[corner as usize] == own).count()
            };
            let far = |slot: u32| rest(slot).distance_squared(rest(seed));
            next = rim.iter().copied().min_by(|&a, &b| {
                let order = shared(b).cmp(&shared(a)).then(far(a).total_cmp(&far(b)));
                order.then(a.cmp(&b))
            });
        }
        self.all.push(cluster);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_math::Vec2;

    use super::*;
    use crate::solver::settings::MassLumping;
    use crate::solver::topology::Topology;
    use crate::solver::topology::graph::Graph;
    use crate::solver::topology::lattice::Lattice;

    #[test]
    fn clusters_are_nearly_full_and_compact() {
        let most = 16;
        for side in [16_usize, 48, 64] {
            let sheet = Lattice::sheet(Vec2::ONE, side, side, MassLumping::Lumped).unwrap();
            let cells = (0..side - 1).flat_map(|r| (0..side - 1).map(move |c| r * side + c));
            let triangles: Vec<_> = cells
                .flat_map(|a| [[a, a + side, a + side + 1], [a, a + side + 1, a + 1]])
                .map(|corners| corners.map(|corner| corner as u32))
                .collect();
            let mesh = Graph::new(sheet.rest_positions(), &triangles, MassLumping::Lumped).unwrap();
            let topology = Topology::from(Arc::new(mesh));
            let faces = FacesAt::new(&topology);
            let rest = |slot: u32| topology.rest_positions()[topology.particle(slot as usize)];
            let clusters = Clusters::new(&faces, topology.layout().slots(), rest, most);
            let mut slots = clusters.all.concat();
            slots.sort_unstable();
            assert!(slots.iter().copied().eq(topology.layout().slots().map(|slot| slot as u32)));
            assert!(clusters.all.len() * most * 3 < side * side * 4, "{side}");
            // Four by four particles, were there no edges; a strip of sixteen would be as long as five times as many.
            let spacing = 1.0 / (side - 1) as f32;
            for cluster in &clusters.all {
                let far = |&slot: &u32| rest(slot).distance(rest(cluster[0]));
                assert!(cluster.iter().map(far).fold(0.0, f32::max) < 9.0 * spacing, "{side}");
            }
        }
    }
}
