//! Which particles are held, and by what: data, not closures.

use bevy::ecs::entity::MapEntities;
use bevy::prelude::*;

use crate::cloth::weights::ColorChannel;
use crate::error::problems::PinProblem;
use crate::mesh::rest_shape::RestShape;
use crate::solver::SoftPin;

/// The particles of a cloth that are held. May be changed at any time.
///
/// A pin without an anchor follows the cloth's own entity: it stays at its rest position in the entity's frame. A pin with an anchor
/// keeps, in the anchor's frame, the place that its particle has when it takes hold. That is at the end of the frame that spawns the cloth,
/// or in the tick after the pin was added; where the fixed schedule moves the anchor before the cloth's first tick, it is in that tick.
///
/// An anchor is a hand, a mast, or a joint of a character, and a cloth may have many. One that stands still pins a cloth where it is by
/// now. One that is scaled spreads its pins, but not the cloth between them: scale the cloth's own entity as well. Pins hold hard or by
/// springs ([`PinHold`]). What no pin holds any more is released and goes on with the velocity it had.
///
/// A pin that cannot be used (no such vertex, an empty box, a despawned anchor) is reported once,
/// as a [`ClothFailure`](crate::ClothFailure), and holds nothing; the other pins stay.
#[derive(Component, Reflect, MapEntities, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothPins {
    /// The pins. Where several hold a particle, the last one does.
    #[entities]
    pub pins: Vec<Pin>,
}

/// Some particles of a cloth, held by one thing.
#[derive(Reflect, MapEntities, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub struct Pin {
    /// The particles.
    pub selection: PinSelection,
    /// The entity that holds them; `None` is the cloth's own.
    #[entities]
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity_option"))]
    pub anchor: Option<Entity>,
    /// How they are held.
    pub hold: PinHold,
}

/// How a [`Pin`] holds its particles.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Debug, PartialEq, Clone)]
pub enum PinHold {
    /// Particles are where the anchor says, and are drawn where it is drawn.
    #[default]
    Hard,
    /// Particles are drawn by springs towards where the anchor says, and collide on the way. The
    /// constants are those of the whole pin, which its particles share alike: a finer cloth is held as
    /// firmly.
    Soft {
        /// Constant of the spring \[N/m\], above 0. Higher holds closer: a weight `m g` hangs `m g / k`
        /// below.
        stiffness: f32,
        /// Constant of the damper beside it \[N s/m\]. Higher swings less; a mass `m` swings no more
        /// from `2 sqrt(k m)` on. It acts on the velocity relative to the anchor's. The least is
        /// `stiffness` times a substep.
        damping: f32,
    },
}

/// A choice of particles.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub enum PinSelection {
    /// These vertices of the mesh; of a sheet, `row * columns + column`.
    Vertices(Vec<u32>),
    /// All particles whose rest position lies in a box of the cloth's own frame.
    Within {
        /// Smallest coordinates \[m\].
        min: Vec3,
        /// Largest coordinates \[m\].
        max: Vec3,
    },
    /// All vertices whose colour, in one channel, is higher than a threshold.
    Color {
        /// The channel.
        channel: ColorChannel,
        /// The threshold, 0 to 1. Higher holds less.
        above: f32,
    },
    /// The four corners of a sheet or of a mesh that is a grid.
    Corners,
    /// The first row: of a sheet, its edge at -z. This and the next three are for sheets and for
    /// meshes that are a grid.
    FirstRow,
    /// The last row: of a sheet, its edge at +z.
    LastRow,
    /// The first column: of a sheet, its edge at -x.
    FirstColumn,
    /// The last column: of a sheet, its edge at +x.
    LastColumn,
    /// Every particle.
    All,
}

impl From<PinSelection> for Pin {
    fn from(selection: PinSelection) -> Self {
        Self { selection, anchor: None, hold: PinHold::Hard }
    }
}

impl From<PinSelection> for ClothPins {
    fn from(selection: PinSelection) -> Self {
        Self { pins: vec![selection.into()] }
    }
}

impl ClothPins {
    /// Nothing is held.
    pub fn none() -> Self {
        Self::default()
    }

    /// Holds these vertices of the mesh; of a sheet, `row * columns + column`.
    pub fn vertices(vertices: impl IntoIterator<Item = u32>) -> Self {
        PinSelection::Vertices(vertices.into_iter().collect()).into()
    }

    /// Holds what lies at rest in a box of the cloth's own frame \[m\].
    pub fn within(min: Vec3, max: Vec3) -> Self {
        PinSelection::Within { min, max }.into()
    }

