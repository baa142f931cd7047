//! The material of a cloth and the settings of its solver, as plain numbers in SI units.

use bevy_math::Vec3;

/// The material of a cloth. All numbers are of the cloth, not of its springs: a finer sheet of the same material
/// behaves the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Mass per area \[kg/m2\]. Higher is heavier.
    pub area_density: f32,
    /// Resistance of the threads to stretching \[N/m\]. Higher is stiffer and costs more substeps.
    pub thread_stiffness: f32,
    /// Resistance to shearing, a square turning into a rhombus \[N/m\]. Higher is stiffer.
    pub shear_stiffness: f32,
    /// Resistance to bending \[N m\]. Higher makes wider folds.
    pub flexural_rigidity: f32,
    /// Moment for each metre of width with which friction between the yarns resists a change of curvature, half of
    /// Kawabata's hysteresis of bending 2HB \[N\]. Higher comes to rest sooner.
    pub bending_friction: f32,
    /// Damping constant of a spring in a square cell \[N s/m\]. Higher stops ripples sooner.
    pub damping: f32,
    /// Which relative velocity the damping acts on.
    pub damping_form: DampingForm,
    /// Rate at which still air stops the cloth \[1/s\]. Higher stops it sooner; of no effect on a cloth that is in
    /// [`Air`](crate::solver::Air).
    pub drag: f32,
    /// Provot's critical deformation rate: the strain that corrections do not let a spring exceed \[1\].
    /// Higher stretches more.
    pub max_strain: f32,
    /// Coulomb's coefficient against a collider of the same coefficient \[1\]. Higher slides less.
    pub friction: f32,
    /// Distance at which particles are held from colliders \[m\]. Higher is safer and shows a gap.
    pub thickness: f32,
}

impl Material {
    /// A light cotton that gives: the default.
    pub const USUAL: Self = Self {
        area_density: 0.2,
        thread_stiffness: 2000.0,
        shear_stiffness: 100.0,
        flexural_rigidity: 1e-5,
        bending_friction: 2.3e-4,
        damping: 0.0,
        damping_form: DampingForm::Axial,
        drag: 1.0,
        max_strain: 0.1,
        friction: 0.5,
        thickness: 0.005,
    };
}

impl Default for Material {
    fn default() -> Self {
        Self::USUAL
    }
}

/// Which part of the relative velocity of a spring's ends its damping acts on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum DampingForm {
    /// The part along the spring. Leaves rigid rotation alone.
    #[default]
    Axial,
    /// All of it, `F = -C (v_i - v_j)`: also damps bending, and brakes a spinning cloth.
    Relative,
}

/// How bending is modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum Bending {
    /// Second differences of the positions: linear, converges to the elastica.
    #[default]
    SecondDifference,
    /// Provot's flexion springs between every second particle: no stiffness while flat, as the
    /// energy grows with the fourth power of the curvature.
    Flexion,
}

/// How velocities and positions follow from accelerations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum Integrator {
    /// Verlet's method (1967) in its leapfrog form: of second order, and keeps the energy of what swings.
    #[default]
    Verlet,
    /// Euler's explicit method, for study: of first order, and what swings gains energy without end,
    /// whatever the substep.
    Euler,
    /// The explicit midpoint method (Runge 1895), for study: of second order at twice the forces; what
    /// swings gains energy, slowly.
    Midpoint,
}

/// The method that is asked for, by which a cloth resists stretching.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum StretchMethod {
    /// Springs where the substeps allow the stiffness asked for, and where that carries the cloth's own
    /// weight within its limit of strain; else threads.
    #[default]
    Automatic,
    /// Explicit springs, then Provot's correction.
    ExplicitSprings,
    /// Each thread solved whole, implicitly.
    ImplicitThreads,
}

/// How many substeps a tick takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum Substeps {
    /// As many as the material needs, at most `budget` in 1/60 s. Layers of cloth that touch, and bodies that come to a pinned cloth fast, may need
    /// more ([`Plan::layers`](crate::solver::Plan::layers), [`Plan::bodies`](crate::solver::Plan::bodies)).
    Automatic {
        /// Substeps in 1/60 s; a longer or shorter tick has them in proportion.
        budget: u32,
    },
    /// This many in each tick. What they cannot carry is clamped.
    Fixed(u32),
}

impl Default for Substeps {
    fn default() -> Self {
        Self::Automatic { budget: 20 }
    }
}

