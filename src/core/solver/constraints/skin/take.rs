//! The skin's motion in a tick, as it comes with the input: looked through, and laid out by slot.

use bevy_math::Vec3;

use crate::solver::constraints::skin::{Skin, SkinMotion};
use crate::solver::settings::FARTHEST;
use crate::solver::simd::block::Block3;
use crate::solver::simd::isa::{Isa, Kernel, TransposingKernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::transpose::{Four, Transpose};
use crate::solver::topology::Topology;

/// Findings of a first look at motions.
#[derive(Debug)]
pub(crate) struct Looked {
    /// All places and normals are as near as places have to be.
    pub near: bool,
    /// All normals are about of length one.
    pub normal: bool,
}

/// Looks motions through.
pub(crate) fn look_through(isa: Isa, motions: &[SkinMotion]) -> Looked {
    isa.run(LookThrough(motions))
}

struct LookThrough<'a>(&'a [SkinMotion]);

impl Kernel for LookThrough<'_> {
    type Output = Looked;

    /// Without a way out of the loop, and by the numbers' bits, for there are thousands: what is no number is above all that are.
    #[inline(always)]
    fn run(self) -> Looked {
        let mut far = [false; 12];
        let mut normal = true;
        for SkinMotion { place: [a, b], normal: [n, m] } in self.0 {
            let all = [a.x, a.y, a.z, b.x, b.y, b.z, n.x, n.y, n.z, m.x, m.y, m.z];
            for i in 0..12 {
                far[i] |= all[i].abs().to_bits() > FARTHEST.to_bits();
            }
            normal &= is_about_unit(n.dot(*n)) & is_about_unit(m.dot(*m));
        }
        Looked { near: far == [false; 12], normal }
    }
}

impl Skin {
    /// Begins a tick, with motions that have been checked, relative to an origin.
    pub fn begin_tick(
        &mut self,
        isa: Isa,
        topology: &Topology,
        motions: &[SkinMotion],
        origin: Vec3,
    ) {
        let layout = topology.layout();
        match topology {
            Topology::Lattice(_) => {
                let particle = |row, column| row * layout.columns + column;
                isa.run_transposing(Take { skin: self, layout, motions, origin, particle });
            }
            Topology::Graph(graph) => {
                let particle_at = &graph.particle_at[..];
                let particle =
                    |row: usize, column| particle_at[row * layout.columns + column] as usize;
                isa.run_transposing(Take { skin: self, layout, motions, origin, particle });
            }
        }
    }

    /// The first particle that has a backstop and whose skin has no normal.
    pub fn without_normal(&self, motions: &[SkinMotion]) -> Option<usize> {
        if !self.has_backstops {
            return None;
        }
        let lacks = |motion: &SkinMotion| motion.normal.iter().any(|n| n.try_normalize().is_none());
        let mut all = self.limits.iter().zip(motions);
        all.position(|(limit, motion)| limit.backstop.is_some() && lacks(motion))
    }
}

/// Lays motions out, those of `particle` of each row and column.
struct Take<'a, P> {
    skin: &'a mut Skin,
    layout: Layout,
    motions: &'a [SkinMotion],
    origin: Vec3,
    particle: P,
}

impl<P: Fn(usize, usize) -> usize> TransposingKernel for Take<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run(self, t: impl Transpose) {
        let Self { skin, layout, motions, origin, particle } = self;
        for row in 0..layout.rows {
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                let inside = layout.inside(row, column);
                if inside == 0 {
                    return;
                }
                // What is beyond the row's end is padding, which nothing moves. Not by closures, which would be calls.
                let mut at = [&motions[0]; LANES];
                for (i, motion) in at.iter_mut().enumerate() {
                    *motion = &motions[particle(row, column + i.min(inside - 1))];
                }
                let [x, y, z, to_x] = t.apart(
                    #[inline(always)]
                    |i| {
                        let [from, to] = at[i].place;
                        Four([from.x, from.y, from.z, to.x])
                    },
                );
                let [to_y, to_z, n_x, n_y] = t.apart(
                    #[inline(always)]
                    |i| {
                        let (to, n) = (at[i].place[1], at[i].normal[0]);
                        Four([to.y, to.z, n.x, n.y])
                    },
                );
                let places = [Block3 { x, y, z }, Block3 { x: to_x, y: to_y, z: to_z }];
                let (mut start, mut way) = (Block3::ZERO, Block3::ZERO);
                for i in 0..LANES {
                    let (from, to) = (places[0].at(i) - origin, places[1].at(i) - origin);
                    start.set(i, from);
                    way.set(i, to - from);
                }
                start.store(&mut skin.place, slot);
                way.store(&mut skin.way, slot);
                if !skin.has_backstops {
                    continue;
                }
                let [n_z, x, y, z] = t.apart(
                    #[inline(always)]
                    |i| {
                        let [n, to] = at[i].normal;
                        Four([n.z, to.x, to.y, to.z])
                    },
                );
                let normals = [Block3 { x: n_x, y: n_y, z: n_z }, Block3 { x, y, z }];
                let (mut start, mut turn) = (Block3::ZERO, Block3::ZERO);
                for i in 0..LANES {
                    let (from, to) = (about_unit(normals[0].at(i)), about_unit(normals[1].at(i)));
                    start.set(i, from);
                    turn.set(i, to - from);
                }
                start.store(&mut skin.normal, slot);
                turn.store(&mut skin.turn, slot);
            }
        }
    }
}

/// Whether a normal of this squared length is as good as of length one: roots are dear where there are thousands.
#[inline(always)]
fn is_about_unit(square: f32) -> bool {
    (square > 0.999) & (square < 1.001)
}

/// A normal of about length one, or none.
#[inline(always)]
fn about_unit(normal: Vec3) -> Vec3 {
    let square = normal.dot(normal);
    let part = 1.0 / square.sqrt();
    let usable = if part < f32::INFINITY { part } else { 0.0 };
    normal * if is_about_unit(square) { 1.0 } else { usable }
}