    /// Holds the vertices whose colour, in one channel, is higher than `above`, 0 to 1.
    pub fn color(channel: ColorChannel, above: f32) -> Self {
        PinSelection::Color { channel, above }.into()
    }

    /// Lets `anchor` hold all pins so far that have no anchor.
    pub fn anchored_to(mut self, anchor: Entity) -> Self {
        for pin in &mut self.pins {
            pin.anchor.get_or_insert(anchor);
        }
        self
    }

    /// Lets all pins so far hold their particles by springs \[N/m\] and dampers \[N s/m\], each pin its
    /// own. See [`PinHold::Soft`].
    pub fn softly(mut self, stiffness: f32, damping: f32) -> Self {
        for pin in &mut self.pins {
            pin.hold = PinHold::Soft { stiffness, damping };
        }
        self
    }

    /// Adds the pins of another list.
    pub fn and(mut self, other: impl Into<Self>) -> Self {
        self.pins.extend(other.into().pins);
        self
    }
}

/// The shape of a cloth, as far as choosing particles of it goes.
pub(crate) struct Choices<'a> {
    /// Rows and columns, where it has any.
    pub grid: Option<(usize, usize)>,
    pub shape: &'a RestShape,
    /// Rest positions \[m\], by particle.
    pub rest: &'a [Vec3],
    /// Factor from rest positions to the cloth's own frame.
    pub inverse_scale: f32,
}

impl PinHold {
    /// Checks the numbers.
    pub(crate) fn validate(&self) -> Result<(), PinProblem> {
        match *self {
            Self::Hard => Ok(()),
            Self::Soft { stiffness, damping } => {
                SoftPin::check(stiffness, damping).map_err(PinProblem::Hold)
            }
        }
    }
}

impl PinSelection {
    /// Calls `hold` with every particle chosen, once or more.
    pub(crate) fn for_each(
        &self,
        cloth: &Choices,
        mut hold: impl FnMut(u32),
    ) -> Result<(), PinProblem> {
        let count = cloth.rest.len();
        let mut chosen = false;
        let mut pick = |particle: usize| {
            chosen = true;
            hold(particle as u32);
        };
        match self {
            Self::Vertices(vertices) => {
                let particles = vertices.iter().map(|&vertex| particle_of(cloth.shape, vertex));
                let particles = particles.collect::<Result<Vec<_>, _>>()?;
                particles.into_iter().for_each(|particle| pick(particle as usize));
            }
            Self::Within { min, max } => (0..count)
                .filter(|&i| {
                    let place = cloth.rest[i] * cloth.inverse_scale;
                    place.cmpge(*min).all() && place.cmple(*max).all()
                })
                .for_each(pick),
            Self::Color { channel, above } => {
                let colors = cloth.shape.colors().ok_or(PinProblem::NoColors)?;
                let used = cloth.shape.used_vertices();
                used.filter(|(vertex, _)| colors[*vertex][*channel as usize] > *above)
                    .for_each(|(_, particle)| pick(particle));
            }
            Self::All => (0..count).for_each(pick),
            Self::Corners
            | Self::FirstRow
            | Self::LastRow
            | Self::FirstColumn
            | Self::LastColumn => {
                let (rows, columns) = cloth.grid.ok_or(PinProblem::NotAGrid)?;
                self.for_each_of_grid(rows, columns, pick);
            }
        }
        if chosen { Ok(()) } else { Err(PinProblem::Empty) }
    }

    fn for_each_of_grid(&self, rows: usize, columns: usize, pick: impl FnMut(usize)) {
        let count = rows * columns;
        match self {
            Self::Corners => {
                [0, columns - 1, count - columns, count - 1].into_iter().for_each(pick);
            }
            Self::FirstRow => (0..columns).for_each(pick),
            Self::LastRow => (count - columns..count).for_each(pick),
            Self::FirstColumn => (0..rows).map(|r| r * columns).for_each(pick),
            Self::LastColumn => (1..=rows).map(|r| r * columns - 1).for_each(pick),
            _ => {}
        }
    }
}

fn particle_of(shape: &RestShape, vertex: u32) -> Result<u32, PinProblem> {
    let count = shape.vertex_count();
    if vertex as usize >= count {
        return Err(PinProblem::NoSuchVertex { vertex, count });
    }
    shape.particle_of(vertex).ok_or(PinProblem::UnusedVertex(vertex))
}
