//! Drag and lift of the air around a cloth, face by face.
//!
//! The split into drag along the relative wind and lift across it, both in proportion to the area
//! that the wind sees, is that of Keckeisen, Kimmerle, Thomaszewski and Wacker, *Modelling Effects
//! of Wind Fields in Cloth Animations* (2004), and of `NvCloth`. A flat sheet that falls level has the
//! terminal speed `sqrt(2 m g / (rho C_d A))`.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `law` | the force on one face, and how it stays stable |
//! | `cells`, `triangles` | faces of a lattice, and of any triangles: velocities in, forces out |
//! | `shares` | the mass that takes a face's force |

mod cells;
mod law;
mod shares;
mod triangles;
#[cfg(test)]
mod triangles_tests;

use bevy_math::Vec3;

use crate::solver::forces::aerodynamics::cells::Cells;
use crate::solver::forces::aerodynamics::law::Law;
use crate::solver::forces::aerodynamics::triangles::Triangles;
use crate::solver::forces::wind::{Place, Wind};
use crate::solver::settings::{ParameterError, check};
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::isa::Isa;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::topology::Topology;
use crate::solver::topology::graph::Graph;

/// The aerodynamic properties of a cloth.
///
/// A face of area A that the air meets with velocity u feels `density / 2 * A * |u . n|` times
/// `drag * u + lift * (|u| sign(u . n) n - |u . n| u / |u|)`, n being its normal (Keckeisen, Kimmerle,
/// Thomaszewski and Wacker 2004).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct Air {
    /// Density of the air \[kg/m3\]. Higher pushes harder.
    pub density: f32,
    /// Coefficient of drag, along the relative wind \[1\]. Higher is carried along better and falls slower.
    pub drag: f32,
    /// Coefficient of lift, across the relative wind \[1\]. Higher sails and flutters more.
    pub lift: f32,
}

impl Default for Air {
    fn default() -> Self {
        Self { density: 1.225, drag: 1.2, lift: 0.6 }
    }
}

impl Air {
    /// Checks every number.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is not finite or out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check("density", self.density, 0.0, 1e5, "from 0 to 1e5 kg/m3")?;
        check("drag", self.drag, 0.0, 1e3, "from 0 to 1000")?;
        check("lift", self.lift, 0.0, 1e3, "from 0 to 1000")
    }
}

/// Air around a cloth: its faces, and the wind at each.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    pub air: Air,
    faces: Faces,
    /// 1 / area of cloth whose mass takes a face's force \[1/m2\]; 0 for what is no face.
    inverse_area: Array,
    /// Where the faces are, when the wind differs between them.
    centres: Soa,
    /// The wind at each face \[m/s\], when it differs between them.
    local: Soa,
    /// The wind that all faces are in, when it is the same \[m/s\].
    uniform: Option<Vec3>,
}

#[derive(Clone, Debug)]
enum Faces {
    Cells(Cells),
    Triangles(Triangles),
}

/// Input of the aerodynamic forces in a substep.
pub(crate) struct Push<'a> {
    /// The time that the force acts \[s\].
    pub kick: f32,
    /// The time that makes velocities of displacements \[s\].
    pub unit: f32,
    /// Mass per area \[kg/m2\].
    pub area_density: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// Accelerations by all other forces, then by all forces.
    pub a: &'a mut Soa,
}

impl Surface {
    pub fn new(air: Air, topology: &Topology) -> Self {
        match topology {
            Topology::Lattice(lattice) => {
                let (cells, inverse) = Cells::new(lattice);
                Self::with_faces(air, Faces::Cells(cells), &inverse)
            }
            Topology::Graph(graph) => Self::of_graph(air, graph),
        }
    }

    /// The faces of a graph, whose particles lie in an order of their own.
    fn of_graph(air: Air, graph: &Graph) -> Self {
        let layout = graph.layout;
        let place = |particle: u32| graph.slot(particle as usize) - layout.slot(0, 0);
        let triangles: Vec<_> =
            graph.triangles().iter().map(|t| t.map(|particle| place(particle) as u32)).collect();
        let mut rest = vec![Vec3::ZERO; graph.rest_positions().len()];
        for (particle, &p) in graph.rest_positions().iter().enumerate() {
            rest[place(particle as u32)] = p;
        }
        Self::of_triangles(air, layout, &triangles, &rest, &graph.area)
    }

