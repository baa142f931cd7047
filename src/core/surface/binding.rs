//! A fine surface that a coarse one carries: each of its points is bound to a triangle of the coarse one at rest, and goes where
//! that goes.
//!
//! Between three points the surface is curved by their normals, as in Boubekeur and Alexa 2008, *Phong Tessellation*,
//! section 3: flat facets would be seen. What is left between that and the fine surface at rest turns with the triangle, so that
//! at rest the fine surface is as it was made.

use super::nearest::{Found, NearestTriangles};
use bevy_math::{Mat3, Vec3};

/// How much the surface between three points is curved by their normals: 0 is flat. That of the paper, section 3.
const CURVATURE: f32 = 0.75;
/// What is left of a fine surface is left out below this part of its size.
const NEGLIGIBLE: f32 = 1e-6;

/// Shares above this are all, but for rounding.
const ALL: f32 = 0.9999;

/// A point of a fine surface on a triangle of a coarse one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond {
    /// The corners of the triangle: points of the coarse surface.
    pub corners: [u32; 3],
    /// Their weights \[1\], none of them negative, of which the sum is one.
    pub weights: [f32; 3],
}

/// What a fine point is off, in a frame of its triangle \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Offset {
    /// From the curved surface, in the frame of its normal.
    curved: Vec3,
    /// From the triangle itself, in the triangle's frame.
    flat: Vec3,
}

/// The points of a fine surface on the triangles of a coarse one.
#[derive(Debug)]
pub struct Binding {
    bonds: Box<[Bond]>,
    /// Empty where the fine surface is the curved one.
    offsets: Box<[Offset]>,
    /// Index of the point that is furthest from the coarse surface, and its distance \[m\].
    furthest: (usize, f32),
}

impl Bond {
    /// The corners that have any weight.
    pub fn supports(&self) -> impl Iterator<Item = u32> + '_ {
        self.corners.into_iter().zip(self.weights).filter(|it| it.1 > 0.0).map(|it| it.0)
    }

    /// How much of it hangs on corners that are held, from 0 to 1: level at both ends, so that what is drawn between what is held and
    /// what is free has no edge.
    pub fn held(&self, is_held: impl Fn(u32) -> bool) -> f32 {
        let corners = self.corners.into_iter().zip(self.weights);
        let share: f32 = corners.filter(|(corner, _)| is_held(*corner)).map(|it| it.1).sum();
        if share > ALL { 1.0 } else { share * share * (3.0 - 2.0 * share) }
    }

    /// The weighted mean of the corners' values.
    #[inline(always)]
    fn mean(&self, values: [Vec3; 3]) -> Vec3 {
        let [a, b, c] = self.weights;
        values[0] * a + values[1] * b + values[2] * c
    }

    #[inline(always)]
    fn of<'a, T>(&self, values: &'a [T]) -> [&'a T; 3] {
        self.corners.map(|corner| &values[corner as usize])
    }

    /// The place on the curved surface, and the normal there, of no certain length.
    #[inline(always)]
    fn curved(&self, points: &[Vec3], normals: &[[f32; 3]]) -> (Vec3, Vec3) {
        let points = self.of(points).map(|point| *point);
        let normals = self.of(normals).map(|normal| Vec3::from_array(*normal));
        let flat = self.mean(points);
        // From the flat place to its projection on the plane of each corner.
        let to_plane = |i: usize| normals[i] * normals[i].dot(points[i] - flat);
        let curved = flat + self.mean([to_plane(0), to_plane(1), to_plane(2)]) * CURVATURE;
        (curved, self.mean(normals))
    }

    /// A frame of the triangle with this normal. Its x axis is the first edge, as far as it is square to the normal.
    #[inline(always)]
    fn frame(&self, points: &[Vec3], normal: Vec3) -> Mat3 {
        let [a, b, c] = self.of(points);
        let z = normal.normalize_or(Vec3::Y);
        let along = |edge: Vec3| (edge - z * z.dot(edge)).try_normalize();
        let x = along(b - a).or_else(|| along(c - a)).unwrap_or_else(|| z.any_orthonormal_vector());
        Mat3::from_cols(x, z.cross(x), z)
    }

    #[inline(always)]
    fn flat_frame(&self, points: &[Vec3]) -> Mat3 {
        let [a, b, c] = self.of(points);
        self.frame(points, (b - a).cross(c - a))
    }
}

