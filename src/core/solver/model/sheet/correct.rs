//! A sheet's corrections: shear cell by cell or diagonal by diagonal, weft threads row by row, warp threads column by column.

use crate::solver::constraints::shear::{Cells, CorrectShear, ShearRule};
use crate::solver::constraints::threads::Lines;
use crate::solver::constraints::threads::bias::{
    Bias, LoadsBack, PutDiagonalsBack, ShearLaw, SolveBias, SolveBiasApart,
};
use crate::solver::constraints::threads::tridiagonal::Reach;
use crate::solver::constraints::threads::warp::{PutBack, SolveWarp, SolveWarpApart};
use crate::solver::constraints::threads::weft::SolveWeft;
use crate::solver::model::Particles;
use crate::solver::model::sheet::{Sheet, SheetWorkspace};
use crate::solver::simd::parallel::{self, Bands};
use crate::solver::simd::soa::ValuesMut;
use crate::solver::state::State;

impl Sheet {
    /// Corrects the shear springs, both diagonals of a cell together.
    pub(super) fn correct_cells(&mut self, on: Particles<'_>, compliance: f32, limit: f32) {
        let Self { lattice, workspace, .. } = self;
        let SheetWorkspace { seams, row_pulls, .. } = workspace;
        let band = &on.bands.rows;
        let State { x, d, contacts, .. } = on.state;
        if band.count() > 1 {
            seams.copy(d);
        }
        let contacts = contacts.contacts();
        let cells = Cells {
            normals: contacts.as_ref().map(|contacts| contacts.normals),
            lattice,
            inverse_mass: &on.pins.inverse_mass,
            rule: ShearRule { compliance, limit, crowd: lattice.crowd },
            x,
        };
        let shear = CorrectShear {
            band: band.clone(),
            cells,
            d: d.part_mut(),
            contacts,
            seams,
            rooms: row_pulls,
        };
        parallel::run(on.isa, shear);
    }

    /// Solves the shear springs along the diagonals of the sheet, those that go one way after those that go the other.
    pub(super) fn solve_bias(&mut self, on: Particles<'_>, law: ShearLaw, ends_tick: bool) {
        let Self { lattice, diagonals, shifts, is_shifted, workspace, .. } = self;
        let SheetWorkspace { threads: rooms, apart, load_apart, .. } = workspace;
        let State { x, d, contacts, .. } = on.state;
        for (place, diagonals) in diagonals.iter().enumerate() {
            let shifts = is_shifted.then(|| shifts.0[2 + place].in_solve(ends_tick));
            let bias = Bias { lattice, diagonals, law, inverse_mass: &on.pins.inverse_mass, x };
            if on.bands.columns.count() == 1 {
                let line = &mut rooms.take().line;
                let contacts = contacts.contacts();
                on.isa.run(SolveBias { bias, d: d.part_mut(), contacts, line, shifts });
                continue;
            }
            let touches = contacts.now.any;
            let solve = SolveBiasApart {
                bias,
                bundles: 0..diagonals.bundles.len(),
                least: diagonals.bundles.len().div_ceil(on.bands.most()),
                d,
                apart: apart.part_mut(),
                contacts: touches
                    .then(|| (&contacts.now, &contacts.load, ValuesMut::all(load_apart))),
                shifts,
                rooms,
            };
            parallel::run(on.isa, solve);
            let put_back = PutDiagonalsBack {
                band: on.bands.rows.clone(),
                diagonals,
                apart,
                d: d.part_mut(),
                loads: contacts
                    .contacts()
                    .map(|contacts| LoadsBack { apart: load_apart, to: contacts.load }),
            };
            parallel::run(on.isa, put_back);
        }
    }

    pub(super) fn solve_weft(
        &mut self,
        on: &mut Particles<'_>,
        reach: Reach,
        ends_tick: bool,
    ) -> bool {
        let State { x, d, contacts, .. } = &mut *on.state;
        let weft = SolveWeft {
            band: on.bands.rows.clone(),
            lines: self.lattice.layout.transposed(),
            springs: &self.lattice.weft_transposed,
            inverse_mass: &on.pins.inverse_mass_transposed,
            reach,
            x,
            d: d.part_mut(),
            contacts: contacts.contacts(),
            shifts: self.is_shifted.then(|| self.shifts.0[0].in_solve(ends_tick)),
            rooms: &self.workspace.threads,
        };
        parallel::run(on.isa, weft)
    }

    pub(super) fn solve_warp(
        &mut self,
        on: &mut Particles<'_>,
        reach: Reach,
        ends_tick: bool,
    ) -> bool {
        let Bands { rows, columns, .. } = on.bands;
        let State { x, d, contacts, .. } = &mut *on.state;
        let SheetWorkspace { threads: rooms, apart, load_apart, .. } = &mut self.workspace;
        let (layout, springs) = (self.lattice.layout, &self.lattice.warp);
        let shifts = self.is_shifted.then(|| self.shifts.0[1].in_solve(ends_tick));
        let inverse_mass = &on.pins.inverse_mass;
        if columns.count() == 1 {
            let line = &mut rooms.take().line;
            let lines = Lines { layout, springs, reach, inverse_mass, line, shifts };
            let contacts = contacts.contacts();
            return on.isa.run(SolveWarp { layout, lines, x, d, contacts });
        }
        let touches = contacts.now.any;
        let warp = SolveWarpApart {
            band: columns.clone(),
            layout,
            springs,
            inverse_mass,
            reach,
            x,
            d,
            apart: apart.part_mut(),
            contacts: touches.then(|| (&contacts.now, &contacts.load, ValuesMut::all(load_apart))),
            shifts,
            rooms,
        };
        let beyond = parallel::run(on.isa, warp);
        let loads = contacts.contacts().map(|contacts| (&*load_apart, contacts.load));
        parallel::run(on.isa, PutBack { band: rows.clone(), apart, d: d.part_mut(), loads });
        beyond
    }
}
