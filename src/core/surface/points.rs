//! The particles as points of a frame.

use crate::solver::ClothSolver;
use bevy_math::{Mat3, Vec3, Vec3A};

/// How a cloth's own coordinates become those of the frame that it is drawn in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// Part of the last tick: 0 is its start, 1 its end.
    pub blend: f32,
    /// Turns, and scales, what is relative to [`ClothSolver::origin`].
    pub turn: Mat3,
    /// Added to it \[m\].
    pub shift: Vec3,
}

impl Placing {
    /// Writes the point of every particle.
    ///
    /// # Panics
    /// If `points` are fewer than the particles.
    pub fn write(&self, solver: &ClothSolver, points: &mut [Vec3]) {
        let &Self { blend, turn, shift } = self;
        solver.write_places(blend, &turn, shift, points);
    }
}

/// The least and the greatest coordinates of all points; infinite, and the wrong way round, where there is none.
pub fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    // Four numbers at once.
    let (mut least, mut greatest) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    for point in points {
        let point = Vec3A::from(*point);
        (least, greatest) = (least.min(point), greatest.max(point));
    }
    (least.into(), greatest.into())
}

/// Whether any point is further than this \[m\] from where it was; so is what is NaN. Points that only one of the
/// two has are not looked at.
pub fn has_moved(points: &[Vec3], before: &[Vec3], distance: f32) -> bool {
    let square = distance * distance;
    !points.iter().zip(before).all(|(a, b)| a.distance_squared(*b) <= square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::{Graph, Lattice, MassLumping, Material, Settings, StepInput};
    use bevy_math::Vec2;
    use std::sync::Arc;

    #[test]
    fn a_cloth_is_placed_between_two_ticks() {
        let lattice = Arc::new(Lattice::sheet(Vec2::ONE, 3, 20, MassLumping::Lumped).unwrap());
        let start: Vec<_> = lattice.rest_positions().iter().map(|&p| p + Vec3::Y * 2.0).collect();
        let (material, settings) = (Material::USUAL, Settings::default());
        let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
        let gravity = Vec3::NEG_Y * 8.0;
        solver.tick(&StepInput { dt: 0.125, gravity, ..StepInput::default() }).unwrap();
        let fallen = solver.position(0).y - start[0].y;
        assert!(fallen < -0.05);
        // A quarter turn about y, at twice the size, from the solver's own origin.
        let turn = Mat3::from_cols(Vec3::NEG_Z, Vec3::Y, Vec3::X) * 2.0;
        let mut points = vec![Vec3::NAN; start.len()];
        for blend in [0.0, 0.25, 1.0] {
            Placing { blend, turn, shift: Vec3::X }.write(&solver, &mut points);
            for (point, start) in points.iter().zip(&start) {
                let p = *start + Vec3::Y * fallen * blend - solver.origin();
                let expected = Vec3::new(p.z, p.y, -p.x) * 2.0 + Vec3::X;
                assert!(point.distance(expected) < 1e-5, "{blend}: {point} not {expected}");
            }
        }
    }

    #[test]
    fn the_particles_of_a_mesh_are_placed_as_they_are_counted() {
        // As many as a page holds: the one after it is empty.
        let side = 16_u32;
        let at = |i: u32| Vec3::new((i % side) as f32, 0.1 * (i % 7) as f32, (i / side) as f32);
        let rest: Vec<_> = (0..side * side).map(at).collect();
        let cells = (0..side - 1).flat_map(|row| (0..side - 1).map(move |c| row * side + c));
        let halves = |a| [[a, a + side, a + 1], [a + 1, a + side, a + side + 1]];
        let triangles: Vec<_> = cells.flat_map(halves).collect();
        let graph = Arc::new(Graph::new(&rest, &triangles, MassLumping::Lumped).unwrap());
        let solver = ClothSolver::new(graph, &rest, Material::USUAL, Settings::default()).unwrap();
        let placing = Placing { blend: 1.0, turn: Mat3::IDENTITY, shift: solver.origin() };
        let mut points = vec![Vec3::NAN; rest.len()];
        placing.write(&solver, &mut points);
        assert_eq!(points, rest);
    }

    #[test]
    fn bounds_hold_all_points_and_no_more() {
        let points =
            [Vec3::new(1.0, -2.0, 3.0), Vec3::new(-1.0, 5.0, 0.0), Vec3::new(0.0, 0.0, 4.0)];
        assert_eq!(bounds(&points), (Vec3::new(-1.0, -2.0, 0.0), Vec3::new(1.0, 5.0, 4.0)));
        assert_eq!(bounds(&[]), (Vec3::INFINITY, Vec3::NEG_INFINITY));
    }

    #[test]
    fn what_moves_further_than_is_let_has_moved() {
        let before = [Vec3::ZERO, Vec3::X];
        let moved = |way: f32| has_moved(&[Vec3::ZERO, Vec3::X + Vec3::Z * way], &before, 0.1);
        assert!(!moved(0.0) && !moved(0.09) && moved(0.11) && moved(f32::NAN));
    }
}
