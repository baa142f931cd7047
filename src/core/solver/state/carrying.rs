//! Rigid bodies that a cloth carries, and the mass that it moves as if it had for that.
//!
//! A pass over the threads moves forces no further than the cloth's own inertia has them. Under a body of many times its mass, a cloth yields in
//! every substep by what its particles are pushed aside before their threads pull them back: with 20 substeps a hammock of 0.2 kg hung 10 cm
//! too low under 10 kg, and with 200 1 cm. So a cloth that carries bodies moves as if it had a part of their mass beside its own, and weighs no
//! more than it does: mass scaling (Olovsson, Simonsson and Unosson 2005, *Selective mass scaling for explicit finite element analyses*).
//! Where it comes to rest does not depend on that, and how it moves is up to the bodies.
//!
//! Only cloth that hangs from something does so, as momentum is nothing that stays there; and none whose pins pull at bodies: what such a
//! body is given comes late, and mass that is hung on it would set it swinging.

/// Part of the bodies' mass that a cloth moves as if it had.
const PART: f64 = 0.5;
/// Speed up to which a body that falls comes to lie on the cloth, from which on it strikes \[m/s\].
const SLOW: f32 = 0.5;
/// Speed beyond that by which the cloth takes up twice that part \[m/s\]. It goes back once the body is caught.
const SPEED: f32 = 2.0;
/// Part of the mass of what strikes that the cloth takes up at most.
const MOST_PART: f64 = 2.0;
/// Rate at which the scale of a cloth's mass comes to what it is to be \[1/s\]. Bodies that are in the air for a moment come back.
const RATE: f32 = 5.0;
/// Largest scale: what single precision tells the weight of a cloth from.
const MOST: f64 = 1e4;

/// The load of a cloth, as far as it goes on from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Carrying {
    /// The cloth's share of the mass that moves in the last tick: what it moves as if it had, and what it carries. `None` where it carries
    /// nothing, and has met no body.
    pub share: Option<f32>,
    /// Mass that the cloth moves as if it had, over its own: 1 or more.
    pub mass_scale: f32,
    /// The heaviest body that it carries or carried, by the key that its colliders have in common; 0 for none that has one.
    pub heaviest: u64,
}

/// Kinds of loads that a cloth is found to have in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Load {
    /// Nothing, and it has met no body.
    None,
    /// Nothing at present: bodies that it has met may be in the air, and come back.
    Met,
    /// A load as in the tick before: the heaviest body lies on it, and sleeps. One that sleeps is no body to it.
    AsBefore,
    /// Colliders that are no bodies, and press on cloth that is held.
    Pressed,
    /// Bodies that the cloth bears.
    Bodies(Burden),
}

/// The bodies that a cloth carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Burden {
    /// Their mass, over the cloth's.
    pub mass: f64,
    /// The heaviest, as [`Carrying`] knows it.
    pub heaviest: u64,
}

impl Carrying {
    pub const NOTHING: Self = Self { share: None, mass_scale: 1.0, heaviest: 0 };

    /// Follows what the cloth is found to carry in a tick \[s\]. Only cloth that `hangs` from what it does not move is scaled. If it
    /// `is_stretched` far beyond its limit, it takes up no more mass: it would contract, and throw up what it carries.
    pub fn follow(&mut self, load: Load, hangs: bool, is_stretched: bool, tick: f32) {
        let target = if hangs { self.scale_for(load) } else { 1.0 };
        let grows = target > self.mass_scale;
        self.mass_scale = if grows && is_stretched {
            self.mass_scale
        } else if grows || !hangs {
            target
        } else {
            self.scale_on_the_way_to(target, tick)
        };
        self.share = match load {
            Load::None => None,
            Load::Met => Some(0.0),
            Load::AsBefore => self.share,
            Load::Pressed => Some(1.0),
            Load::Bodies(Burden { mass, .. }) => {
                let own = f64::from(self.mass_scale);
                Some((own / (own + mass)) as f32)
            }
        };
        self.heaviest = match load {
            Load::Bodies(Burden { heaviest, .. }) => heaviest,
            Load::AsBefore => self.heaviest,
            Load::None | Load::Met | Load::Pressed => 0,
        };
    }

    /// Returns the part of a body's mass that a cloth takes up as the body falls onto it at a speed \[m/s\].
    pub fn part_of(speed: f32) -> f64 {
        (PART * (1.0 + f64::from((speed - SLOW) / SPEED).max(0.0))).min(MOST_PART)
    }

    /// Takes up so many times its own mass within a tick, where that is more than it has taken up. Returns by how much less it moves then.
    pub fn take_up(&mut self, mass: f64) -> f32 {
        let scale = (1.0 + mass).min(MOST) as f32;
        let before = self.mass_scale;
        self.mass_scale = before.max(scale);
        before / self.mass_scale
    }

    /// Returns the scale that a load asks for.
    fn scale_for(&self, load: Load) -> f32 {
        match load {
            Load::AsBefore => self.mass_scale,
            Load::Bodies(Burden { mass, .. }) => (1.0 + PART * mass).min(MOST) as f32,
            Load::None | Load::Met | Load::Pressed => 1.0,
        }
    }

    /// Returns the scale after a tick, where it shrinks. It comes to its end: what is not scaled is to be computed as if it never had been.
    fn scale_on_the_way_to(&self, target: f32, tick: f32) -> f32 {
        let left = (self.mass_scale - target) * (1.0 - RATE * tick).max(0.0);
        if left < 1e-3 { target } else { target + left }
    }

    /// Whether it can have been.
    pub fn is_good(&self) -> bool {
        let is_share = |share: f32| (0.0..=1.0).contains(&share);
        self.share.is_none_or(is_share) && (1.0..=MOST).contains(&self.mass_scale.into())
    }
}
