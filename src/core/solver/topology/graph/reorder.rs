//! The order of the particles in memory: neighbours near each other, so that what a particle gathers
//! is in the nearest cache (Cuthill and `McKee` 1969: breadth first, neighbours of few edges before
//! those of many).

use crate::solver::topology::buckets::Buckets;

/// The slot of each particle.
pub(crate) fn slots_of(particles: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let both = |&[a, b, c]: &[u32; 3]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)];
    let pairs: Vec<_> = triangles.iter().flat_map(both).collect();
    let near = Buckets::neighbours(particles, &pairs);
    let mut by_degree: Vec<u32> = (0..particles as u32).collect();
    by_degree.sort_by_key(|&particle| near.of(particle).len());
    let mut slot_of = vec![u32::MAX; particles];
    let mut order: Vec<u32> = Vec::with_capacity(particles);
    let mut place = |particle: u32, order: &mut Vec<u32>| {
        let slot = &mut slot_of[particle as usize];
        if *slot == u32::MAX {
            *slot = order.len() as u32;
            order.push(particle);
        }
    };
    let mut next: Vec<u32> = Vec::new();
    let mut at = 0;
    for seed in by_degree {
        place(seed, &mut order);
        while at < order.len() {
            next.clear();
            next.extend_from_slice(near.of(order[at]));
            next.sort_by_key(|&particle| near.of(particle).len());
            for &particle in &next {
                place(particle, &mut order);
            }
            at += 1;
        }
    }
    slot_of
}
