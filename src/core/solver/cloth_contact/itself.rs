//! Contact of a cloth with itself.

use std::sync::Arc;

use bevy_math::Vec3;

use crate::solver::cloth_contact::balls::Balls;
use crate::solver::cloth_contact::batches::Batches;
use crate::solver::cloth_contact::beads::{Beads, Lying, TakenFrom};
use crate::solver::cloth_contact::clusters::Clusters;
use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::in_patches::InPatches;
use crate::solver::cloth_contact::kin::{AtRest, find_beside, find_kin};
use crate::solver::cloth_contact::mesh_patches::MeshPatches;
use crate::solver::cloth_contact::patch::PARTICLES;
use crate::solver::cloth_contact::patches::Division;
use crate::solver::cloth_contact::regions::{AddUp, Regions, Since};
use crate::solver::cloth_contact::respond::{LookAtPairs, Respond, Touched};
use crate::solver::cloth_contact::sheet_patches::SheetPatches;
use crate::solver::cloth_contact::side::Side;
use crate::solver::cloth_contact::tangles::Tangles;
use crate::solver::cloth_contact::travel::{Allowance, Moved, Travelled};
use crate::solver::cloth_contact::{AT_LEAST, CALM, MARGIN, Memory, check_numbers, substeps_for};
use crate::solver::settings::ParameterError;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

/// Pairs that there is room for from the start, for each particle.
const ROOM: usize = 4;

/// Up to this many pairs, all batches are awake in every substep: to look at them is less work than to measure how far particles go in a
/// substep.
const FEW: usize = 1024;

/// How a cloth collides with itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct SelfCollision {
    /// Distance at which particles are kept from each other \[m\]; `None` is the least at which no layer passes through another,
    /// 0.92 of the particle spacing on a square sheet. Smaller is thinner and lets layers pass.
    pub distance: Option<f32>,
    /// Coulomb's coefficient between layers \[1\]. Higher slides less.
    pub friction: f32,
}

impl Default for SelfCollision {
    fn default() -> Self {
        Self { distance: None, friction: 0.5 }
    }
}

impl SelfCollision {
    /// Checks every number, for a cloth.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is not finite or out of its range. A distance may be at most the automatic one
    /// over 0.92, which is the particle spacing of a square sheet.
    pub fn validate(&self, topology: &Topology) -> Result<(), ParameterError> {
        check_numbers(topology, self.distance, self.friction)
    }
}

/// A cloth's contact with itself: the pairs of its particles that may touch. They follow from where the particles
/// were when pairs were found last.
#[derive(Clone, Debug)]
pub(in crate::solver) struct SelfContact {
    pub settings: SelfCollision,
    /// Largest distance at which two particles touch \[m\].
    widest: f32,
    layout: Layout,
    particles: InPatches,
    regions: Regions,
    allowance: Allowance,
    tangles: Tangles,
    batches: Batches,
    beads: Beads,
    /// Positions when pairs were found last \[m\].
    found_at: Soa,
    /// Whether they were found, and no particle has been put elsewhere since.
    is_found: bool,
    /// Ticks since pairs touched, up to [`CALM`].
    since_touch: u32,
    /// Positions in the last substep \[m\]; where pairs were found, as long as they are few.
    last: Soa,
    /// [`FEW`].
    few: usize,
    /// What touched in it.
    touched: Touched,
    pairs: Vec<Pair>,
    /// Those that are near at rest.
    kin: Vec<Pair>,
    /// Gap up to which pairs are kept \[m\].
    margin: f32,
}

/// A substep of a cloth, as its contact with itself takes it.
pub(in crate::solver) struct Substep<'a> {
    pub isa: Isa,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Where its particles lie on colliders, if any do.
    pub lying: Option<Lying<'a>>,
    /// How far a pair is moved apart in the substep at most, without speed \[m\].
    pub most_push: f32,
}

