//! A pass where springs are beyond their limit does what one over all does, and a look where it came finds what one at all finds.

use super::*;
use crate::solver::constraints::strain_check::{ExceedsLimit, Since};
use crate::solver::settings::MassLumping;
use bevy_math::{Vec2, Vec3};

/// A sheet all of whose springs are at their limit but for rounding, so that whatever is moved takes what is around along; pulled at
/// its seventh row and its last corner.
struct Pulled {
    lattice: Lattice,
    inverse_mass: Vec<f32>,
    x: Soa,
    d: Soa,
    limit: Limit,
    beyond: Beyond,
}

impl Pulled {
    fn new(shear: bool) -> Self {
        let lattice = Lattice::sheet(Vec2::ONE, 45, 50, MassLumping::Lumped).unwrap();
        let layout = lattice.layout;
        let (mut x, mut d) = (Soa::zeros(layout.len()), Soa::zeros(layout.len()));
        for (slot, place) in layout.slots().zip(lattice.rest_positions()) {
            x.set(slot, *place * 1.099_9);
        }
        d.set(layout.slot(6, 17), Vec3::new(2e-3, 1e-3, 4e-3));
        d.set(layout.slot(44, 49), Vec3::new(-3e-3, 0.0, 2e-3));
        let inverse_mass = vec![1.0; layout.len()];
        let limit = Limit { longest: 1.1, shear, all: true };
        Self { lattice, inverse_mass, x, d, limit, beyond: Beyond::new(layout) }
    }

    /// Looks, and tells in which blocks springs are beyond their limit.
    fn look(&mut self, since: Since) -> Vec<bool> {
        let Self { lattice, x, d, limit, beyond, .. } = self;
        let (band, limit) = (Band::uncut(lattice.layout), *limit);
        let (found, only) = beyond.begin_look(since);
        let look = ExceedsLimit { band, lattice, limit, x, d, beyond: found, only };
        let any = parallel::run(Isa::Baseline, look);
        let (mut found, _) = beyond.begin_look(since);
        let found = found.row(0, lattice.layout.len() / LANES).to_vec();
        assert_eq!(any, found.contains(&true));
        found
    }

    /// Corrects around what was found.
    fn pass(&mut self) {
        self.beyond.spread();
        let correct = CorrectSprings {
            band: Band::uncut(self.lattice.layout),
            lattice: &self.lattice,
            inverse_mass: &self.inverse_mass,
            x: &self.x,
            d: &mut self.d,
            rule: Rule::Limit(self.limit),
            beyond: &self.beyond,
            contacts: None,
        };
        correct.run(Isa::Baseline);
    }

    /// Corrects everywhere.
    fn pass_over_all(&mut self) {
        let (mut found, _) = self.beyond.begin_look(Since::Never);
        found.row(0, self.lattice.layout.len() / LANES).fill(true);
        self.pass();
    }
}

#[test]
fn a_pass_around_what_is_beyond_does_what_one_over_all_does() {
    for shear in [false, true] {
        let [mut around, mut over_all] = [Pulled::new(shear), Pulled::new(shear)];
        around.look(Since::Never);
        around.pass();
        over_all.pass_over_all();
        assert!(around.d == over_all.d, "shear limited: {shear}");
    }
}

#[test]
fn a_look_around_a_pass_finds_what_one_at_all_does() {
    for shear in [false, true] {
        let mut sheet = Pulled::new(shear);
        let mut found = sheet.look(Since::Never);
        for pass in 0..12 {
            sheet.pass();
            let around = sheet.look(Since::Pass);
            let reached = sheet.beyond.clone();
            assert_eq!(around, sheet.look(Since::Never), "shear limited: {shear}, {pass}");
            assert_ne!(around, found, "nothing spreads");
            (found, sheet.beyond) = (around, reached);
        }
    }
}
