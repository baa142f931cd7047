//! Whole games: anything is done to entities in any order. Truth: nothing panics, what runs and what is drawn stays a number, what does
//! not run says why, a cloth far away has the bits that it has alone, and all have the same bits in both forms of the step and at other
//! frame rates.

mod play;
mod script;

use proptest::{prelude::*, test_runner::TestCaseResult};

use super::hold;
use play::Game;
use script::{Frame, script};

fn play(frames: &[Frame]) -> TestCaseResult {
    let mut game = Game::new();
    let mut alone = Game::new();
    for frame in frames {
        game.do_all(&frame.deeds);
        game.frame(frame.ticks);
        alone.frame(frame.ticks);
        game.check()?;
        let bits = game.witness_bits();
        prop_assert!(!bits.is_empty(), "the cloth far away does not run");
        prop_assert_eq!(bits, alone.witness_bits());
    }
    game.start_anew()?;
    game.heal()
}

/// Plays a game in both forms of the step, and in twice as many frames.
fn play_alike(frames: &[Frame]) -> TestCaseResult {
    let mut game = Game::new();
    let mut others = [Game::new(), Game::new()];
    others[0].stage();
    for (i, frame) in frames.iter().enumerate() {
        game.do_all(&frame.deeds);
        game.frame(frame.ticks);
        let bits = game.all_bits();
        for (which, other) in others.iter_mut().enumerate() {
            other.do_all(&frame.deeds);
            if which == 1 {
                other.frame(0);
            }
            other.frame(frame.ticks);
            for (slot, (mine, theirs)) in bits.iter().zip(other.all_bits()).enumerate() {
                prop_assert!(*mine == theirs, "cloth {slot}, {which} in frame {i}");
            }
        }
    }
    Ok(())
}

#[test]
fn no_game_panics_or_disturbs_what_is_far_away() {
    hold(150, &script(), |frames| play(&frames));
}

#[test]
fn the_same_game_has_the_same_bits() {
    let in_ticks = |frames: Vec<Frame>| frames.into_iter().map(Frame::in_ticks).collect::<Vec<_>>();
    hold(80, &script().prop_map(in_ticks), |frames| play_alike(&frames));
}