impl SelfContact {
    /// For a cloth with settings that have been checked.
    pub fn new(topology: &Topology, faces: Arc<FacesAt>, settings: SelfCollision) -> Self {
        let balls = Balls::of(topology, settings.distance);
        let (layout, count) = (topology.layout(), topology.particle_count());
        let mut rest_of = Soa::zeros(layout.len());
        for (particle, &rest) in topology.rest_positions().iter().enumerate() {
            rest_of.set(topology.slot(particle), rest);
        }
        let (isa, widest, margin) = (Isa::detect(), balls.widest(), balls.widest() * MARGIN);
        let rest = AtRest { faces: &faces, at: &rest_of, radius: &balls.radius, widest };
        let kin = find_kin(isa, &rest, layout.slots());
        let division = match topology.as_lattice() {
            Some(lattice) => Division::Sheet(SheetPatches::new(lattice.layout)),
            None => {
                let beside = find_beside(isa, &rest, margin, layout.slots());
                let at = |slot: u32| rest_of.get(slot as usize);
                let clusters = Clusters::new(&faces, layout.slots(), at, PARTICLES);
                Division::Mesh(MeshPatches::new(&faces, &clusters, beside))
            }
        };
        let particles = InPatches::new(division, &rest_of, &balls.radius);
        let regions = Regions::new(topology);
        Self {
            settings,
            layout,
            particles,
            allowance: Allowance::with_room(regions.extents.capacity()),
            regions,
            tangles: Tangles::new(topology, faces),
            batches: Batches::default(),
            beads: Beads::new(layout.len()),
            found_at: Soa::zeros(layout.len()),
            is_found: false,
            since_touch: CALM,
            last: Soa::zeros(layout.len()),
            few: FEW,
            touched: Touched::default(),
            pairs: Vec::with_capacity(ROOM * count),
            kin,
            margin,
            widest,
        }
    }

    /// Begins a tick.
    pub fn begin_tick(&mut self) {
        self.since_touch = (self.since_touch + 1).min(CALM);
        self.tangles.begin_tick();
    }

    /// Substeps in 1/60 s that it asks for.
    pub fn substeps(&self) -> u32 {
        substeps_for(self.widest, self.since_touch)
    }

    /// The cloth's faces.
    pub fn faces(&self) -> Arc<FacesAt> {
        self.tangles.faces.clone()
    }

    /// Takes out all that its later bits depend on.
    pub fn memory(&self) -> Memory {
        Memory {
            found_at: self.is_found.then(|| self.found_at.clone()),
            since_touch: self.since_touch,
            ..self.tangles.memory()
        }
    }

    /// Takes over another's memory.
    pub fn remember(&mut self, isa: Isa, memory: Memory) {
        self.since_touch = memory.since_touch.min(CALM);
        self.tangles.remember(&memory);
        self.is_found = false;
        if let Some(found_at) = memory.found_at {
            self.found_at = found_at;
            self.find(isa);
        }
    }

    /// Forgets which pairs there are: particles have been put elsewhere.
    pub fn forget(&mut self) {
        self.is_found = false;
        self.tangles.suspect();
    }

    /// Moves apart what touches. Tells how many pairs do.
    pub fn meet(&mut self, on: Substep<'_>) -> u32 {
        let Substep { isa, inverse_mass, x, d, lying, most_push } = on;
        let mut travelled = Travelled { is_too_far: !self.is_found, ..Travelled::NOTHING };
        if self.is_found {
            let is_few = self.pairs.len() <= self.few;
            let last = if is_few { None } else { Some(&mut self.last) };
            let since = Since { from: &self.found_at, last, first: 0 };
            self.regions.measure(isa, (x, d, Vec3::ZERO), since);
            let Regions { extents: all, steps: step, .. } = &self.regions;
            travelled = self.allowance.measure([Moved { all, step }; 2]);
            // All are within the margin of where pairs were found, so that no step and no gap is longer than two: all wake.
            travelled.step = if is_few { 2.0 * self.margin } else { travelled.step };
        }
        if travelled.is_too_far {
            isa.run(AddUp { x, d, shift: Vec3::ZERO, to: &mut self.found_at, first: 0 });
            self.find(isa);
            travelled = Travelled::NOTHING;
        }
        if self.tangles.is_due() {
            self.tangles.begin_search();
            let at = |slot: u32| x.get(slot as usize) + d.get(slot as usize);
            for pair in &self.pairs {
                self.tangles.search(pair, at);
            }
        }
        let mut on = Substep { isa, inverse_mass, x, d, lying, most_push };
        self.take_in(&on);
        let Self { pairs, batches, beads, .. } = self;
        let Travelled { most: travelled, step, .. } = travelled;
        let (beads, shift) = ([&*beads, &*beads], Vec3::ZERO);
        isa.run_transposing(LookAtPairs { pairs, batches, beads, shift, travelled, step });
        self.touched = self.respond(&mut on, 1.0);
        self.since_touch = if self.touched.count > 0 { 0 } else { self.since_touch };
        self.tangles.is_suspected |= self.touched.is_deep();
        self.touched.count
    }

    /// Whether layers met that are pressed into each other, which are to be kept apart after the strain limit.
    pub fn is_pressed(&self) -> bool {
        self.touched.is_pressed()
    }

    /// Keeps layers apart that the strain limit has pulled together, after they were met in the same substep.
    pub fn keep_apart(&mut self, mut on: Substep<'_>) {
        self.take_in(&on);
        self.respond(&mut on, AT_LEAST);
    }

