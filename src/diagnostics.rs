//! Measurements for Bevy's diagnostics, taken only where [`ClothDiagnosticsPlugin`] is.
//!
//! The solver has no clock. Where times are asked for, it is observed as it takes its tick.

use core::time::Duration;

use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::platform::time::Instant;
use bevy::prelude::*;

use crate::plugin::ClothPlugin;
use crate::schedule::ClothSystems;
use crate::simulation::ClothSimulation;
use crate::simulation::stage_times::StageTimes;
use crate::solver::ClothSolver;
use crate::step::in_fixed_step;

/// Measures cloths, for Bevy's `DiagnosticsStore`: the milliseconds of a tick and of its stages, substeps,
/// strain, contacts, crossings, who is awake. Without it nothing is measured.
///
/// Add it beside [`ClothPlugin`]; Bevy's `LogDiagnosticsPlugin` prints what it finds.
///
/// ```
/// # use bevy::{diagnostic::DiagnosticsStore, prelude::*};
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::ClothDiagnosticsPlugin;
/// # let mut app = App::new();
/// app.add_plugins((MinimalPlugins, ClothPlugin::default(), ClothDiagnosticsPlugin));
///
/// fn show(store: Res<DiagnosticsStore>) {
///     let solve = store.get(&ClothDiagnosticsPlugin::SOLVE).and_then(|it| it.smoothed());
///     if let Some(milliseconds) = solve {
///         println!("cloths take {milliseconds:.2} ms a tick");
///     }
/// }
/// # app.add_systems(Update, show);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothDiagnosticsPlugin;

impl ClothDiagnosticsPlugin {
    /// A whole tick, from setting up to the telling of errors \[ms\]. Like all times but those of the
    /// solver's stages it is that on the clock, with whatever else runs meanwhile.
    pub const TICK: DiagnosticPath = DiagnosticPath::const_new("cloth/tick");
    /// Poses, gravity and wind of a tick \[ms\].
    pub const GATHER: DiagnosticPath = DiagnosticPath::const_new("cloth/gather");
    /// The substeps of a tick \[ms\]: on the clock, cloths side by side.
    pub const SOLVE: DiagnosticPath = DiagnosticPath::const_new("cloth/solve");
    /// Writing the meshes of a frame \[ms\].
    pub const DRAW: DiagnosticPath = DiagnosticPath::const_new("cloth/draw");
    /// Part of the solving: springs, bending, damping, air \[ms\]. Like the next three it is the sum over
    /// all cloths, also of those that are solved side by side.
    pub const FORCES: DiagnosticPath = DiagnosticPath::const_new("cloth/solve/forces");
    /// Part of the solving: integration and pins \[ms\].
    pub const INTEGRATE: DiagnosticPath = DiagnosticPath::const_new("cloth/solve/integrate");
    /// Part of the solving: threads, the strain limit, tethers \[ms\].
    pub const CORRECT: DiagnosticPath = DiagnosticPath::const_new("cloth/solve/correct");
    /// Part of the solving: contact and friction \[ms\].
    pub const COLLIDE: DiagnosticPath = DiagnosticPath::const_new("cloth/solve/collide");
    /// Substeps of the cloth that took most in the tick.
    pub const SUBSTEPS: DiagnosticPath = DiagnosticPath::const_new("cloth/substeps");
    /// Largest strain of any thread of the cloths that took the tick.
    pub const STRAIN_MAX: DiagnosticPath = DiagnosticPath::const_new("cloth/strain_max");
    /// Mean strain of all their threads.
    pub const STRAIN_MEAN: DiagnosticPath = DiagnosticPath::const_new("cloth/strain_mean");
    /// Contacts in their last substeps, all together.
    pub const CONTACTS: DiagnosticPath = DiagnosticPath::const_new("cloth/contacts");
    /// Pairs of particles of one cloth that touched in the last substeps of those that collide with themselves
    /// ([`ClothSelfCollision`](crate::ClothSelfCollision)), all together.
    pub const SELF_CONTACTS: DiagnosticPath = DiagnosticPath::const_new("cloth/self_contacts");
    /// Pairs of particles of two cloths that touched in the last substeps of those that collide with others
    /// ([`ClothInterCollision`](crate::ClothInterCollision)), each counted by both.
    pub const INTER_CONTACTS: DiagnosticPath = DiagnosticPath::const_new("cloth/inter_contacts");
    /// Times that an edge of a cloth that collides with itself pierces a face of its own, or one that collides with others a face of
    /// these, all together. Counted once a second, which
    /// takes milliseconds a cloth, and only while its `Diagnostic` is enabled.
    pub const CROSSINGS: DiagnosticPath = DiagnosticPath::const_new("cloth/crossings");
    /// Cloths that took the tick.
    pub const AWAKE: DiagnosticPath = DiagnosticPath::const_new("cloth/awake");
    /// Cloths that sleep.
    pub const ASLEEP: DiagnosticPath = DiagnosticPath::const_new("cloth/asleep");

