//! Places on edges and faces.

use crate::solver::contact::edges::WarmStart;

/// A place on an edge or a face. Of an edge, the last corner is the first again and has no part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Slots of the corners; the first two ascend.
    pub corners: [u32; 3],
    /// Barycentric weights of the corners.
    pub parts: [f32; 3],
    /// The edge, where it is one.
    pub edge: Option<u32>,
}

impl Place {
    /// The place at a part of the way along an edge.
    #[inline(always)]
    pub fn on_edge(edge: u32, [a, b]: [usize; 2], at: f32) -> Self {
        let corners = [a, b, a].map(|slot| slot as u32);
        Self { corners, parts: [1.0 - at, at, 0.0], edge: Some(edge) }
    }

    /// Where something was expected.
    pub fn of(warm: &WarmStart) -> Self {
        Self { corners: warm.corners, parts: warm.parts, edge: None }
    }

    /// The ends of an edge, or the corners of a face.
    pub fn corners(&self) -> &[u32] {
        &self.corners[..self.count()]
    }

    #[inline(always)]
    pub fn is_on_edge(&self) -> bool {
        self.corners[2] == self.corners[0]
    }

    #[inline(always)]
    fn count(&self) -> usize {
        if self.is_on_edge() { 2 } else { 3 }
    }
}