/// How a cloth is solved; the defaults suit nearly every scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Substeps in a tick. More are more accurate, carry stiffer springs, and cost in proportion.
    pub substeps: Substeps,
    /// Springs, whole threads, or whichever carries the material.
    pub stretch_method: StretchMethod,
    /// Passes of Provot's correction in a substep. More hold the strain limit closer. Where threads are solved, up to twenty
    /// times as many end a tick in which springs are still beyond it, unless the cloth lies on a collider and is not worn.
    pub provot_passes: u32,
    /// Whether masses and springs of the border count half.
    pub lumping: MassLumping,
    /// Bending model.
    pub bending: Bending,
    /// How the motion is integrated. All but Verlet are there to be compared with it: they are not stable.
    pub integrator: Integrator,
    /// Whether tethers (long-range attachments) keep particles within reach of the pins.
    pub tethers: bool,
    /// Speed that no particle exceeds \[m/s\]. Set it just above the fastest real motion in the scene.
    pub max_speed: f32,
    /// Speed at which particles inside a collider are pushed out \[m/s\]. Higher frees a cloth sooner that began inside
    /// of one.
    pub max_depenetration_speed: f32,
    /// The layers of colliders that it meets, a bit each.
    pub layers: u32,
    /// Whether edges and faces, not only particles, collide with solids that are thin or sharp relative to the particle
    /// spacing.
    pub edges: bool,
}

impl Settings {
    /// The default: up to 20 substeps in 1/60 s, by whichever method carries the material.
    pub const USUAL: Self = Self {
        substeps: Substeps::Automatic { budget: 20 },
        stretch_method: StretchMethod::Automatic,
        provot_passes: 1,
        lumping: MassLumping::Lumped,
        bending: Bending::SecondDifference,
        integrator: Integrator::Verlet,
        tethers: true,
        max_speed: 100.0,
        max_depenetration_speed: 2.0,
        layers: u32::MAX,
        edges: true,
    };
}

impl Default for Settings {
    fn default() -> Self {
        Self::USUAL
    }
}

/// Which number of a [`Material`] or of [`Settings`] cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {value}, but must be {range}")]
pub struct ParameterError {
    /// The field.
    pub name: &'static str,
    /// The number that was given.
    pub value: f32,
    /// The range that is allowed.
    pub range: &'static str,
}

impl Material {
    /// Checks every number.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is not finite or out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let range = "positive and at most 1e4 kg/m2";
        check("area_density", self.area_density, 1e-6, 1e4, range)?;
        let stiffness = "from 0 to 1e15 N/m";
        check("thread_stiffness", self.thread_stiffness, 0.0, 1e15, stiffness)?;
        check("shear_stiffness", self.shear_stiffness, 0.0, 1e15, stiffness)?;
        let range = "from 0 to 1e9 N m";
        check("flexural_rigidity", self.flexural_rigidity, 0.0, 1e9, range)?;
        check("bending_friction", self.bending_friction, 0.0, 1e9, "from 0 to 1e9 N")?;
        check("damping", self.damping, 0.0, 1e9, "from 0 to 1e9 N s/m")?;
        check("drag", self.drag, 0.0, 1e6, "from 0 to 1e6 1/s")?;
        check("max_strain", self.max_strain, 0.0, 10.0, "from 0 to 10")?;
        check("friction", self.friction, 0.0, 1e3, "from 0 to 1000")?;
        check("thickness", self.thickness, 0.0, 10.0, "from 0 to 10 m")
    }
}

impl Settings {
    /// Substeps a tick may have at most.
    pub const MAX_SUBSTEPS: u32 = 4096;

    /// Checks every number.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let (Substeps::Fixed(count) | Substeps::Automatic { budget: count }) = self.substeps;
        let limit = Self::MAX_SUBSTEPS as f32;
        check("substeps", count as f32, 1.0, limit, "from 1 to 4096")?;
        check("provot_passes", self.provot_passes as f32, 0.0, 1000.0, "from 0 to 1000")?;
        let range = "positive and at most 1e5 m/s";
        check("max_speed", self.max_speed, 1e-3, 1e5, range)?;
        check("max_depenetration_speed", self.max_depenetration_speed, 1e-3, 1e5, range)
    }
}

pub(crate) fn check(
    name: &'static str,
    value: f32,
    least: f32,
    most: f32,
    range: &'static str,
) -> Result<(), ParameterError> {
    if value >= least && value <= most {
        Ok(())
    } else {
        Err(ParameterError { name, value, range })
    }
}

/// Whether a sheet's border counts half.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum MassLumping {
    /// Masses lumped by area: border particles a half, corners a quarter; structural and bend
    /// springs along the border half as strong. Converges to second order as the sheet is refined.
    #[default]
    Lumped,
    /// Every particle weighs the same and every spring is whole.
    Equal,
}

/// The method that was chosen, by which a cloth resists stretching.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stretching {
    /// Explicit springs, then Provot's correction.
    ExplicitSprings,
    /// Each thread solved whole, implicitly.
    ImplicitThreads,
}

/// Coordinates and speeds beyond this are refused.
pub(crate) const FARTHEST: f32 = 1e7;

/// Whether a position or velocity can be used.
pub(crate) fn is_near(p: Vec3) -> bool {
    // The largest element alone would pass over one that is NaN.
    p.is_finite() && p.abs().max_element() <= FARTHEST
}
