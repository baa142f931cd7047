//! From components to a running cloth, and from changed components to a changed cloth.

use bevy::camera::visibility::DynamicSkinnedMeshBounds;
use bevy::ecs::entity::EntityHashSet;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;

use crate::cloth::lod::ClothLod;
use crate::cloth::material::ClothMaterial;
use crate::cloth::pins::ClothPins;
use crate::cloth::proxy::ClothProxy;
use crate::cloth::settings::ClothSettings;
use crate::cloth::skin::ClothSkin;
use crate::cloth::weights::ClothWeights;
use crate::cloth::{Cloth, ClothShape};
use crate::error::failures::{Blame, Failures};
use crate::error::problems::MeshProblem;
use crate::error::skin::SkinProblem;
use crate::error::{ClothComponent, ClothErrorKind};
use crate::mesh::drawn::ClothMesh;
use crate::mesh::rest_cache::RestCache;
use crate::mesh::rest_shape::RestShape;
use crate::mesh::source::{ClothSource, MeshSource, source_of};
use crate::mesh::surface::SkippedTriangles;
use crate::pose::{pose_now, to_world};
use crate::simulation::ClothSimulation;
use crate::simulation::complaints::{scale_at_fault, solver_error};
use crate::simulation::culling::Culling;
use crate::simulation::holding::Holding;
use crate::simulation::in_force::InForce;
use crate::simulation::lod::Lod;
use crate::simulation::progress::Progress;
use crate::simulation::pushing::Pushing;
use crate::simulation::reference_frame::ReferenceFrame;
use crate::simulation::shaping::{Shapes, factors};
use crate::simulation::skin::make::{Skins, put_on};
use crate::simulation::skin::taken::{TakenSkin, take};
use crate::simulation::sleeping::SleepState;
use crate::simulation::start::Start;
use crate::simulation::tick_state::TickState;
use crate::solver::{ClothSolver, Pose, SolverError, Topology};

/// The components that a cloth is set up from, and what runs of it already.
type Ingredients = (
    Entity,
    Ref<'static, Cloth>,
    Option<Ref<'static, ClothMaterial>>,
    Option<Ref<'static, ClothSettings>>,
    Option<Ref<'static, ClothWeights>>,
    (Option<Ref<'static, ClothProxy>>, Option<Ref<'static, ClothLod>>),
    Option<Ref<'static, Mesh3d>>,
    Skinned,
    (Option<&'static ClothMesh>, Option<&'static ClothSource>),
    Option<&'static ClothSimulation>,
);

/// The skin of an entity, which it still has or which was taken over.
type Skinned = (
    Option<Ref<'static, ClothSkin>>,
    Option<Ref<'static, SkinnedMesh>>,
    Has<DynamicSkinnedMeshBounds>,
    Option<&'static TakenSkin>,
);