    /// The stages of a substep, in the order of [`ClothSubstepSystems`].
    const STAGES: [DiagnosticPath; 4] =
        [Self::FORCES, Self::INTEGRATE, Self::CORRECT, Self::COLLIDE];
    /// All that is in milliseconds.
    const TIMES: [DiagnosticPath; 4] = [Self::TICK, Self::GATHER, Self::SOLVE, Self::DRAW];
    /// All that is counted or compared.
    const NUMBERS: [DiagnosticPath; 9] = [
        Self::SUBSTEPS,
        Self::STRAIN_MAX,
        Self::STRAIN_MEAN,
        Self::CONTACTS,
        Self::SELF_CONTACTS,
        Self::INTER_CONTACTS,
        Self::CROSSINGS,
        Self::AWAKE,
        Self::ASLEEP,
    ];
}

impl Plugin for ClothDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        app.register_required_components::<ClothSimulation, StageTimes>()
            .init_resource::<Marks>()
            .add_observer(forget_times);
        for path in Self::TIMES.into_iter().chain(Self::STAGES) {
            app.register_diagnostic(Diagnostic::new(path).with_suffix("ms"));
        }
        for path in Self::NUMBERS {
            app.register_diagnostic(Diagnostic::new(path).with_smoothing_factor(0.0));
        }
    }

    fn finish(&self, app: &mut App) {
        // All plugins are there by now, in whatever order they were added.
        let Some(schedule) = app.get_added_plugins::<ClothPlugin>().first().map(|it| it.schedule())
        else {
            tracing::warn!("`ClothDiagnosticsPlugin` measures nothing without `ClothPlugin`");
            return;
        };
        use ClothSystems::{Finish, Gather, LateSetup, Setup, Solve, WriteMeshes};
        app.add_systems(
            schedule,
            (
                mark_tick.before(Setup),
                mark_gather.after(Setup).before(Gather),
                (end_gather, mark_solve).chain().after(Gather).before(Solve),
                end_solve.after(Solve).before(Finish),
                (end_tick, report_cloths, report_crossings).chain().after(Finish),
            )
                .run_if(in_fixed_step),
        )
        .add_systems(
            PostUpdate,
            (mark_draw.after(LateSetup).before(WriteMeshes), end_draw.after(WriteMeshes)),
        );
    }
}

/// When parts of the tick began.
#[derive(Resource, Default)]
struct Marks {
    tick: Option<Instant>,
    part: Option<Instant>,
}

/// A cloth that is gone leaves no times behind.
fn forget_times(removed: On<Remove, ClothSimulation>, mut commands: Commands) {
    commands.entity(removed.entity).try_remove::<StageTimes>();
}

fn mark_tick(mut marks: ResMut<Marks>) {
    marks.tick = Some(Instant::now());
}

fn mark_gather(mut marks: ResMut<Marks>) {
    marks.part = Some(Instant::now());
}

fn end_gather(marks: Res<Marks>, mut out: Diagnostics) {
    add_since(&mut out, &ClothDiagnosticsPlugin::GATHER, marks.part);
}

/// Lets every cloth take its times from zero.
fn mark_solve(mut cloths: Query<&mut StageTimes>, mut marks: ResMut<Marks>) {
    for mut times in &mut cloths {
        *times = StageTimes::default();
    }
    marks.part = Some(Instant::now());
}

fn end_solve(marks: Res<Marks>, mut out: Diagnostics) {
    add_since(&mut out, &ClothDiagnosticsPlugin::SOLVE, marks.part);
}

fn end_tick(marks: Res<Marks>, mut out: Diagnostics) {
    add_since(&mut out, &ClothDiagnosticsPlugin::TICK, marks.tick);
}

fn mark_draw(mut marks: ResMut<Marks>) {
    marks.part = Some(Instant::now());
}

fn end_draw(marks: Res<Marks>, mut out: Diagnostics) {
    add_since(&mut out, &ClothDiagnosticsPlugin::DRAW, marks.part);
}