    /// The same for triangles of particles that lie in a layout, row by row; their rest positions \[m\],
    /// and the area of cloth that the particle of each slot stands for \[m2\].
    fn of_triangles(
        air: Air,
        layout: Layout,
        triangles: &[[u32; 3]],
        rest: &[Vec3],
        particle_area: &[f32],
    ) -> Self {
        let (triangles, inverse) = Triangles::new(layout, triangles, rest, particle_area);
        Self::with_faces(air, Faces::Triangles(triangles), &inverse)
    }

    fn with_faces(air: Air, faces: Faces, inverse: &[f32]) -> Self {
        let len = inverse.len();
        let mut inverse_area = Array::zeros(len);
        inverse_area[..len].copy_from_slice(inverse);
        Self {
            air,
            faces,
            inverse_area,
            centres: Soa::zeros(len),
            local: Soa::zeros(len),
            uniform: Some(Vec3::ZERO),
        }
    }

    /// Takes the wind of a tick, where the faces are at its start.
    pub fn begin_tick(&mut self, isa: Isa, wind: &Wind<'_>, place: Place, x: &Soa) {
        self.uniform = wind.uniform_in(&place);
        if self.uniform.is_none() {
            let centres = &mut self.centres;
            match &mut self.faces {
                Faces::Cells(cells) => isa.run(cells::FindCentres { cells, x, centres }),
                Faces::Triangles(triangles) => {
                    isa.run(triangles::FindCentres { triangles, x, centres });
                }
            }
            wind.sample(isa, &place, &self.centres, &mut self.local);
        }
    }

    /// Largest acceleration that the wind gives a cloth of this area density at rest \[m/s2\], to the
    /// next power of two: what follows from it need not change with every gust.
    pub fn load(&self, wind: &Wind<'_>, place: &Place, area_density: f32) -> f32 {
        let speed = wind.most_in(place);
        let Air { density, drag, lift } = self.air;
        let most = 0.5 * density * (drag + lift) * speed * speed / area_density;
        if most > 0.0 { f32::from_bits(most.to_bits() & 0x7f80_0000) * 2.0 } else { 0.0 }
    }

    /// Adds what the air does to the accelerations.
    pub fn push(&mut self, isa: Isa, push: Push<'_>) {
        let Push { kick, unit, area_density, inverse_mass, x, d, a } = push;
        let half_density = 0.5 * self.air.density;
        let flow = Flow {
            law: Law {
                drag: half_density * self.air.drag,
                lift: half_density * self.air.lift,
                kick,
            },
            wind: match self.uniform {
                Some(wind) => FaceWind::Uniform(wind),
                None => FaceWind::Each(&self.local),
            },
            inverse_unit: 1.0 / unit,
            inverse_density: 1.0 / area_density,
            inverse_area: &self.inverse_area,
        };
        match &mut self.faces {
            Faces::Cells(cells) => {
                isa.run(cells::PushCells { cells, flow, inverse_mass, x, d, a });
            }
            Faces::Triangles(triangles) => {
                isa.run(triangles::PushTriangles { triangles, flow, inverse_mass, x, d, a });
            }
        }
    }
}

/// The wind that faces are in \[m/s\].
#[derive(Clone, Copy)]
enum FaceWind<'a> {
    Uniform(Vec3),
    Each(&'a Soa),
}

/// Air that flows past faces.
#[derive(Clone, Copy)]
struct Flow<'a> {
    law: Law,
    wind: FaceWind<'a>,
    /// Makes velocities of displacements \[1/s\].
    inverse_unit: f32,
    /// \[m2/kg\]
    inverse_density: f32,
    /// See [`Surface`].
    inverse_area: &'a [f32],
}

impl Flow<'_> {
    /// Forces on [`LANES`] faces, from their vector areas, displacements, and accelerations by other
    /// forces.
    #[inline(always)]
    fn forces(&self, face: usize, area: Block3, d: Block3, a: Block3) -> Block3 {
        let wind = match self.wind {
            FaceWind::Uniform(wind) => Block3::splat(wind),
            FaceWind::Each(local) => Block3::load(local, face),
        };
        let share = Block::load(self.inverse_area, face);
        let mut force = Block3::ZERO;
        for i in 0..LANES {
            let now = wind.at(i) - d.at(i) * self.inverse_unit;
            let then = now - a.at(i) * self.law.kick;
            let pushed = self.law.force(area.at(i), now, then, share.0[i] * self.inverse_density);
            force.set(i, if share.0[i] > 0.0 { pushed } else { Vec3::ZERO });
        }
        force
    }
}
