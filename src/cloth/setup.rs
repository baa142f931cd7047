//! From components to a running cloth, and from changed components to a changed cloth.

use super::{
    Cloth, ClothMaterial, ClothPins, ClothSettings, ClothShape, ClothSimulation, LatticeCache,
    attachment::Attachments,
    following::Following,
    pose::{PoseError, pose_now, to_world},
    rest::Rest,
};
use crate::{
    error::{Blame, ClothError, ClothFailure, Failures},
    mesh::{self, ClothMesh, MeshSource, RestShape},
    solver::{ClothSolver, Lattice, LatticeError, MassLumping, Pose, SolverError, Topology},
    step::ClothStep,
};
use bevy::prelude::*;
use std::sync::Arc;

/// What a cloth is set up from.
type Ingredients = (
    Entity,
    Ref<'static, Cloth>,
    Ref<'static, ClothMaterial>,
    Ref<'static, ClothSettings>,
    Option<Ref<'static, Mesh3d>>,
    Option<&'static ClothMesh>,
    Option<&'static ClothSimulation>,
);

/// Sets up cloths that are new, and anew those whose shape has changed.
pub(crate) fn set_up_cloths(
    cloths: Query<Ingredients>,
    transforms: TransformHelper,
    mut meshes: MeshSource,
    mut lattices: ResMut<LatticeCache>,
    mut commands: Commands,
    mut failures: Failures,
) {
    for (entity, cloth, material, settings, mesh3d, own, simulation) in &cloths {
        let source = mesh::source_of(mesh3d.as_deref(), own);
        if let Some(running) = simulation
            && !needs_setup(running, &cloth, mesh3d.as_deref(), own)
            && !moved_before_its_first_tick(running, &transforms, entity)
        {
            continue;
        }
        let mesh_changed = mesh3d.as_ref().is_some_and(DetectChanges::is_changed);
        let changed =
            cloth.is_changed() || material.is_changed() || settings.is_changed() || mesh_changed;
        // What failed is tried again only after a change, but a parent's transform may change
        // unseen.
        if failures.has(entity) && !changed && !failures.blames(entity, Blame::Pose) {
            continue;
        }
        let made = set_up(
            entity,
            &cloth,
            *material,
            *settings,
            source,
            &transforms,
            &meshes,
            &mut lattices,
        );
        match made {
            // Still loading.
            Ok(None) => {}
            Ok(Some((simulation, rest))) => {
                let mut target = commands.entity(entity);
                target.try_remove::<ClothFailure>();
                if let Some(drawn) = meshes.own_mesh(&simulation, &rest, source) {
                    target.try_insert(drawn);
                }
                target.try_insert(simulation);
            }
            Err(error) => failures.report(entity, error),
        }
    }
}

/// The running cloth and the shape it has at rest; `None` while its mesh is still loading.
fn set_up(
    entity: Entity,
    cloth: &Cloth,
    material: ClothMaterial,
    settings: ClothSettings,
    source: Option<&Handle<Mesh>>,
    transforms: &TransformHelper,
    meshes: &MeshSource,
    lattices: &mut LatticeCache,
) -> Result<Option<(ClothSimulation, RestShape)>, ClothError> {
    let pose = pose_now(transforms, entity).map_err(|error| pose_error(entity, error))?;
    let Some(rest) = rest_shape(entity, cloth, source, meshes)? else {
        return Ok(None);
    };
    let lattice = lattice(&rest, pose.scale, settings.masses, lattices)
        .map_err(|problem| ClothError::Shape { entity, problem })?;
    let simulation = build(cloth, material, settings, pose, &rest, lattice)
        .map_err(|problem| solver_error(entity, problem))?;
    Ok(Some((simulation, rest)))
}

/// Whether a running cloth no longer is what its components say.
fn needs_setup(
    running: &ClothSimulation,
    cloth: &Cloth,
    mesh3d: Option<&Mesh3d>,
    own: Option<&ClothMesh>,
) -> bool {
    let other_mesh = match (mesh3d, own) {
        (Some(mesh3d), Some(own)) => mesh3d.id() != own.handle.id(),
        _ => false,
    };
    running.shape != cloth.shape || cloth.shape == ClothShape::Mesh && other_mesh
}

/// Whether a cloth that has not run yet is elsewhere than it was set up. It starts where its first
/// tick finds it, whether or not a frame has drawn it before.
fn moved_before_its_first_tick(
    running: &ClothSimulation,
    transforms: &TransformHelper,
    entity: Entity,
) -> bool {
    running.tick_count == 0 && pose_now(transforms, entity).is_ok_and(|pose| pose != running.placed)
}

pub(crate) fn pose_error(entity: Entity, error: PoseError) -> ClothError {
    match error {
        PoseError::Missing => ClothError::NoTransform { entity },
        PoseError::Scale(scale) => ClothError::Scale { entity, scale },
    }
}

/// The rest shape in the entity's frame; `None` while the mesh is still loading.
fn rest_shape(
    entity: Entity,
    cloth: &Cloth,
    source: Option<&Handle<Mesh>>,
    meshes: &MeshSource,
) -> Result<Option<RestShape>, ClothError> {
    match cloth.shape {
        ClothShape::Sheet { size, particles } => Ok(Some(RestShape::Sheet { size, particles })),
        ClothShape::Mesh => {
            meshes.read(source).map_err(|problem| ClothError::Mesh { entity, problem })
        }
    }
}