impl Binding {
    /// Binds each of `fine` points, whose normals are `fine_normals`, to the nearest of the `triangles` that faces as it does; of
    /// `points` at rest, whose normals are `normals`. A point without a normal is bound to the nearest of all, and so is one near which no
    /// triangle faces as it does.
    ///
    /// # Panics
    /// If there is no triangle, a corner is beyond the points, or there are fewer normals than points.
    pub fn new(
        fine: &[Vec3],
        fine_normals: &[[f32; 3]],
        triangles: &[[u32; 3]],
        points: &[Vec3],
        normals: &[[f32; 3]],
    ) -> Self {
        let search = NearestTriangles::new(points, triangles);
        let mut furthest = (0, 0.0_f32);
        let bond = |(index, (point, normal)): (usize, (&Vec3, &[f32; 3]))| {
            let Found { corners, weights, distance } =
                search.nearest(*point, Vec3::from_array(*normal));
            if distance > furthest.1 {
                furthest = (index, distance);
            }
            Bond { corners, weights }
        };
        let bonds: Box<[_]> = fine.iter().zip(fine_normals).enumerate().map(bond).collect();
        let offset = |(bond, fine): (&Bond, &Vec3)| {
            let (curved, normal) = bond.curved(points, normals);
            let flat = bond.mean(bond.of(points).map(|point| *point));
            Offset {
                curved: bond.frame(points, normal).transpose() * (fine - curved),
                flat: bond.flat_frame(points).transpose() * (fine - flat),
            }
        };
        let offsets: Box<[_]> = bonds.iter().zip(fine).map(offset).collect();
        let size = size_of(points);
        let is_off = |offset: &Offset| {
            let most = offset.curved.abs().max(offset.flat.abs());
            most.max_element() > NEGLIGIBLE * size
        };
        let is_needed = offsets.iter().any(is_off);
        Self { bonds, offsets: if is_needed { offsets } else { Box::default() }, furthest }
    }

    /// Where each point is bound.
    pub fn bonds(&self) -> &[Bond] {
        &self.bonds
    }

    /// Index of the point that is furthest from the coarse surface at rest, and its distance \[m\].
    pub fn furthest(&self) -> (usize, f32) {
        self.furthest
    }

    /// Writes where the fine points are, when the coarse ones are at `points`, have these normals, and both are `scale` times as large as
    /// they were bound.
    ///
    /// # Panics
    /// If there are fewer points or normals than corners, or fewer in `out` than fine points.
    pub fn write(&self, points: &[Vec3], normals: &[[f32; 3]], scale: f32, out: &mut [Vec3]) {
        if self.offsets.is_empty() {
            for (bond, out) in self.bonds.iter().zip(out) {
                *out = bond.curved(points, normals).0;
            }
        } else {
            for ((bond, offset), out) in self.bonds.iter().zip(&self.offsets).zip(out) {
                let (curved, normal) = bond.curved(points, normals);
                *out = curved + bond.frame(points, normal) * (offset.curved * scale);
            }
        }
    }

    /// Where a fine point is by the three corners of its triangle alone: as rigid as they are, whatever is around. `scale` as in
    /// [`Binding::write`].
    ///
    /// # Panics
    /// If there is no such point, or a corner is beyond `points`.
    pub fn rigid(&self, index: usize, points: &[Vec3], scale: f32) -> Vec3 {
        let bond = &self.bonds[index];
        let flat = bond.mean(bond.of(points).map(|point| *point));
        match self.offsets.get(index) {
            Some(offset) => flat + bond.flat_frame(points) * (offset.flat * scale),
            None => flat,
        }
    }

    /// The means of the corners' values for each fine point.
    ///
    /// # Panics
    /// If there are fewer values than corners.
    pub fn means<'a>(&'a self, values: &'a [Vec3]) -> impl Iterator<Item = Vec3> + 'a {
        self.bonds.iter().map(|bond| bond.mean(bond.of(values).map(|value| *value)))
    }
}