/// Sets up cloths that are new, and anew those whose shape has changed.
pub(crate) fn set_up_cloths(
    cloths: Query<Ingredients>,
    transforms: TransformHelper,
    mut meshes: MeshSource,
    skins: Skins,
    mut cache: ResMut<RestCache>,
    mut commands: Commands,
    mut failures: Failures,
    // Cloths whose mesh was changed while they ran, until they are set up anew.
    mut outdated: Local<EntityHashSet>,
) {
    meshes.note_changes();
    outdated.retain(|entity| cloths.contains(*entity));
    for (
        entity,
        cloth,
        material,
        settings,
        weights,
        (proxy, levels),
        mesh3d,
        skinned,
        meshes_of,
        simulation,
    ) in &cloths
    {
        let (own, kept) = meshes_of;
        let copied = if own.is_none() { kept } else { None };
        let copied = copied.and_then(|kept| kept.of_copy(mesh3d.as_deref()));
        let source = copied.unwrap_or_else(|| source_of(mesh3d.as_deref(), own));
        let (worn, skinned, has_bounds, taken) = skinned;
        // A level that is given is in force from the first tick on.
        let given;
        let lod = match simulation {
            Some(running) => &running.lod,
            None => {
                given = Lod::given(levels.as_deref());
                &given
            }
        };
        let asked = lod.proxy(proxy.as_deref());
        let other_proxy =
            |running: &ClothSimulation| running.in_force.asked_proxy.as_ref() != asked;
        if let Some(running) = simulation
            && (meshes.was_modified(source) || outdated.contains(&entity))
        {
            // It may have been set up anew, or have become the same again, since it was listed.
            if meshes.is_another(source, running.drawn_shape()) {
                outdated.insert(entity);
            } else {
                outdated.remove(&entity);
            }
        }
        let same = |running: &&ClothSimulation| {
            let other_skin = match running.skin {
                Some(_) => skinned.is_some(),
                None => worn.is_some(),
            };
            !other_skin
                && !outdated.contains(&entity)
                && !other_proxy(running)
                && !needs_setup(running, &cloth, mesh3d.as_deref(), own)
        };
        let same = simulation.filter(same);
        if let Some(running) = same
            && !moved_before_its_first_tick(running, &transforms, entity)
        {
            // Another shape may have been refused since.
            failures.clear(entity, Blame::Shape);
            failures.clear(entity, Blame::Proxy);
            continue;
        }
        let changed = cloth.is_changed()
            || is_changed(&material)
            || is_changed(&settings)
            || is_changed(&weights)
            || is_changed(&proxy)
            || is_changed(&levels)
            || is_changed(&mesh3d)
            || is_changed(&worn)
            || is_changed(&skinned)
            || meshes.has_changed(source)
            || meshes.has_changed(asked.and_then(ClothProxy::own_mesh));
        // Nothing else tells of a component that was taken away, nor of a proxy that another level has given.
        let is_gone = |is_none: bool, blame| is_none && failures.blames(entity, blame);
        let has_no_proxy = is_gone(asked.is_none(), Blame::Proxy);
        let is_other = has_no_proxy
            || is_gone(material.is_none(), Blame::Component(ClothComponent::ClothMaterial))
            || is_gone(settings.is_none(), Blame::Component(ClothComponent::ClothSettings))
            || is_gone(weights.is_none(), Blame::Weights)
            || is_gone(worn.is_none(), Blame::Skin)
            || simulation.is_some_and(other_proxy) && !failures.blames(entity, Blame::Proxy);
        if has_no_proxy {
            failures.clear(entity, Blame::Proxy);
        }
        // What failed is tried again only after a change, but a parent's transform may change unseen.
        if failures.keep_from_set_up(entity) && !changed && !is_other {
            continue;
        }
        let told = simulation.and_then(ClothSimulation::intake);
        let made = set_up(
            entity,
            ((&cloth, asked), in_force(&material), in_force(&settings), weights.as_deref()),
            (source, worn.as_deref(), skinned.as_deref().or(taken.map(|taken| &taken.skinned))),
            (&transforms, &skins),
            &meshes,
            &mut cache,
        );
        match made {
            // Still loading, or being made.
            Ok(None) => {}
            Ok(Some(mut made)) => {
                outdated.remove(&entity);
                // Only elsewhere.
                made.start.told_ready = same.is_some_and(|running| running.start.told_ready);
                made.lod = lod.anew();
                let before = simulation.filter(|before| made.can_go_on_from(before));
                if let Some(before) = before
                    && let Err(problem) = made.go_on_from(before)
                {
                    failures.report(entity, ClothErrorKind::Solver(problem));
                    continue;
                }
                // Where the mesh stays, another cloth was drawn into it.
                let drawn = own.and_then(|own| own.drawn);
                made.shape_version = drawn.map_or(0, |drawn| drawn.version + 1);
                // What is wrong with a cloth that is the same, only elsewhere, is still wrong.
                match same {
                    Some(_) => failures.clear_those_of_set_up(entity),
                    None => failures.clear_those_of_cloths(entity),
                }
                let mut target = commands.entity(entity);
                if made.intake() != told {
                    tell_skipped(entity, &made);
                }
                if mesh3d.is_some()
                    && own.is_none()
                    && copied.is_none()
                    && cloth.shape != ClothShape::Mesh
                {
                    tracing::warn!(
                        "cloth {entity}: the sheet replaces the entity's `Mesh3d`; use `Cloth::of_mesh3d()` to make a cloth of that mesh"
                    );
                }
                let hides_colors = worn.as_deref().is_some_and(ClothSkin::hides_colors);
                let proxy = made.in_force.proxy.as_ref();
                if own.is_some_and(|own| own.rest.is(made.drawn_shape())) && before.is_some() {
                    let proxy = proxy.cloned();
                    let carry = move |mut own: Mut<ClothMesh>| own.be_carried_by(proxy);
                    target.entry::<ClothMesh>().and_modify(carry);
                } else if let Some(drawn) =
                    meshes.own_mesh(made.drawn_shape(), proxy, source, !hides_colors)
                {
                    target.try_insert(drawn);
                }
                if let (Some(_), Some(skinned)) = (&made.skin, &skinned) {
                    take(&mut target, skinned, has_bounds);
                }
                target.try_insert(made);
            }
            Err(error) => failures.report(entity, error),
        }
    }
    cache.stop_forgotten();
}

fn is_changed<T: Component>(component: &Option<Ref<T>>) -> bool {
    component.as_ref().is_some_and(DetectChanges::is_changed)
}

/// A component, or its default where it was taken away.
pub(crate) fn in_force<T: Component + Copy + Default>(component: &Option<Ref<T>>) -> T {
    component.as_deref().copied().unwrap_or_default()
}

/// Says, once, what of a mesh is no part of its cloth.
fn tell_skipped(entity: Entity, cloth: &ClothSimulation) {
    if let Some(intake) = cloth.intake()
        && intake.skipped.total() > 0
    {
        let SkippedTriangles { collapsed, zero_area, duplicate } = intake.skipped;
        tracing::warn!(
            "cloth {entity}: {} of its mesh's triangles are left out ({collapsed} collapsed, {zero_area} \
             without area, {duplicate} duplicate), {} make the cloth",
            intake.skipped.total(),
            intake.triangles,
        );
    }
}