/// The lattice of a rest shape, made larger by `scale`.
fn lattice(
    rest: &RestShape,
    scale: f32,
    masses: MassLumping,
    lattices: &mut LatticeCache,
) -> Result<Arc<Lattice>, LatticeError> {
    match rest {
        RestShape::Sheet { size, particles } => lattices.sheet(*size * scale, *particles, masses),
        RestShape::Grid { topology, positions } => {
            let positions: Vec<_> = positions.iter().map(|p| *p * scale).collect();
            Lattice::new(topology.rows, topology.columns, &positions, masses).map(Arc::new)
        }
    }
}

/// A cloth at rest where its entity is.
fn build(
    cloth: &Cloth,
    material: ClothMaterial,
    settings: ClothSettings,
    pose: Pose,
    rest: &RestShape,
    lattice: Arc<Lattice>,
) -> Result<ClothSimulation, SolverError> {
    let unscaled = Pose { scale: 1.0, ..pose };
    let start: Vec<_> = lattice.rest_positions().iter().map(|p| to_world(&unscaled, *p)).collect();
    Ok(ClothSimulation {
        solver: ClothSolver::new(lattice, &start, material.into(), settings.into())?,
        attachments: Attachments::default(),
        following: Following::default(),
        rest: Rest::default(),
        shape: cloth.shape,
        material,
        settings,
        pins: ClothPins::default(),
        placed: pose,
        particle_of_vertex: rest.particle_of_vertex(),
        step: ClothStep::default(),
        outcome: None,
        last_tick: None,
        tick_count: 0,
        quarantined: false,
        stale: true,
    })
}

/// Applies changed materials and settings. Numbers out of range are refused, the last good ones
/// stay.
pub(crate) fn apply_changes(
    mut cloths: Query<(Entity, Ref<ClothMaterial>, Ref<ClothSettings>, &mut ClothSimulation)>,
    mut failures: Failures,
) {
    for (entity, material, settings, mut cloth) in &mut cloths {
        if !material.is_changed() && !settings.is_changed() {
            continue;
        }
        let cloth = &mut *cloth;
        let mut changed = false;
        let outcome = apply_material(cloth, *material, &mut changed);
        tell(entity, Blame::Material, outcome, &mut failures);
        let outcome = apply_settings(cloth, *settings, &mut changed);
        tell(entity, Blame::Settings, outcome, &mut failures);
        if changed {
            cloth.wake();
        }
        if changed && cloth.quarantined {
            cloth.quarantined = false;
            failures.clear(entity, Blame::Motion);
        }
    }
}

fn apply_material(
    cloth: &mut ClothSimulation,
    material: ClothMaterial,
    changed: &mut bool,
) -> Result<(), SolverError> {
    if material != cloth.material {
        cloth.solver.set_material(material.into())?;
        cloth.material = material;
        *changed = true;
    }
    Ok(())
}

fn apply_settings(
    cloth: &mut ClothSimulation,
    settings: ClothSettings,
    changed: &mut bool,
) -> Result<(), SolverError> {
    if settings != cloth.settings {
        if settings.masses == cloth.settings.masses {
            cloth.solver.set_settings(settings.into())?;
        } else {
            cloth.solver = with_masses(cloth, settings)?;
        }
        cloth.settings = settings;
        *changed = true;
    }
    Ok(())
}

/// The solver over a rest shape of other masses, in the same place and motion.
fn with_masses(
    cloth: &ClothSimulation,
    settings: ClothSettings,
) -> Result<ClothSolver, SolverError> {
    let topology = match cloth.solver.topology() {
        Topology::Lattice(old) => {
            let (rows, columns) = (old.rows(), old.columns());
            let new = Lattice::new(rows, columns, old.rest_positions(), settings.masses)?;
            Topology::from(Arc::new(new))
        }
        Topology::Graph(old) => Topology::from(Arc::new(old.with_lumping(settings.masses)?)),
    };
    let positions: Vec<_> = cloth.positions().collect();
    let material = cloth.material.into();
    let mut solver = ClothSolver::new(topology, &positions, material, settings.into())?;
    for particle in 0..positions.len() {
        solver.set_velocity(particle, cloth.solver.velocity(particle))?;
    }
    solver.set_pins(cloth.solver.pins())?;
    let soft: Vec<_> = cloth.solver.soft_pins().copied().collect();
    solver.set_soft_pins(&soft)?;
    Ok(solver)
}

fn tell(entity: Entity, blame: Blame, outcome: Result<(), SolverError>, failures: &mut Failures) {
    match outcome {
        Ok(()) => failures.clear(entity, blame),
        Err(problem) => failures.report(entity, solver_error(entity, problem)),
    }
}

/// A solver's complaint, told to the component that it is about.
pub(crate) fn solver_error(entity: Entity, problem: SolverError) -> ClothError {
    match problem {
        SolverError::Parameter(problem) => {
            let settings = ["substeps", "provot_passes", "max_speed"].contains(&problem.name);
            let component = if settings { "ClothSettings" } else { "ClothMaterial" };
            ClothError::Parameter { entity, component, problem }
        }
        SolverError::Lattice(problem) => ClothError::Shape { entity, problem },
        problem => ClothError::Solver { entity, problem },
    }
}
