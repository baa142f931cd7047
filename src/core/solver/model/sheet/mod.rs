//! The sheet: rows of blocks of particles. Its stages may be cut into bands of rows, which threads share.

mod correct;
mod forces;

use std::sync::Arc;

use crate::solver::constraints::shear::{RowPulls, bears};
use crate::solver::constraints::strain_check::{Beyond, ExceedsLimit, Limit, Since};
use crate::solver::constraints::strain_limit::{CorrectSprings, Rule};
use crate::solver::constraints::threads::ThreadWorkspace;
use crate::solver::constraints::threads::bias::{Diagonals, ShearLaw};
use crate::solver::constraints::threads::shifts::{LineSprings, SheetShifts, Shifting};
use crate::solver::constraints::threads::tridiagonal::Reach;
use crate::solver::forces::bending::{Hinges, Moments};
use crate::solver::forces::bending_friction::Brakes;
use crate::solver::forces::families::Constants;
use crate::solver::forces::spring_rows::SpringRows;
use crate::solver::integrate::houbolt::Filter;
use crate::solver::model::{Acting, Particles, Shearing, Stages};
use crate::solver::plan::Plan;
use crate::solver::plan::stability::Bound;
use crate::solver::settings::Bending;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{self, Bands, Seams, Workspaces};
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::state::State;
use crate::solver::state::measure::{Survey, TakeSurvey};
use crate::solver::topology::lattice::Lattice;

/// A sheet's rest shape, the hinges of its threads, and what its stages work in.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    lattice: Arc<Lattice>,
    /// Hinges of weft and warp.
    hinges: [Hinges; 2],
    /// The diagonals that go either way.
    diagonals: [Diagonals; 2],
    /// Whether shear springs are solved along those in every tick: where a pass over the cells does not bear them.
    is_on_bias: bool,
    /// How springs are shifted, and whether any is.
    shifts: SheetShifts,
    is_shifted: bool,
    /// Compliances in the last substep of threads, and of the diagonals where these were solved whole \[1/kg\].
    compliance: f32,
    shear_compliance: Option<f32>,
    workspace: SheetWorkspace,
}

/// Room that the stages work in; nothing in it outlives a substep.
#[derive(Clone, Debug)]
struct SheetWorkspace {
    /// Forces of springs, while a row is worked on.
    rows: Workspaces<SpringRows>,
    /// Moments of the hinges.
    moments: Workspaces<Moments>,
    /// Where springs were beyond their limit when they were last looked at.
    beyond: Beyond,
    /// Displacements predicted for the damping.
    predicted: Soa,
    /// Room for braking what bends.
    brakes: Brakes,
    /// Pulls of shear springs.
    row_pulls: Workspaces<RowPulls>,
    /// Memory that threads are solved in.
    threads: Workspaces<ThreadWorkspace>,
    /// Displacements of the rows on both sides of each cut.
    seams: Seams,
    /// Displacements of columns and of diagonals, where they are solved apart from each other.
    apart: Soa,
    /// Loads that particles of such put on what they lie on.
    load_apart: Array,
}

impl Sheet {
    /// Nothing held.
    pub fn new(lattice: Arc<Lattice>) -> Self {
        let hinges = Hinges::build(&lattice, &vec![false; lattice.layout.len()]);
        let layout = lattice.layout;
        let diagonals = Diagonals::both(layout);
        let workspace = SheetWorkspace::new(&lattice, &diagonals);
        Self {
            lattice,
            hinges,
            diagonals,
            is_on_bias: false,
            shifts: SheetShifts::none(layout),
            is_shifted: false,
            compliance: 0.0,
            shear_compliance: None,
            workspace,
        }
    }
}

impl SheetWorkspace {
    fn new(lattice: &Lattice, diagonals: &[Diagonals; 2]) -> Self {
        let layout = lattice.layout;
        let len = layout.len();
        let bands = Bands::new(layout, true);
        let count = bands.rows.count();
        let is_apart = bands.columns.count() > 1;
        let bundles = layout.columns.next_multiple_of(LANES) * layout.rows;
        let longest = diagonals.iter().map(Diagonals::len).fold(bundles, usize::max);
        let apart = if is_apart { longest } else { 0 };
        Self {
            rows: Workspaces::new(count, || SpringRows::new(layout)),
            moments: Workspaces::new(count, || Moments::new(layout)),
            beyond: Beyond::new(layout),
            predicted: Soa::zeros(len),
            brakes: Brakes::new(len),
            row_pulls: Workspaces::new(count, || RowPulls::new(layout.columns)),
            threads: Workspaces::new(bands.most(), || ThreadWorkspace::new(layout)),
            seams: Seams::new(bands.rows),
            apart: Soa::zeros(apart),
            load_apart: Array::zeros(apart),
        }
    }
}

impl Stages for Sheet {
    fn hold(&mut self, held: &[bool]) {
        self.hinges = Hinges::build(&self.lattice, held);
    }