    /// Takes in the particles that are in pairs.
    fn take_in(&mut self, on: &Substep<'_>) {
        let Tangles { any, is_down, .. } = &self.tangles;
        let from = TakenFrom {
            x: on.x,
            moves: Some((on.d, on.inverse_mass)),
            lying: on.lying.as_ref(),
            is_down: any.then_some(&**is_down),
        };
        self.beads.take_in(on.isa, from);
    }

    /// Moves pairs apart to a part of the distance at which they touch.
    fn respond(&mut self, on: &mut Substep<'_>, part: f32) -> Touched {
        let side = Side {
            beads: &mut self.beads,
            load: on.lying.as_mut().map(|lying| &mut *lying.load),
            faces: &self.tangles.faces,
            found_at: &self.found_at,
            first: 0,
            is_held: false,
        };
        let touched = on.isa.run_transposing(Respond {
            batches: &mut self.batches,
            sides: &mut [side],
            shift: Vec3::ZERO,
            drift: Vec3::ZERO,
            friction: self.settings.friction,
            most_push: on.most_push,
            part,
        });
        if touched.count > 0 {
            self.beads.put_back(on.isa, on.x, on.d);
        }
        touched
    }

    /// Finds the pairs of particles that are at `found_at`.
    fn find(&mut self, isa: Isa) {
        let Self {
            particles,
            regions,
            allowance,
            found_at: at,
            last,
            pairs,
            kin,
            margin,
            widest,
            batches,
            beads,
            ..
        } = self;
        let reach = *widest + *margin;
        regions.look(isa, at, 0);
        allowance.begin_with_one(&regions.extents, *margin, reach);
        last.copy_from(at);
        pairs.clear();
        particles.find(isa, at, *margin, reach, pairs);
        pairs.extend(kin.iter().filter_map(|pair| pair.now(at, *margin)));
        beads.forget_pairs();
        pairs.iter().flat_map(|pair| pair.slots).for_each(|slot| beads.note(slot));
        batches.begin(pairs, *margin, [self.layout.len(), 0]);
        self.is_found = true;
    }
}

#[cfg(test)]
mod tests {
    use bevy_math::Vec2;

    use super::*;
    use crate::solver::settings::MassLumping;
    use crate::solver::topology::lattice::Lattice;

    /// A sheet that is rolled up around a line until its layers meet.
    #[test]
    fn batches_that_sleep_change_no_bit() {
        const SIDE: usize = 20;
        let sheet = Lattice::sheet(Vec2::ONE, SIDE, SIDE, MassLumping::Lumped).unwrap();
        let topology = Topology::from(Arc::new(sheet));
        let layout = topology.layout();
        let mut inverse_mass = vec![0.0; layout.len()];
        layout.slots().for_each(|slot| inverse_mass[slot] = 1000.0);
        let run = |few: usize| {
            let faces = Arc::new(FacesAt::new(&topology));
            let mut contact = SelfContact::new(&topology, faces, SelfCollision::default());
            contact.few = few;
            let [mut x, mut d] = [(); 2].map(|()| Soa::zeros(layout.len()));
            for (particle, &rest) in topology.rest_positions().iter().enumerate() {
                x.set(topology.slot(particle), rest);
            }
            let (mut met, mut most) = (0, 0);
            for step in 0..120 {
                if step % 20 == 0 {
                    contact.begin_tick();
                }
                let radius = 0.5 / (1.0 + step as f32 / 8.0);
                for (particle, rest) in topology.rest_positions().iter().enumerate() {
                    let slot = topology.slot(particle);
                    let (sine, cosine) = (rest.x / radius).sin_cos();
                    let goal = Vec3::new(radius * sine, radius * cosine, rest.z);
                    d.set(slot, (goal - x.get(slot)).clamp_length_max(0.02));
                }
                let isa = Isa::detect();
                let (inverse_mass, most_push) = (&*inverse_mass, 1e-3);
                let (x, d) = (&mut x, &mut d);
                met += contact.meet(Substep { isa, inverse_mass, x, d, lying: None, most_push });
                most = most.max(contact.pairs.len());
                for slot in layout.slots() {
                    x.set(slot, x.get(slot) + d.get(slot));
                }
            }
            let bits = |slot: usize| x.get(slot).to_array().map(f32::to_bits);
            (met, most, layout.slots().map(bits).collect::<Vec<_>>())
        };
        let awake = run(usize::MAX);
        assert!(awake.0 > 100 && awake.1 > 500, "{} met of {}", awake.0, awake.1);
        assert_eq!(run(0), awake);
    }
}
