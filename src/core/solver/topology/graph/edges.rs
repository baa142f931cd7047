//! The edges of a mesh with the triangles beside them, and which of them are diagonals of cells.

use bevy_math::{DVec3, Vec3};

use crate::solver::topology::buckets::Buckets;
use crate::solver::topology::graph::validate::area;

/// Largest cosine of a corner that counts as a right angle: 6 degrees off.
const RIGHT: f64 = 0.1;

/// A triangle beside an edge: the edge's higher end, the triangle, and its corner opposite of the edge.
type Side = (u32, u32, u32);

/// A triangle mesh by slots.
pub(crate) struct Mesh<'a> {
    /// Rest positions by slot \[m\].
    pub positions: &'a [Vec3],
    /// Corners by slot.
    pub triangles: &'a [[u32; 3]],
}

/// An edge and what is beside it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Edge {
    /// Slots of both ends, the lower first.
    pub ends: [u32; 2],
    /// Rest length \[m\].
    pub length: f64,
    /// Area of the triangles beside it \[m2\].
    pub area: f64,
    /// Number of triangles beside it.
    pub sides: u32,
    /// The triangles beside it, and their corners opposite of it; of two where there are more.
    pub triangles: [u32; 2],
    pub opposite: [u32; 2],
    /// Whether it is the diagonal of a rectangular cell, as is the line between its two opposite
    /// corners: both are shear springs.
    pub diagonal: bool,
}

impl Mesh<'_> {
    /// Where a particle is at rest \[m\].
    pub fn at(&self, slot: u32) -> DVec3 {
        self.positions[slot as usize].as_dvec3()
    }

    /// Area of a triangle \[m2\].
    pub fn area(&self, triangle: usize) -> f64 {
        let [a, b, c] = self.triangles[triangle];
        area(self.at(a), self.at(b), self.at(c))
    }

    /// Distance of two particles at rest \[m\].
    pub fn distance(&self, a: u32, b: u32) -> f64 {
        self.at(a).distance(self.at(b))
    }

    /// All edges, in the order of their ends.
    pub fn edges(&self) -> Vec<Edge> {
        // By the lower end.
        let mut sides: Vec<(u32, Side)> = Vec::with_capacity(3 * self.triangles.len());
        for (triangle, &[a, b, c]) in self.triangles.iter().enumerate() {
            for (a, b, opposite) in [(a, b, c), (b, c, a), (c, a, b)] {
                sides.push((a.min(b), (a.max(b), triangle as u32, opposite)));
            }
        }
        let sides = Buckets::new(self.positions.len(), &sides).sorted_by_key(|side| *side);
        let of_edges = (0..).zip(sides.each()).flat_map(|(low, sides)| {
            sides.chunk_by(|a, b| a.0 == b.0).map(move |beside| (low, beside))
        });
        of_edges.map(|(low, beside)| self.edge(low, beside)).collect()
    }

    fn edge(&self, low: u32, beside: &[Side]) -> Edge {
        let (high, triangle, opposite) = beside[0];
        let ends = [low, high];
        let (_, other_triangle, other) = *beside.get(1).unwrap_or(&beside[0]);
        let mut edge = Edge {
            ends,
            length: self.distance(ends[0], ends[1]),
            area: beside.iter().map(|&(_, t, _)| self.area(t as usize)).sum(),
            sides: beside.len() as u32,
            triangles: [triangle, other_triangle],
            opposite: [opposite, other],
            diagonal: false,
        };
        edge.diagonal = self.is_diagonal(&edge);
        edge
    }

    /// Whether the two triangles beside an edge make a rectangle: all four of its corners are right.
    /// The edge is then the longest of both.
    fn is_diagonal(&self, edge: &Edge) -> bool {
        if edge.sides != 2 {
            return false;
        }
        let ([a, b], [p, q]) = (edge.ends, edge.opposite);
        let right = |cosine: f64| cosine.abs() < RIGHT;
        // Along the cloth, not through space: a cell may be folded along its diagonal.
        let corner = |end: u32, other: u32| {
            let (c1, s1) = self.corner(end, p, other);
            let (c2, s2) = self.corner(end, other, q);
            c1 * c2 - s1 * s2
        };
        right(self.corner(p, a, b).0)
            && right(self.corner(q, a, b).0)
            && right(corner(a, b))
            && right(corner(b, a))
    }

    /// Cosine and sine of the angle at `corner` between the ways to `a` and `b`.
    pub fn corner(&self, corner: u32, a: u32, b: u32) -> (f64, f64) {
        let (u, v) = (self.at(a) - self.at(corner), self.at(b) - self.at(corner));
        let lengths = u.length() * v.length();
        (u.dot(v) / lengths, u.cross(v).length() / lengths)
    }
}
