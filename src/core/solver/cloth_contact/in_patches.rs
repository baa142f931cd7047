//! Pairs of particles of a cloth, found patch by patch: each particle of a patch with all those of another, side by side.

use bevy_math::Vec3;

use crate::solver::cloth_contact::find::{Group, NEIGHBOURS, Pair};
use crate::solver::cloth_contact::grid::NOWHERE;
use crate::solver::cloth_contact::patch::PARTICLES;
use crate::solver::cloth_contact::patches::{Division, Patches};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::soa::{Array, Soa};

/// Where there is no particle.
const NONE: u32 = u32::MAX;

/// The particles of a cloth, patch by patch: the particles of a patch are the lanes of a block.
#[derive(Clone, Debug)]
pub(super) struct InPatches {
    patches: Patches,
    /// Slots by place, or [`NONE`].
    slots: Vec<u32>,
    /// Rest positions and radii by place \[m\].
    rest: Soa,
    radius: Array,
    /// Positions by place \[m\].
    x: Soa,
}

impl InPatches {
    /// For particles of these rest positions and radii by slot, divided into patches.
    pub fn new(division: Division, rest_of: &Soa, radius_of: &[f32]) -> Self {
        let count = division.count() * PARTICLES;
        let mut slots = vec![NONE; count];
        let [mut rest, mut x] = [(); 2].map(|()| Soa::zeros(count));
        let mut radius = Array::zeros(count);
        for (place, slot) in division.slots().enumerate() {
            let Some(slot) = slot else {
                rest.set(place, Vec3::splat(NOWHERE));
                x.set(place, Vec3::splat(NOWHERE));
                continue;
            };
            slots[place] = slot as u32;
            rest.set(place, rest_of.get(slot));
            radius[place] = radius_of[slot];
        }
        Self { patches: Patches::new(division), slots, rest, radius, x }
    }

    /// Finds the pairs of particles at these places that may touch before the cloth has moved by the margin, where two may touch that are
    /// `reach` apart now.
    pub fn find(&mut self, isa: Isa, at: &Soa, margin: f32, reach: f32, pairs: &mut Vec<Pair>) {
        self.patches.look(isa, at, &mut self.x);
        self.patches.find_meetings(isa, reach);
        isa.run(Meet { particles: self, margin, pairs });
        if let Division::Mesh(mesh) = &self.patches.division {
            mesh.find_beside(at, margin, pairs);
        }
    }
}

/// Compares the particles of patches that may meet.
struct Meet<'a> {
    particles: &'a InPatches,
    margin: f32,
    pairs: &'a mut Vec<Pair>,
}

