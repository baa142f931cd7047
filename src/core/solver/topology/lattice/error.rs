//! Why rest positions make no lattice.

/// Why a set of rest positions is no lattice.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LatticeError {
    /// Fewer than two rows or columns.
    #[error("a sheet needs at least 2 x 2 particles, got {rows} rows x {columns} columns")]
    TooSmall {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
    },
    /// The size of a sheet is not positive and finite.
    #[error("the size of a sheet is {0} m, but must be positive and finite along both sides")]
    BadSize(bevy_math::Vec2),
    /// More particles than the indices of a mesh can count.
    #[error("{rows} rows x {columns} columns are more than {limit} particles")]
    TooLarge {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
        /// The largest number of particles.
        limit: usize,
    },
    /// The number of positions is not rows x columns.
    #[error("{rows} rows x {columns} columns need {} positions, got {positions}", rows * columns)]
    WrongLength {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
        /// Positions given.
        positions: usize,
    },
    /// A rest position is NaN, infinite or beyond 1e6 m.
    #[error("the rest position of particle {particle} is not finite, or beyond 1e6 m")]
    NonFinite {
        /// The particle, row by row.
        particle: usize,
    },
    /// Two neighbours along a thread coincide.
    #[error("particles {first} and {second} are neighbours but lie at the same place")]
    Coincident {
        /// One particle, row by row.
        first: usize,
        /// Its neighbour.
        second: usize,
    },
    /// Factors of mass or stiffness are not as many as the particles.
    #[error("there are {got} factors for {expected} particles")]
    WrongFactorCount {
        /// Particles.
        expected: usize,
        /// Factors given.
        got: usize,
    },
    /// A factor of mass or stiffness is not positive and finite.
    #[error("the factor of particle {particle} is {value}, but must be positive and finite")]
    BadFactor {
        /// The particle, row by row.
        particle: usize,
        /// Its factor.
        value: f32,
    },
}
