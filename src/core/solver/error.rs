//! Errors of a solver: the input that it refuses, and divergence.

use crate::solver::settings::{MassLumping, ParameterError};
use crate::solver::topology::graph::GraphError;
use crate::solver::topology::lattice::LatticeError;

/// Why a solver cannot be made, changed or stepped. Nothing has changed when one is returned, but for
/// [`SolverError::Diverged`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolverError {
    /// The rest shape is no lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// The triangles make no cloth.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// A number of the material or of the settings is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The start positions are not one a particle.
    #[error("{expected} particles need as many start positions, got {got}")]
    WrongPositionCount {
        /// Particles of the rest shape.
        expected: usize,
        /// Positions given.
        got: usize,
    },
    /// A position or velocity is NaN, infinite or beyond 1e7.
    #[error("the {what} of particle {particle} is not finite, or beyond 1e7")]
    NonFinite {
        /// Which of its vectors.
        what: &'static str,
        /// The particle.
        particle: usize,
    },
    /// The rest shape was made for the other kind of masses.
    #[error(
        "the rest shape was made for {made:?} masses, but the settings ask for {asked:?}: make it anew"
    )]
    OtherLumping {
        /// Masses of the rest shape.
        made: MassLumping,
        /// Masses of the settings.
        asked: MassLumping,
    },
    /// Cloths that are stepped together are given ticks of different lengths.
    #[error(
        "the tick of a cloth that is stepped together with others has another length than theirs"
    )]
    OtherTick,
    /// A cloth is to go on over a rest shape of other particles.
    #[error("the rest shape has other particles than the cloth, or other rows: make a new solver")]
    OtherParticles,
    /// A particle that is to be held or set does not exist.
    #[error("there is no particle {particle}: the cloth has {count}")]
    NoSuchParticle {
        /// The particle asked for.
        particle: usize,
        /// Particles of the cloth.
        count: usize,
    },
    /// The step input does not have one motion for each pin.
    #[error("the cloth has {pins} pins, but {motions} pin motions were given")]
    WrongPinCount {
        /// Pins of the cloth.
        pins: usize,
        /// Motions given.
        motions: usize,
    },
    /// The limits of the skin, or its places in a tick, are not one a particle.
    #[error("the cloth has {particles} particles on the skin, but {motions} were given")]
    WrongSkinCount {
        /// Particles that are held to the skin.
        particles: usize,
        /// Limits or motions given.
        motions: usize,
    },
    /// A number that holds a particle to the skin is out of its range.
    #[error("the skin's {problem}, at particle {particle}")]
    SkinLimit {
        /// The particle.
        particle: usize,
        /// Which number.
        problem: ParameterError,
    },
    /// A particle has a backstop, and its skin no normal.
    #[error("particle {0} has a backstop, but the skin has no normal there")]
    NoSkinNormal(usize),
    /// The tick's length is not positive and finite, or beyond a second.
    #[error("a tick of {0} s cannot be taken: it must be above 0 and at most 1 s")]
    Tick(f32),
    /// Gravity is not finite, or beyond 1e6 m/s2.
    #[error("gravity is not finite, or beyond 1e6 m/s2")]
    Gravity,
    /// A number of the wind is not finite, or out of its range.
    #[error("the wind's {0}")]
    Wind(ParameterError),
    /// A wind zone cannot be used.
    #[error(
        "wind zone {0} has a size that is not positive, a speed or falloff that is out of range, or a pose that cannot be used"
    )]
    Zone(usize),
    /// The pose of a pin is not finite, or beyond 1e7 m.
    #[error("the target of pin {0} is not finite, or beyond 1e7 m")]
    PinTarget(usize),
    /// A pin that is to pull at a body does not exist.
    #[error("pin {pin} is to pull at a body, but there are {pins} pins")]
    NoSuchPin {
        /// Place asked for.
        pin: usize,
        /// Number of pins, hard and soft.
        pins: usize,
    },
    /// A motion of the whole cloth, or a pose to put it in, is not finite, or leads beyond 1e7 m.
    #[error("the pose to carry the cloth to is not finite, or beyond 1e7 m")]
    Motion,
    /// A force, an impulse or a change of velocity is not finite, is beyond 1e7, or gives a particle more than
    /// 1e9 m/s2 or 1e7 m/s; or the place of a push is.
    #[error(
        "the {what} to push with is not finite, or too large for what it pushes: keep it below 1e7, 1e9 m/s2 and 1e7 m/s"
    )]
    Push {
        /// Which of its vectors.
        what: &'static str,
    },
    /// The pose or friction of a collider cannot be used.
    #[error(
        "collider {0} has a pose that is not finite, a rotation that is not of length one, a scale that is not positive, or a negative friction"
    )]
    Collider(usize),
    /// The tick came to positions that are not finite. The cloth is back where the tick began, at
    /// rest.
    #[error(
        "the cloth diverged; it was put back to where the tick began, at rest: change its material or settings, or reset it"
    )]
    Diverged,
}
