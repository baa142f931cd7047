//! A hinge of a mesh.

/// One hinge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hinge {
    /// Both ends of the edge, then the corners opposite of it; or the particle in the middle twice,
    /// then its neighbours.
    pub slots: [u32; 4],
    /// Weights of the corners.
    pub weights: [f32; 4],
    /// Constant for a flexural rigidity of one, in units that the weights make up for.
    pub shape: f32,
    /// Turn at rest; 0 where flat.
    pub turn: f32,
}
