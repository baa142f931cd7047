//! Moving a whole cloth rigidly: what teleports, rides along with its entity, or goes back to its rest
//! shape has its positions and velocities turned and shifted, and no velocity made.

use bevy_math::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};

use crate::solver::ClothSolver;
use crate::solver::contact::Pose;
use crate::solver::error::SolverError;
use crate::solver::settings::is_near;
use crate::solver::simd::block::Block3;
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;
use crate::solver::state::carrying::Carrying;
use crate::solver::state::striking::Striking;

/// A rotation about a point, then a shift.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct RigidMotion {
    /// The point that is only shifted, in world space \[m\].
    pub pivot: Vec3,
    /// Rotation, of length one.
    pub rotation: Quat,
    /// Shift of the pivot \[m\].
    pub shift: Vec3,
}

impl RigidMotion {
    /// The motion that takes one pose to another; their scales are left out.
    pub fn between(from: &Pose, to: &Pose) -> Self {
        let rotation = if from.rotation == to.rotation {
            Quat::IDENTITY
        } else {
            (to.rotation * from.rotation.inverse()).normalize()
        };
        Self { pivot: from.translation, rotation, shift: to.translation - from.translation }
    }

    /// Part of the motion: of its shift, and of its rotation. From 0, nothing, to 1, all of it.
    pub fn part(&self, shift: f32, rotation: f32) -> Self {
        let whole = Pose { rotation: self.rotation, ..Pose::IDENTITY };
        let rotation = Pose::IDENTITY.interpolate(&whole, rotation).rotation;
        Self { rotation, shift: self.shift * shift, ..*self }
    }

    /// Whether it moves nothing.
    pub fn is_none(&self) -> bool {
        self.shift == Vec3::ZERO && self.rotation == Quat::IDENTITY
    }

    /// Whether every number can be used.
    pub fn is_valid(&self) -> bool {
        is_near(self.pivot)
            && is_near(self.shift)
            && (self.rotation.length_squared() - 1.0).abs() < 1e-3
    }

    /// Where it takes a point \[m\].
    pub fn apply(&self, point: Vec3) -> Vec3 {
        self.pivot + self.shift + self.rotation * (point - self.pivot)
    }

    /// Where it takes a pose.
    pub fn apply_to_pose(&self, pose: &Pose) -> Pose {
        Pose {
            translation: self.apply(pose.translation),
            rotation: (self.rotation * pose.rotation).normalize(),
            scale: pose.scale,
        }
    }

    /// The motion that undoes it.
    pub fn inverse(&self) -> Self {
        Self {
            pivot: self.pivot + self.shift,
            rotation: self.rotation.inverse(),
            shift: -self.shift,
        }
    }
}

impl ClothSolver {
    /// Carries the cloth rigidly from one pose to another, as a teleport does: all positions, and what
    /// was drawn before, are turned and shifted, velocities are turned. Pins are carried too; where
    /// they go next is for the next tick's input to say. Scales are left out.
    ///
    /// A pure translation keeps every bit of the shape where it is a multiple of 1/16 m, and all but
    /// the last bits where it is not.
    ///
    /// # Errors
    /// [`SolverError::Motion`] for a pose that is not finite, or leads beyond 1e7 m; nothing is moved
    /// then.
    pub fn carry(&mut self, from: &Pose, to: &Pose) -> Result<(), SolverError> {
        if !(from.is_valid() && to.is_valid()) {
            return Err(SolverError::Motion);
        }
        let place = self.carried_by(&RigidMotion::between(from, to))?;
        self.isa.run(place.of(self.topology.layout(), &mut self.state.start, false));
        self.settle_at(place);
        Ok(())
    }

    /// Carries the cloth rigidly, as [`ClothSolver::carry`], but as a part of the last tick's motion:
    /// where it was when that tick began stays what it was.
    ///
    /// # Errors
    /// As [`ClothSolver::carry`].
    pub fn ride(&mut self, motion: &RigidMotion) -> Result<(), SolverError> {
        let place = self.carried_by(motion)?;
        let shift = place.origin - self.state.origin;
        let start = Placement { turn: None, shift: -shift, ..place };
        self.isa.run(start.of(self.topology.layout(), &mut self.state.start, false));
        self.settle_at(place);
        Ok(())
    }

