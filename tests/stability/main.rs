//! Hard cases: what no scene asks for on purpose, and every game does by accident. Each is a test of its own
//! name, on a lattice and on a mesh, at the automatic setting and at the stiffest that is accepted, for the
//! seconds in which it moves. Every tick is looked at.
//!
//! Truths: all is finite; nothing is beyond what its pins let it reach, or its fall; strain is back under
//! twice its limit within a stated number of frames, and stays there; what another cloth goes through
//! changes no bit of the rest. `-- --nocapture` prints what each came to.
//!
//! | case | what happens to the cloth | whose scene or idea | file |
//! | --- | --- | --- | --- |
//! | `h01` | all particles scrambled over a sphere | Chen et al. 2024, *Vertex Block Descent* (VBD), section 5.3 | `starts` |
//! | `h02` | flattened onto a line | VBD, section 5.3 | `starts` |
//! | `h03` | all particles at one point | beyond `h02` | `starts` |
//! | `h04` | one substep a frame, stretched five times | VBD, figure 16 | `starts` |
//! | `h05` | ten particles pulled slowly, and let go | VBD, figure 15 | `pulled` |
//! | `h06` | masses of 1 to 100,000 | Macklin et al. 2019, *Small Steps*, section 6.1 | `masses` |
//! | `h07` | ten million newton a metre | *Small Steps*, figure 5 | `masses` |
//! | `h08` | stiffnesses of 1 to 10,000 | VBD, figure 24 | `masses` |
//! | `h09` | hardly any stiffness, hardly any mass | a report to Godot (116058) | `masses` |
//! | `h10` | any frame rate, and hitches of seconds | games | `frames` |
//! | `h11` | a collider that appears, vanishes, shrinks to nothing | *Small Steps*, section 4.3 | `fast_colliders`, `teleports` |
//! | `h12` | a ball of 250 m/s | Jolt, `SoftBodyVsFastMovingTest` | `fast_colliders` |
//! | `h13` | 100 x 100 particles with 121 loads | Jolt, `SoftBodyStressTest` | `masses` |
//! | `h14` | meshes that are hardly one | assets | `outside` |
//! | `h15` | a world whose numbers are none | games | `outside` |
//! | `h16` | gravity none, a hundred times, turned round | Newton, `test_cloth` | `gravity` |
//! | `h17` | ten minutes at rest | this project | `tests/long`, `rest` |
//! | `h18` | ten kilometres from the origin | games | `far` |
//! | `h19` | wrung, drawn through a ring, pulled off a table | Harmon et al. 2008, *Robust Treatment of Simultaneous Collisions* | `handled` |
//! | `h20` | pins beyond reach, led away, everywhere, nowhere | Provot 1995, whose correction then has no solution | `pinned` |
//! | `h21` | settings at their limits | this project | `extremes` |
//! | `h22` | a cloth through the middle of a solid, where no way out is the nearest | distance fields | `medial` |
//! | `h23` | between solids that leave no room | this project | `squeezed` |
//! | `h24` | one and eight threads | this project | `pool` |
//! | - | what is thin or sharp; rest on solids | this project | `thin`, `lying` |
//! | - | meshes in heaps | this project | `crumpled` |
//! | - | sleep on solids; a minute without damping | this project | `tests/long`, `asleep`, `energy` |

mod app;
mod crumpled;
mod extremes;
mod falling;
mod far;
mod fast_colliders;
mod frames;
mod gravity;
mod handled;
mod lying;
mod masses;
mod medial;
mod outside;
mod pinned;
mod pool;
mod pulled;
mod squeezed;
mod starts;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
mod teleports;
mod thin;
mod trial;