impl Kernel for Meet<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { particles, margin, pairs } = self;
        let InPatches { patches, slots, rest, radius, x } = particles;
        for &[a, b] in patches.meetings() {
            let [first, other] = [a, b].map(|patch| patch as usize * PARTICLES);
            let now = Group::<PARTICLES>::load(x, radius, other);
            let at_rest = Group::<PARTICLES>::load(rest, radius, other);
            for i in (0..PARTICLES).filter(|&i| slots[first + i] != NONE) {
                let (p, r) = (x.get(first + i), radius[first + i]);
                let mut lanes = now.near(p, r, 1.0, margin);
                if a == b {
                    lanes &= !((2 << i) - 1);
                }
                if lanes == 0 {
                    continue;
                }
                lanes &= !at_rest.near(rest.get(first + i), r, NEIGHBOURS, 0.0);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let slots = [slots[first + i], slots[other + lane]];
                    pairs.push(now.pair(lane, p, r, slots));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_math::{Quat, Vec2};

    use super::*;
    use crate::solver::cloth_contact::balls::Balls;
    use crate::solver::cloth_contact::clusters::Clusters;
    use crate::solver::cloth_contact::faces::FacesAt;
    use crate::solver::cloth_contact::find::reach;
    use crate::solver::cloth_contact::kin::{AtRest, find_beside};
    use crate::solver::cloth_contact::mesh_patches::MeshPatches;
    use crate::solver::cloth_contact::sheet_patches::SheetPatches;
    use crate::solver::settings::MassLumping;
    use crate::solver::topology::Topology;
    use crate::solver::topology::graph::Graph;
    use crate::solver::topology::lattice::Lattice;

    const SIDE: usize = 24;

    /// A cloth as its contact with itself has it.
    struct Cloth {
        topology: Topology,
        rest: Soa,
        balls: Balls,
        margin: f32,
    }

    impl Cloth {
        fn new(rest: &[Vec3], triangles: &[[u32; 3]]) -> Self {
            let mesh = Graph::new(rest, triangles, MassLumping::Lumped).unwrap();
            Self::of(Arc::new(mesh).into())
        }

        fn of(topology: Topology) -> Self {
            let balls = Balls::automatic(&topology);
            let mut at = Soa::zeros(topology.layout().len());
            for (particle, &rest) in topology.rest_positions().iter().enumerate() {
                at.set(topology.slot(particle), rest);
            }
            let margin = 0.7 * balls.widest();
            Self { topology, rest: at, balls, margin }
        }

        /// The pairs of particles that are found where each is put somewhere, lower slots first, in order.
        fn pairs(&self, put: impl Fn(Vec3) -> Vec3) -> Vec<[u32; 2]> {
            let (isa, widest) = (Isa::detect(), self.balls.widest());
            let (faces, slots) = (FacesAt::new(&self.topology), || self.topology.layout().slots());
            let at_rest =
                AtRest { faces: &faces, at: &self.rest, radius: &self.balls.radius, widest };
            let rest = |slot: u32| self.rest.get(slot as usize);
            let division = match self.topology.as_lattice() {
                Some(lattice) => Division::Sheet(SheetPatches::new(lattice.layout)),
                None => {
                    let clusters = Clusters::new(&faces, slots(), rest, PARTICLES);
                    let beside = find_beside(isa, &at_rest, self.margin, slots());
                    Division::Mesh(MeshPatches::new(&faces, &clusters, beside))
                }
            };
            let mut particles = InPatches::new(division, &self.rest, &self.balls.radius);
            let mut at = Soa::zeros(self.topology.layout().len());
            slots().for_each(|slot| at.set(slot, put(self.rest.get(slot))));
            let mut pairs = Vec::new();
            particles.find(isa, &at, self.margin, widest + self.margin, &mut pairs);
            let ordered =
                |pair: &Pair| [pair.slots[0].min(pair.slots[1]), pair.slots[0].max(pair.slots[1])];
            let mut pairs: Vec<_> = pairs.iter().map(ordered).collect();
            pairs.sort_unstable();
            pairs
        }

        /// The pairs of particles that must be found there: all that may touch, but those that are neighbours at rest or corners of
        /// two triangles that share an edge.
        fn needed(&self, put: impl Fn(Vec3) -> Vec3) -> Vec<[u32; 2]> {
            let faces = FacesAt::new(&self.topology);
            let slots: Vec<_> = self.topology.layout().slots().collect();
            let mut pairs = Vec::new();
            for (i, &a) in slots.iter().enumerate() {
                for &b in &slots[i + 1..] {
                    let [p, q] = [a, b].map(|slot| self.rest.get(slot));
                    let pair = [a as u32, b as u32];
                    let reach = reach(self.balls.radius[a], self.balls.radius[b]);
                    if put(p).distance(put(q)) < reach + self.margin - 1e-5
                        && p.distance(q) > NEIGHBOURS * reach
                        && !faces.share_an_edge(pair)
                        && !faces.face_each_other(pair)
                    {
                        pairs.push(pair);
                    }
                }
            }
            pairs
        }
    }

    /// A sheet whose inner particles are a little beside their places.
    fn uneven() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let sheet = Lattice::sheet(Vec2::ONE, SIDE, SIDE, MassLumping::Lumped).unwrap();
        let mut state = 7_u32;
        let mut roll = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let mut moved = |&p: &Vec3| p + Vec3::new(roll(), 0.0, roll()) * 0.5 / SIDE as f32;
        let rest = sheet.rest_positions().iter().map(&mut moved).collect();
        let cells = (0..SIDE - 1).flat_map(|r| (0..SIDE - 1).map(move |c| r * SIDE + c));
        let halves = cells.flat_map(|a| {
            let [b, c, d] = [a + 1, a + SIDE, a + SIDE + 1];
            if a % 3 == 0 { [[a, c, b], [b, c, d]] } else { [[a, c, d], [a, d, b]] }
        });
        (rest, halves.map(|corners| corners.map(|corner| corner as u32)).collect())
    }

    /// Around a fold along z, of a radius.
    fn folded(p: Vec3, radius: f32) -> Vec3 {
        let (angle, turn) = (p.x / radius, core::f32::consts::FRAC_PI_2);
        let (sine, cosine) = angle.clamp(-turn, turn).sin_cos();
        let beyond = (angle.abs() - turn).max(0.0) * radius;
        Vec3::new(radius * cosine - beyond, radius * sine, p.z)
    }

    #[test]
    fn a_flat_mesh_has_pairs_only_where_triangles_are_small() {
        let (rest, triangles) = uneven();
        let mesh = Cloth::new(&rest, &triangles);
        let bowed = |p: Vec3| folded(p, 0.5);
        for pair in mesh.pairs(bowed) {
            let [p, q] = pair.map(|slot| mesh.rest.get(slot as usize));
            assert!(p.distance(q) < 2.2 * mesh.balls.widest(), "{pair:?}");
        }
        let (pairs, needed) = (mesh.pairs(bowed), mesh.needed(bowed));
        assert!(!needed.is_empty());
        for pair in &needed {
            assert!(pairs.binary_search(pair).is_ok(), "{pair:?}");
        }
    }

    #[test]
    fn all_pairs_of_a_folded_mesh_are_found_once() {
        let (rest, triangles) = uneven();
        let mesh = Cloth::new(&rest, &triangles);
        for radius in [0.015, 0.02, 0.03] {
            let fold = |p: Vec3| folded(p, radius);
            let (pairs, needed) = (mesh.pairs(fold), mesh.needed(fold));
            assert!(needed.len() > SIDE * SIDE / 2, "{radius}: {}", needed.len());
            for pair in &needed {
                assert!(pairs.binary_search(pair).is_ok(), "{radius}: {pair:?}");
            }
            assert!(pairs.is_sorted_by(|a, b| a < b), "{radius}: one is there twice");
        }
    }

    #[test]
    fn all_pairs_of_a_folded_sheet_are_found_once() {
        let (rows, columns) = (21, 37);
        let size = Vec2::new(columns as f32 - 1.0, rows as f32 - 1.0) / SIDE as f32;
        let sheet = Lattice::sheet(size, rows, columns, MassLumping::Lumped).unwrap();
        let sheet = Cloth::of(Arc::new(sheet).into());
        for angle in [0.0, 0.5, 1.1, 1.571] {
            let turn = Quat::from_rotation_y(angle);
            for radius in [0.012, 0.02, 0.03] {
                let fold = |p: Vec3| folded(turn * p, radius);
                let (pairs, needed) = (sheet.pairs(fold), sheet.needed(fold));
                assert!(needed.len() > rows * columns / 4, "{angle}, {radius}: {}", needed.len());
                for pair in &needed {
                    assert!(pairs.binary_search(pair).is_ok(), "{angle}, {radius}: {pair:?}");
                }
                assert!(pairs.is_sorted_by(|a, b| a < b), "{angle}, {radius}: one is there twice");
            }
            // So gently that no patch can meet another.
            assert!(sheet.pairs(|p| folded(turn * p, 0.5)).is_empty());
        }
    }

    #[test]
    fn what_is_sewn_on_meets_what_it_lies_on() {
        // A second sheet, joined to the first one along its middle line, which lies on one half of it.
        let (mut rest, mut triangles) = uneven();
        let middle = SIDE / 2;
        let mut own = vec![0; rest.len()];
        for (particle, own) in own.iter_mut().enumerate() {
            *own = particle as u32;
            if particle % SIDE > middle {
                *own = rest.len() as u32;
                rest.push(rest[particle] + Vec3::Y * 0.3);
            }
        }
        let right = |corners: &[u32; 3]| corners.iter().all(|&it| it as usize % SIDE >= middle);
        let sewn: Vec<_> = triangles.iter().filter(|corners| right(corners)).copied().collect();
        triangles.extend(sewn.iter().map(|corners| corners.map(|corner| own[corner as usize])));
        let mesh = Cloth::new(&rest, &triangles);
        let laid = |p: Vec3| if p.y > 0.1 { p.with_y(0.02) } else { p };
        let pairs = mesh.pairs(laid);
        let needed = mesh.needed(laid);
        assert!(needed.len() > SIDE * SIDE / 3);
        for pair in &needed {
            assert!(pairs.binary_search(pair).is_ok(), "{pair:?}");
        }
    }

    #[test]
    fn a_fold_between_halves_that_go_round_otherwise_is_found() {
        let (rest, mut triangles) = uneven();
        for corners in &mut triangles {
            // Of the columns beyond the middle.
            if corners.iter().all(|&corner| corner as usize % SIDE >= SIDE / 2) {
                corners.swap(1, 2);
            }
        }
        let mesh = Cloth::new(&rest, &triangles);
        let fold = |p: Vec3| folded(p - Vec3::X * 0.5 / SIDE as f32, 0.012);
        let (pairs, needed) = (mesh.pairs(fold), mesh.needed(fold));
        assert!(needed.len() > SIDE * SIDE / 2);
        for pair in &needed {
            assert!(pairs.binary_search(pair).is_ok(), "{pair:?}");
        }
    }

    #[test]
    fn what_is_tacked_on_by_a_vertex_or_an_edge_meets_what_it_lies_on() {
        for shared in [1, 2] {
            let (mut rest, mut triangles) = uneven();
            let (all, middle) = (triangles.clone(), SIDE * SIDE / 2 + SIDE / 2);
            let mut own: Vec<_> = (0..rest.len() as u32).collect();
            let tab = |corner: &u32| {
                let (row, column) = (*corner as usize / SIDE, *corner as usize % SIDE);
                (SIDE / 2..SIDE / 2 + 6).contains(&row)
                    && (SIDE / 2..SIDE / 2 + 6).contains(&column)
            };
            let sewn: Vec<_> = all.iter().filter(|corners| corners.iter().all(tab)).collect();
            for &corner in sewn.iter().copied().flatten() {
                let corner = corner as usize;
                let is_shared = (middle..middle + shared).contains(&corner);
                if own[corner] == corner as u32 && !is_shared {
                    own[corner] = rest.len() as u32;
                    rest.push(rest[corner] + Vec3::Y * 0.3);
                }
            }
            triangles.extend(sewn.iter().map(|corners| corners.map(|it| own[it as usize])));
            let mesh = Cloth::new(&rest, &triangles);
            let laid = |p: Vec3| if p.y > 0.1 { p.with_y(0.02) } else { p };
            let (pairs, needed) = (mesh.pairs(laid), mesh.needed(laid));
            assert!(needed.len() > 36, "{}", needed.len());
            for pair in &needed {
                assert!(pairs.binary_search(pair).is_ok(), "{shared}: {pair:?}");
            }
        }
    }
}