    /// Puts the cloth back to its rest shape in this pose, at rest. The pose's scale is left out, as
    /// the rest shape already has its size.
    ///
    /// # Errors
    /// [`SolverError::Motion`] for a pose that cannot be used; the cloth stays as it is then.
    pub fn reset(&mut self, pose: &Pose) -> Result<(), SolverError> {
        let place = |rest: Vec3| pose.rotation * rest + pose.translation;
        let rest = self.topology.rest_positions();
        if !pose.is_valid() || !rest.iter().all(|&p| is_near(place(p))) {
            return Err(SolverError::Motion);
        }
        // The origin follows at the next tick.
        for (particle, &p) in rest.iter().enumerate() {
            let near = pose.rotation * p + (pose.translation - self.state.origin);
            self.state.x.set(self.topology.slot(particle), near);
        }
        self.come_to_rest();
        Ok(())
    }

    /// Puts all particles elsewhere, at rest \[m\]: as a cloth that is new.
    ///
    /// # Errors
    /// [`SolverError::WrongPositionCount`] or [`SolverError::NonFinite`]; nothing is moved then.
    pub fn place(&mut self, positions: &[Vec3]) -> Result<(), SolverError> {
        self.check_places(positions)?;
        for (particle, &p) in positions.iter().enumerate() {
            self.state.x.set(self.topology.slot(particle), p - self.state.origin);
        }
        self.come_to_rest();
        Ok(())
    }

    /// Puts all particles where those of another solver of the same cloth are, at rest. Springs that bore a load there go on to bear it.
    ///
    /// # Errors
    /// [`SolverError::OtherParticles`] for a solver of other particles, and as [`ClothSolver::place`]; nothing is moved then.
    pub fn place_as(&mut self, other: &Self) -> Result<(), SolverError> {
        let count = other.topology.particle_count();
        if count != self.topology.particle_count()
            || other.topology.layout() != self.topology.layout()
        {
            return Err(SolverError::OtherParticles);
        }
        let positions: Vec<_> = (0..count).map(|particle| other.position(particle)).collect();
        self.place(&positions)?;
        self.model.stages_mut().set_shifts(&other.model.stages().shifts());
        if other.state.carries {
            self.state.pull.copy_from(&other.state.pull);
            self.state.last_step = other.state.last_step;
            self.state.carries = true;
        }
        Ok(())
    }

    /// Says where all particles were at the start of the last tick \[m\]: what is drawn between two ticks begins there.
    ///
    /// # Errors
    /// As [`ClothSolver::place`].
    pub fn come_from(&mut self, positions: &[Vec3]) -> Result<(), SolverError> {
        self.check_places(positions)?;
        for (particle, &p) in positions.iter().enumerate() {
            self.state.start.set(self.topology.slot(particle), p - self.state.origin);
        }
        self.survey_anew();
        Ok(())
    }

    fn check_places(&self, positions: &[Vec3]) -> Result<(), SolverError> {
        let expected = self.topology.particle_count();
        if positions.len() != expected {
            return Err(SolverError::WrongPositionCount { expected, got: positions.len() });
        }
        match positions.iter().position(|&p| !is_near(p)) {
            Some(particle) => Err(SolverError::NonFinite { what: "position", particle }),
            None => Ok(()),
        }
    }

    /// Stops all particles where they are. Springs that bear a load there go on to bear it.
    pub(crate) fn stop(&mut self) {
        self.forget_pairs();
        self.state.d.clear();
        self.state.contacts.clear();
        if !self.state.carries {
            self.state.last_step = 0.0;
        }
        self.stand_still();
    }

    /// Forgets all velocities, and what led to them.
    pub(crate) fn come_to_rest(&mut self) {
        self.stop_filtering();
        self.model.stages_mut().set_shifts(&[]);
        self.state.carrying = Carrying::NOTHING;
        self.state.striking = Striking::NONE;
        self.scale_mass();
        self.stop();
    }

    /// Says that the cloth does not move at present, as no tick is taken: what is drawn between two
    /// ticks is where it is. Its velocities are kept for the next tick.
    pub fn stand_still(&mut self) {
        self.state.start.copy_from(&self.state.x);
        self.survey_anew();
    }