/// The longest side of the points' box \[m\].
fn size_of(points: &[Vec3]) -> f32 {
    let (min, max) = points
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| (min.min(*p), max.max(*p)));
    (max - min).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::GridNormals;
    use bevy_math::Quat;

    /// Rows and columns of points of a surface over the unit square, with their normals and their triangles.
    struct Patch {
        points: Vec<Vec3>,
        normals: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
    }

    impl Patch {
        fn new(side: u32, surface: impl Fn(f32, f32) -> Vec3) -> Self {
            let last = (side - 1) as f32;
            let place = |i: u32| surface((i % side) as f32 / last, (i / side) as f32 / last);
            let cells = (0..(side - 1) * (side - 1)).flat_map(|cell| {
                let a = cell / (side - 1) * side + cell % (side - 1);
                let (b, c, d) = (a + 1, a + side, a + side + 1);
                [[a, c, b], [b, c, d]]
            });
            let points: Vec<_> = (0..side * side).map(place).collect();
            Self { normals: normals(&points, side), points, triangles: cells.collect() }
        }

        fn carry(&self, fine: &Self) -> Binding {
            let Self { points, normals, triangles } = self;
            Binding::new(&fine.points, &fine.normals, triangles, points, normals)
        }
    }

    fn normals(points: &[Vec3], side: u32) -> Vec<[f32; 3]> {
        let mut normals = vec![[0.0; 3]; points.len()];
        GridNormals::new(side as usize).write(points, None, &mut normals);
        normals
    }

    fn largest(a: &[Vec3], b: &[Vec3]) -> f32 {
        a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    }

    fn bump(x: f32, z: f32) -> Vec3 {
        Vec3::new(x, 0.2 * (3.0 * x).sin() * (2.0 * z).cos(), z)
    }

    #[test]
    fn at_rest_the_fine_surface_is_as_it_was_made_and_turns_as_a_whole() {
        for surface in [bump, |x, z| Vec3::new(x, 0.0, z)] {
            let (coarse, fine) = (Patch::new(5, surface), Patch::new(16, surface));
            let binding = coarse.carry(&fine);
            let turn = Quat::from_euler(bevy_math::EulerRot::XYZ, 0.7, -1.9, 2.3);
            let moved = |points: &[Vec3]| -> Vec<_> {
                points.iter().map(|p| turn * *p * 1.7 + Vec3::new(3.0, -2.0, 5.0)).collect()
            };
            let points = moved(&coarse.points);
            let mut out = vec![Vec3::NAN; fine.points.len()];
            binding.write(&points, &normals(&points, 5), 1.7, &mut out);
            assert!(largest(&out, &moved(&fine.points)) < 5e-6);
            let rigid: Vec<_> = (0..out.len()).map(|i| binding.rigid(i, &points, 1.7)).collect();
            assert!(largest(&rigid, &moved(&fine.points)) < 5e-6);
        }
    }

    #[test]
    fn between_points_the_surface_is_curved() {
        // A flat sheet is bent to a quarter of a cylinder: on the flat triangles the fine points would be off by the sagitta.
        let flat = |x: f32, z: f32| Vec3::new(x, 0.0, z);
        let bent = |x: f32, z: f32| {
            let angle = core::f32::consts::FRAC_PI_2 * (x - 0.5);
            Vec3::new(angle.sin(), angle.cos(), z * core::f32::consts::FRAC_PI_2)
        };
        let (coarse, fine) = (Patch::new(7, flat), Patch::new(31, flat));
        let binding = coarse.carry(&fine);
        let (bent_coarse, bent_fine) = (Patch::new(7, bent), Patch::new(31, bent));
        let mut out = vec![Vec3::NAN; fine.points.len()];
        binding.write(&bent_coarse.points, &bent_coarse.normals, 1.0, &mut out);
        let radius = |p: &Vec3| (p.truncate().length() - 1.0).abs();
        let inner = |i: &usize| (6..25).contains(&(i % 31)) && (6..25).contains(&(i / 31));
        let curved = (0..out.len()).filter(inner).map(|i| radius(&out[i])).fold(0.0, f32::max);
        let on_facets = binding.means(&bent_coarse.points).map(|p| radius(&p));
        let facets = on_facets.fold(0.0, f32::max);
        let sagitta = 1.0 - (core::f32::consts::FRAC_PI_2 / 12.0).cos();
        assert!((facets / sagitta - 1.0).abs() < 0.05, "{facets} {sagitta}");
        // 3/4 of twice the sagitta: too far by half of it.
        assert!(curved < 0.55 * sagitta, "{curved} {sagitta}");
        assert!(largest(&out, &bent_fine.points) < 0.03);
    }

    #[test]
    fn layers_that_lie_close_are_told_apart_by_their_faces() {
        let sheet = |y: f32| move |x, z| Vec3::new(x, y, z);
        let (mut coarse, fine) = (Patch::new(4, sheet(0.0)), Patch::new(9, sheet(0.011)));
        // A second layer that faces down, nearer to the fine one than the first.
        let other = Patch::new(4, sheet(0.01));
        coarse.points.extend(&other.points);
        coarse.normals.extend(other.normals.iter().map(|[x, y, z]| [-x, -y, -z]));
        coarse.triangles.extend(other.triangles.iter().map(|[a, b, c]| [a + 16, c + 16, b + 16]));
        let binding = coarse.carry(&fine);
        assert!(binding.bonds().iter().all(|bond| bond.corners.iter().all(|it| *it < 16)));
        assert!((binding.furthest().1 - 0.011).abs() < 1e-6);
        // What has no normal goes to the nearest.
        let bare = vec![[0.0; 3]; fine.points.len()];
        let Patch { points, normals, triangles } = &coarse;
        let binding = Binding::new(&fine.points, &bare, triangles, points, normals);
        assert!(binding.bonds().iter().all(|bond| bond.corners.iter().all(|it| *it >= 16)));
    }

    #[test]
    fn what_collapses_stays_finite() {
        let (coarse, fine) = (Patch::new(4, bump), Patch::new(9, bump));
        let binding = coarse.carry(&fine);
        let points = [Vec3::ONE; 16];
        let mut out = vec![Vec3::NAN; 81];
        binding.write(&points, &normals(&points, 4), 1.0, &mut out);
        assert!(out.iter().all(|p| p.is_finite() && p.distance(Vec3::ONE) < 0.2));
        assert!((0..81).all(|i| binding.rigid(i, &points, 1.0).is_finite()));
    }
}