fn add_since(out: &mut Diagnostics, path: &DiagnosticPath, start: Option<Instant>) {
    if let Some(start) = start {
        out.add_measurement(path, || milliseconds(start.elapsed()));
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Tells what the cloths came to in the tick.
fn report_cloths(cloths: Query<(&ClothSimulation, &StageTimes)>, mut out: Diagnostics) {
    let mut spent = StageTimes::default();
    let (mut awake, mut asleep, mut substeps, mut contacts) = (0_u32, 0_u32, 0, 0);
    let (mut self_contacts, mut inter_contacts) = (None, None);
    let mut most_strain = f32::NEG_INFINITY;
    let (mut strains, mut springs) = (0.0, 0);
    for (cloth, times) in &cloths {
        asleep += u32::from(cloth.is_asleep());
        let (true, Some(tick)) = (cloth.tick.step.runs, cloth.progress.last_tick) else {
            continue;
        };
        awake += 1;
        spent.add(times);
        substeps = substeps.max(tick.substeps);
        contacts += tick.contact_count;
        if cloth.solver.self_collision().is_some() {
            *self_contacts.get_or_insert(0) += tick.self_contact_count;
        }
        if cloth.solver.inter_collision().is_some() {
            *inter_contacts.get_or_insert(0) += tick.inter_contact_count;
        }
        most_strain = most_strain.max(tick.max_strain);
        let (sum, count) = cloth.solver.strain_sum();
        strains += sum;
        springs += count;
    }
    for (path, time) in ClothDiagnosticsPlugin::STAGES.iter().zip(spent.0) {
        out.add_measurement(path, || milliseconds(time));
    }
    out.add_measurement(&ClothDiagnosticsPlugin::AWAKE, || f64::from(awake));
    out.add_measurement(&ClothDiagnosticsPlugin::ASLEEP, || f64::from(asleep));
    for (path, count) in [
        (&ClothDiagnosticsPlugin::SELF_CONTACTS, self_contacts),
        (&ClothDiagnosticsPlugin::INTER_CONTACTS, inter_contacts),
    ] {
        if let Some(count) = count {
            out.add_measurement(path, || f64::from(count));
        }
    }
    out.add_measurement(&ClothDiagnosticsPlugin::SUBSTEPS, || f64::from(substeps));
    out.add_measurement(&ClothDiagnosticsPlugin::CONTACTS, || f64::from(contacts));
    // Nothing has no strain.
    if awake > 0 {
        out.add_measurement(&ClothDiagnosticsPlugin::STRAIN_MAX, || f64::from(most_strain));
        out.add_measurement(&ClothDiagnosticsPlugin::STRAIN_MEAN, || strains / springs as f64);
    }
}

/// Seconds of the fixed clock from one count of crossings to the next.
const COUNT_EVERY: f32 = 1.0;

/// Counts the crossings of cloths that collide with themselves or with others, where any of them has moved.
fn report_crossings(
    cloths: Query<&ClothSimulation>,
    time: Res<Time>,
    mut next: Local<f32>,
    mut out: Diagnostics,
) {
    let layered = |cloth: &&ClothSimulation| {
        cloth.solver.self_collision().is_some() || cloth.solver.inter_collision().is_some()
    };
    *next -= time.delta_secs();
    if *next <= 0.0 && cloths.iter().filter(layered).any(|cloth| cloth.tick.step.runs) {
        *next = COUNT_EVERY;
        out.add_measurement(&ClothDiagnosticsPlugin::CROSSINGS, || f64::from(crossings(&cloths)));
    }
}

/// Crossings of cloths with themselves and with each other, where they collide.
fn crossings(cloths: &Query<&ClothSimulation>) -> u32 {
    let solvers = || cloths.iter().map(|cloth| &cloth.solver);
    let layers = |solver: &ClothSolver| solver.inter_collision().map_or(0, |it| it.layers);
    let own = solvers().filter(|it| it.self_collision().is_some()).map(ClothSolver::crossings);
    let mut count = own.sum();
    for (place, one) in solvers().enumerate() {
        let (low, high) = one.bounds();
        for other in solvers().skip(place + 1) {
            let (other_low, other_high) = other.bounds();
            let is_near = low.cmple(other_high).all() && other_low.cmple(high).all();
            if is_near && layers(one) & layers(other) != 0 {
                count += one.crossings_with(other);
            }
        }
    }
    count
}