/// The running cloth; `None` while its mesh is still loading, or what a large one needs is made in the background.
fn set_up(
    entity: Entity,
    ((cloth, proxy), material, settings, weights): (
        (&Cloth, Option<&ClothProxy>),
        ClothMaterial,
        ClothSettings,
        Option<&ClothWeights>,
    ),
    (source, worn, skinned): (Option<&Handle<Mesh>>, Option<&ClothSkin>, Option<&SkinnedMesh>),
    (transforms, skins): (&TransformHelper, &Skins),
    meshes: &MeshSource,
    cache: &mut RestCache,
) -> Result<Option<ClothSimulation>, ClothErrorKind> {
    if worn.is_none() && skinned.is_some() {
        pose_now(transforms, entity)?;
        return Err(ClothErrorKind::Mesh(MeshProblem::Skinned));
    }
    // A skinned mesh is where its joints are, whatever its entity's transform.
    let pose = if worn.is_none() { pose_now(transforms, entity)? } else { Pose::IDENTITY };
    let Some(shapes) = Shapes::of(cloth, proxy, source, meshes, cache)? else {
        return Ok(None);
    };
    let rest = shapes.simulated.clone();
    let (mut skin, mut pose) = (None, pose);
    if worn.is_some() {
        let problem = |problem| ClothErrorKind::Skin(SkinProblem::Mesh(problem));
        if matches!(shapes.drawn(), RestShape::Sheet { .. }) {
            return Err(ClothErrorKind::Skin(SkinProblem::NotAMesh));
        }
        let Some(mesh) = meshes.get(source).map_err(problem)? else { return Ok(None) };
        let drawn = shapes.proxy.as_ref().map(|proxy| &proxy.drawn);
        let made = skins.make(skinned, mesh, &rest, drawn).map_err(ClothErrorKind::Skin)?;
        let Some(made) = made else { return Ok(None) };
        pose.scale = made.scale().unwrap_or(1.0);
        skin = Some((made, mesh));
    }
    let factors = factors(&rest, weights)?;
    let rubs = material.bending_friction > 0.0;
    let made = cache.topology_to_be(&rest, pose.scale, settings.masses, factors.as_ref(), rubs);
    let made = made.map_err(|error| scale_at_fault(solver_error(error), pose.scale))?;
    let Some(topology) = made else { return Ok(None) };
    let asked = (cloth.shape, proxy.cloned());
    let mut simulation =
        build(asked, material, settings, weights, pose, shapes, topology).map_err(solver_error)?;
    if let (Some(worn), Some((skin, mesh))) = (worn, skin) {
        put_on(&mut simulation, worn, skin, mesh, skins)?;
    }
    Ok(Some(simulation))
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
    running.in_force.shape != cloth.shape || cloth.shape == ClothShape::Mesh && other_mesh
}

/// Whether a cloth that has not run yet is elsewhere than it was set up. It starts where its first
/// tick finds it, whether or not a frame has drawn it before.
fn moved_before_its_first_tick(
    running: &ClothSimulation,
    transforms: &TransformHelper,
    entity: Entity,
) -> bool {
    running.progress.tick_count == 0
        && !running.start.has_begun()
        && !running.culling.has_culled()
        // A worn cloth follows its skin.
        && running.skin.is_none()
        && pose_now(transforms, entity).is_ok_and(|pose| pose != running.in_force.placed)
}

/// A cloth at rest where its entity is.
fn build(
    (shape, asked_proxy): (ClothShape, Option<ClothProxy>),
    material: ClothMaterial,
    settings: ClothSettings,
    weights: Option<&ClothWeights>,
    pose: Pose,
    Shapes { simulated, proxy }: Shapes,
    topology: Topology,
) -> Result<ClothSimulation, SolverError> {
    let unscaled = Pose { scale: 1.0, ..pose };
    let start: Vec<_> = topology.rest_positions().iter().map(|p| to_world(&unscaled, *p)).collect();
    let solver = ClothSolver::new(topology, &start, material.into(), settings.into())?;
    let in_force = InForce {
        shape,
        material,
        settings,
        pins: ClothPins::default(),
        weights: weights.cloned(),
        skin: None,
        asked_proxy,
        proxy,
        rest_shape: simulated,
        placed: pose,
    };
    Ok(ClothSimulation {
        solver,
        in_force,
        start: Start::default(),
        held: Holding::default(),
        skin: None,
        frame: ReferenceFrame::default(),
        pushing: Pushing::default(),
        culling: Culling::default(),
        lod: Lod::default(),
        sleep: SleepState::default(),
        tick: TickState::default(),
        progress: Progress::default(),
        shape_version: 0,
    })
}
