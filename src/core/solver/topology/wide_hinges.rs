//! How wide the hinges are that friction of bending acts on.

/// Particles from the middle of a hinge to its ends: of the narrowest, and how many times as many of the next.
const NARROWEST: usize = 2;
const WIDER: usize = 4;

/// Particles from the middle of a hinge to its ends, on threads of so many particles.
pub(crate) fn widths(particles: usize) -> impl Iterator<Item = usize> {
    let narrowest = if particles > 2 * NARROWEST { NARROWEST } else { 1 };
    let wider = |width: &usize| Some(width * WIDER);
    core::iter::successors(Some(narrowest), wider).take_while(move |width| 2 * width < particles)
}
