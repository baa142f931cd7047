//! The families of explicit forces, which a material gives a constant each.

/// A value for each family of springs and hinges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PerFamily<T> {
    /// Structural springs.
    pub thread: T,
    /// Shear springs.
    pub shear: T,
    /// Hinges of second differences.
    pub bend: T,
    /// Flexion springs, between every second particle.
    pub flexion: T,
}

/// Constants for a shape factor of one: of structural and shear springs \[N/m\], of hinges \[N m\], of flexion springs
/// \[N m4\], over the fourth power of their cells. Of Gershgorin's circles, the row sums over the mass for such constants
/// of one.
pub(crate) type Constants = PerFamily<f32>;

impl Constants {
    /// Whether any spring has a constant.
    pub fn pull(&self) -> bool {
        self.thread > 0.0 || self.shear > 0.0 || self.flexion > 0.0
    }

    /// The sum over the families of the product of both.
    pub fn dot(&self, other: &Self) -> f32 {
        self.thread * other.thread
            + self.shear * other.shear
            + self.bend * other.bend
            + self.flexion * other.flexion
    }

    /// All times a factor.
    pub fn scaled(self, by: f32) -> Self {
        let Self { thread, shear, bend, flexion } = self;
        Self { thread: thread * by, shear: shear * by, bend: bend * by, flexion: flexion * by }
    }
}