    /// The motion of positions relative to the origin; an error where it cannot be used.
    fn carried_by(&self, motion: &RigidMotion) -> Result<Placement, SolverError> {
        let origin = self.state.origin;
        let survey = self.survey();
        let centre = (survey.min + survey.max) * 0.5;
        let there = motion.apply(origin + centre);
        if !motion.is_valid() || !is_near(there) {
            return Err(SolverError::Motion);
        }
        if motion.rotation == Quat::IDENTITY {
            let new_origin = origin + on_fine_grid(motion.shift);
            let shift = motion.shift - (new_origin - origin);
            return Ok(Placement { origin: new_origin, centre, turn: None, shift });
        }
        // About the cloth's own middle, which a pivot far away only shifts: in f64, as the pivot's
        // lever may be long.
        let turn = DQuat::from_xyzw(
            f64::from(motion.rotation.x),
            f64::from(motion.rotation.y),
            f64::from(motion.rotation.z),
            f64::from(motion.rotation.w),
        );
        let turn = DMat3::from_quat(turn.normalize());
        let lever = origin.as_dvec3() + centre.as_dvec3() - motion.pivot.as_dvec3();
        let way: DVec3 = motion.shift.as_dvec3() + turn * lever - lever;
        let new_origin = origin + on_fine_grid(way.as_vec3());
        let left = way - (new_origin.as_dvec3() - origin.as_dvec3());
        Ok(Placement {
            origin: new_origin,
            centre,
            turn: Some(turn.as_mat3()),
            shift: left.as_vec3(),
        })
    }

    /// Puts positions and velocities where they are carried to.
    fn settle_at(&mut self, place: Placement) {
        self.ride_pairs(place.turn);
        let layout = self.topology.layout();
        self.isa.run(place.of(layout, &mut self.state.x, false));
        self.isa.run(place.of(layout, &mut self.state.d, true));
        self.isa.run(place.of(layout, &mut self.state.pull, true));
        if self.state.contacts.now.any {
            self.isa.run(place.of(layout, &mut self.state.contacts.velocity, true));
        }
        for normals in [&mut self.state.contacts.now, &mut self.state.contacts.before] {
            if normals.any {
                self.isa.run(place.of(layout, &mut normals.normal, true));
            }
        }
        if let Some(turn) = place.turn {
            self.state.contacts.impulses.turn(turn);
            self.state.contacts.edges.turn(turn);
        }
        self.state.origin = place.origin;
        self.survey_anew();
    }
}

/// Origins move by multiples of this when a cloth is carried: the shape keeps its bits then.
fn on_fine_grid(p: Vec3) -> Vec3 {
    const GRID: f32 = 1.0 / 16.0;
    (p / GRID).round() * GRID
}

/// A rigid motion in the cloth's own coordinates.
#[derive(Clone, Copy)]
struct Placement {
    /// The new origin, in world space \[m\].
    origin: Vec3,
    /// Centre of the turn, relative to the origin \[m\].
    centre: Vec3,
    /// The rotation; `None` leaves every bit.
    turn: Option<Mat3>,
    /// Shift that is left once the origin has moved \[m\].
    shift: Vec3,
}

impl Placement {
    /// The kernel that does it to positions, or to vectors.
    fn of(self, layout: Layout, to: &mut Soa, vectors: bool) -> Place<'_> {
        let place =
            if vectors { Self { centre: Vec3::ZERO, shift: Vec3::ZERO, ..self } } else { self };
        Place { layout, place, to }
    }
}

/// Turns and shifts vectors.
struct Place<'a> {
    layout: Layout,
    place: Placement,
    to: &'a mut Soa,
}

impl Kernel for Place<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Placement { centre, turn, shift, .. } = self.place;
        for row in 0..self.layout.rows {
            for column in (0..self.layout.columns).step_by(LANES) {
                let slot = self.layout.slot(row, column);
                let inside = self.layout.inside(row, column);
                let mut v = Block3::load(self.to, slot);
                for i in 0..LANES {
                    let p = v.at(i);
                    let moved = match turn {
                        Some(r) => {
                            let q = p - centre;
                            r.x_axis * q.x + r.y_axis * q.y + r.z_axis * q.z + centre + shift
                        }
                        None => p + shift,
                    };
                    // Padding stays at zero.
                    v.set(i, if i < inside { moved } else { p });
                }
                v.store(self.to, slot);
            }
        }
    }
}
