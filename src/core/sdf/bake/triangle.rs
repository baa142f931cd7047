//! The nearest point of a triangle, and which of its features it lies on.

use bevy_math::DVec3;

/// Part of a triangle that holds the nearest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Feature {
    /// The inside of the face.
    Face,
    /// The edge from this corner to the next.
    Edge(usize),
    /// This corner.
    Vertex(usize),
}

/// A triangle with what the distance to it needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    corner: DVec3,
    ab: DVec3,
    ac: DVec3,
    pub(super) normal: DVec3,
    ab_ab: f64,
    ab_ac: f64,
    ac_ac: f64,
    /// Number of the triangle in the mesh.
    pub(super) source: u32,
}

impl Triangle {
    pub(super) fn new([a, b, c]: [DVec3; 3], normal: DVec3, source: u32) -> Self {
        let (ab, ac) = (b - a, c - a);
        Self {
            corner: a,
            ab,
            ac,
            normal,
            ab_ab: ab.dot(ab),
            ab_ac: ab.dot(ac),
            ac_ac: ac.dot(ac),
            source,
        }
    }

    pub(super) fn corners(&self) -> [DVec3; 3] {
        [self.corner, self.corner + self.ab, self.corner + self.ac]
    }

    /// Smallest box around it.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let [a, b, c] = self.corners();
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// Distance of `point` from the triangle's plane \[m\], negative behind.
    #[inline(always)]
    pub(super) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.corner)
    }

    /// Squared distance to the triangle \[m2\].
    #[inline(always)]
    pub(super) fn squared_distance(&self, point: DVec3) -> f64 {
        let (feature, offset) = self.nearest(point);
        match feature {
            // Along the normal nothing cancels.
            Feature::Face => {
                let height = self.height(point);
                height * height
            }
            _ => offset.length_squared(),
        }
    }

    /// The nearest feature, and the offset from the nearest point to `point` \[m\].
    ///
    /// Ericson's classification by Voronoi regions. All six of his dot products follow from two and from
    /// the lengths kept in the triangle.
    #[inline(always)]
    pub(super) fn nearest(&self, point: DVec3) -> (Feature, DVec3) {
        let to_point = point - self.corner;
        let along_ab = self.ab.dot(to_point);
        let along_ac = self.ac.dot(to_point);
        if along_ab <= 0.0 && along_ac <= 0.0 {
            return (Feature::Vertex(0), to_point);
        }

        let b_ab = along_ab - self.ab_ab;
        let b_ac = along_ac - self.ab_ac;
        if b_ab >= 0.0 && b_ac <= b_ab {
            return (Feature::Vertex(1), to_point - self.ab);
        }

        let beside_ab = along_ab * b_ac - b_ab * along_ac;
        if beside_ab <= 0.0 && along_ab >= 0.0 && b_ab <= 0.0 {
            return (Feature::Edge(0), to_point - self.ab * (along_ab / self.ab_ab));
        }

        let c_ab = along_ab - self.ab_ac;
        let c_ac = along_ac - self.ac_ac;
        if c_ac >= 0.0 && c_ab <= c_ac {
            return (Feature::Vertex(2), to_point - self.ac);
        }

        let beside_ac = c_ab * along_ac - along_ab * c_ac;
        if beside_ac <= 0.0 && along_ac >= 0.0 && c_ac <= 0.0 {
            return (Feature::Edge(2), to_point - self.ac * (along_ac / self.ac_ac));
        }

        let beside_bc = b_ab * c_ac - c_ab * b_ac;
        let from_b = b_ac - b_ab;
        let from_c = c_ab - c_ac;
        if beside_bc <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
            let share = from_b / (from_b + from_c);
            return (Feature::Edge(1), to_point - self.ab - (self.ac - self.ab) * share);
        }

        (Feature::Face, self.normal * self.normal.dot(to_point))
    }
}