    fn bound(&self, inverse_mass: &[f32]) -> Bound {
        Bound::of_lattice(&self.lattice, &self.hinges, inverse_mass)
    }

    fn bend(&mut self, _: Bending, _: bool) {}

    fn follow(&mut self, plan: &Plan, bound: &Bound) {
        let shear = Constants { shear: plan.shear_stiffness, ..Constants::default() };
        self.is_on_bias = !bears(bound.rate(&shear), plan.step, self.lattice.crowd);
    }

    fn filter(&self, _: bool) -> Option<Filter> {
        Some(Filter::HOUBOLT)
    }

    fn brake_bending(&mut self, on: Particles<'_>, part: f32, most: f32) {
        self.brake_threads(on, part, most);
    }

    fn accelerate(&mut self, mut on: Particles<'_>, acting: &Acting<'_>, a: &mut Soa) {
        self.accumulate_forces(&mut on, acting, a);
        if let Some(pushes) = acting.pushes {
            pushes.add(on.isa, self.lattice.layout, &on.pins.inverse_mass, a);
        }
        if acting.plan.damping > 0.0 {
            self.add_damping(&mut on, acting, a);
        }
    }

    fn begin_corrections(&mut self, _: Particles<'_>) {}

    fn correct_shear(&mut self, on: Particles<'_>, reach: Reach, how: Shearing) {
        let Reach { compliance, limit, .. } = reach;
        let is_on_bias = self.is_on_bias || how.whole;
        self.shear_compliance = is_on_bias.then_some(compliance);
        if is_on_bias {
            self.solve_bias(on, ShearLaw(reach), how.ends_tick);
        } else if on.state.carries {
            self.correct_cells(on, compliance, limit);
        } else {
            self.correct_springs(on, Rule::Shear { compliance, limit });
        }
    }

    fn solve_threads(&mut self, mut on: Particles<'_>, reach: Reach, ends_tick: bool) -> bool {
        self.compliance = reach.compliance;
        let weft_beyond = self.solve_weft(&mut on, reach, ends_tick);
        let warp_beyond = self.solve_warp(&mut on, reach, ends_tick);
        weft_beyond || warp_beyond
    }

    fn leaves_much(&self) -> bool {
        false
    }

    fn shift_springs(&mut self, on: Particles<'_>, shifting: Shifting) {
        let Self { lattice, shifts, is_shifted, compliance, shear_compliance, .. } = self;
        if !*is_shifted {
            // What they are made of is noted in the next tick.
            *is_shifted = shifting.grows();
            return;
        }
        let most = on.bands.most();
        let (threads, shear) = (Some(*compliance), shear_compliance.take());
        let compliances = [threads, threads, shear, shear];
        for ((lines, springs), compliance) in
            shifts.0.iter_mut().zip(LineSprings::of(lattice)).zip(compliances)
        {
            match compliance {
                Some(compliance) => {
                    let x = &on.state.x;
                    parallel::run(on.isa, lines.shift(springs, shifting, compliance, x, most));
                }
                // What a pass over the cells did is as it should be.
                None => lines.clear(),
            }
        }
    }

    fn shifts(&self) -> Vec<f32> {
        if self.is_shifted { self.shifts.kept() } else { Vec::new() }
    }

    fn set_shifts(&mut self, by: &[f32]) {
        let were_shifted = self.is_shifted;
        self.is_shifted = !by.is_empty() && self.shifts.put_back(&self.lattice, by);
        if were_shifted && !self.is_shifted {
            self.shifts.clear();
        }
    }

    fn exceeds_limit(&mut self, on: Particles<'_>, limit: Limit, since: Since) -> bool {
        let State { x, d, .. } = on.state;
        let (band, lattice) = (on.bands.rows.clone(), &*self.lattice);
        let limit = Limit { longest: limit.longest + since.leaves(), ..limit };
        let blocks = &mut self.workspace.beyond;
        let (beyond, only) = blocks.begin_look(since);
        let look = ExceedsLimit { band, lattice, limit, x, d, beyond, only };
        let exceeds = parallel::run(on.isa, look);
        if exceeds {
            blocks.spread();
        }
        exceeds
    }

    /// A look before the pass is cheaper than one in it, and tells.
    fn correct_springs(&mut self, on: Particles<'_>, rule: Rule) -> bool {
        let State { x, d, contacts, .. } = on.state;
        let springs = CorrectSprings {
            band: on.bands.rows.clone(),
            lattice: &self.lattice,
            inverse_mass: &on.pins.inverse_mass,
            x,
            d,
            rule,
            beyond: &self.workspace.beyond,
            contacts: contacts.contacts(),
        };
        springs.run(on.isa);
        true
    }

    fn end_corrections(&mut self, _: Particles<'_>) {}

    fn survey(&self, isa: Isa, bands: &Bands, state: &State) -> Survey {
        let lattice = Some(&*self.lattice);
        parallel::run(isa, TakeSurvey::new(bands.rows.clone(), lattice, state))
    }
}
