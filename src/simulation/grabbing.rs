//! Grabs come, are dragged, and let go.

use bevy::prelude::*;

use crate::cloth::grab::ClothGrab;
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::simulation::ClothSimulation;
use crate::simulation::grabbed::Grabbed;
use crate::simulation::holding::hold_anew;

/// Grabs, drags and lets go.
pub(crate) fn apply_grabs(
    mut cloths: Query<(Entity, Option<&ClothGrab>, &mut ClothSimulation)>,
    mut failures: Failures,
) {
    for (entity, grab, mut cloth) in &mut cloths {
        let Some(&grab) = grab else {
            if cloth.held.grab.is_some() {
                let_go(&mut cloth);
            }
            failures.clear(entity, Blame::Grab);
            continue;
        };
        // What is being hung has no hands on it.
        if cloth.progress.tick_count == 0 && cloth.start.hanging.is_some() {
            continue;
        }
        if let Some(running) = &mut cloth.held.grab
            && running.asked.hold == grab.hold
            && grab.validate().is_ok()
        {
            let before = core::mem::replace(&mut running.asked, grab);
            if !before.pulls_as(&grab) {
                hold_anew(&mut cloth);
            } else if before.target != grab.target {
                cloth.sleep.disturb();
            }
            failures.clear(entity, Blame::Grab);
            continue;
        }
        match Grabbed::new(grab, &cloth.solver) {
            Ok(grabbed) => {
                cloth.held.grab = Some(Box::new(grabbed));
                hold_anew(&mut cloth);
                failures.clear(entity, Blame::Grab);
            }
            Err(problem) => {
                if cloth.held.grab.is_some() {
                    let_go(&mut cloth);
                }
                failures.report(entity, ClothErrorKind::Grab(problem));
            }
        }
    }
}

fn let_go(cloth: &mut ClothSimulation) {
    cloth.held.grab = None;
    hold_anew(cloth);
}
