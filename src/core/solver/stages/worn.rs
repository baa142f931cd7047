//! The end of a worn cloth's tick: it is within its strain limit, outside of its body and within the bounds of its skin.
//!
//! Between a body that moves and bounds that move with it, contact stretches what the limit has just held, and the limit moves it back
//! into the body. Half-spaces, balls and limits are convex: to hold to each in turn ends where all hold, if that is anywhere. The skin is
//! last, then the body. Within a tick the next substep goes on where one ended; what is drawn is at the end of one.

use crate::solver::ClothSolver;
use crate::solver::constraints::strain_check::Since;
use crate::solver::input::StepInput;
use crate::solver::simd::soa::Soa;
use crate::solver::stages::correct::PASSES_AT_END;

impl ClothSolver {
    /// Ends the last substep of a tick of a worn cloth, in which contact may have moved particles or not.
    pub(crate) fn end_worn(&mut self, input: &StepInput<'_>, meets: bool) {
        let Some(skin) = &mut self.skin else { return };
        if self.done + 1 < self.plan.substeps {
            return;
        }
        let mut from = core::mem::take(&mut skin.after_contact);
        // Without contact, the skin has held last.
        if meets {
            from.copy_from(&self.state.d);
            self.end_within_skin();
        }
        if self.can_end_within_limit() {
            self.hold_in_turn(input, &from);
        }
        if let Some(skin) = &mut self.skin {
            skin.after_contact = from;
        }
    }

    /// Holds springs to their limit, then particles out of the body, then to the skin, until all hold. `from` is how contact displaced
    /// them.
    fn hold_in_turn(&mut self, input: &StepInput<'_>, from: &Soa) {
        let isa = self.isa;
        for round in 0..self.settings.provot_passes * PASSES_AT_END {
            let since = if round == 0 { Since::Never } else { Since::Round };
            if !self.may_exceed_limit(since) {
                return;
            }
            self.contacts(input).begin_pass();
            self.note_pulls(1.0);
            let is_beyond = self.hold_springs();
            self.note_pulls(-1.0);
            let mut contacts = self.contacts(input);
            contacts.end_pass(isa);
            if is_beyond {
                contacts.hold_out(isa, from);
            }
            self.end_within_skin();
            if !is_beyond {
                return;
            }
        }
    }
}
