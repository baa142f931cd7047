//! The shapes of a cloth, from its components: what is drawn, and what is simulated. One whose simulated shape alone is another goes on
//! where it was.

use std::sync::Arc;

use bevy::math::Mat3;
use bevy::prelude::*;
use bevy_drape_core::surface::Placing;

use crate::cloth::proxy::ClothProxy;
use crate::cloth::weights::ClothWeights;
use crate::cloth::{Cloth, ClothShape};
use crate::error::ClothErrorKind;
use crate::error::proxy::ProxyProblem;
use crate::mesh::faces::Faces;
use crate::mesh::factors::Factors;
use crate::mesh::proxy::{Coarse, Proxy};
use crate::mesh::rest_cache::RestCache;
use crate::mesh::rest_shape::RestShape;
use crate::mesh::source::MeshSource;
use crate::pose::skeleton::Skeleton;
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::{Anchor, Attachments};
use crate::simulation::complaints::solver_error;
use crate::simulation::in_force::OTHER_SIZE;
use crate::simulation::start::Start;
use crate::solver::{Lattice, MassLumping, SolverError, Topology};

/// The shapes of a cloth at rest, in its entity's frame.
pub(crate) struct Shapes {
    pub simulated: RestShape,
    /// `None` where that is drawn as well.
    pub proxy: Option<Arc<Proxy>>,
}

impl Shapes {
    /// `None` while a mesh is still loading, or made in the background.
    ///
    /// # Errors
    /// Of the mesh, or of the proxy.
    pub fn of(
        cloth: &Cloth,
        asked: Option<&ClothProxy>,
        source: Option<&Handle<Mesh>>,
        meshes: &MeshSource,
        cache: &mut RestCache,
    ) -> Result<Option<Self>, ClothErrorKind> {
        let drawn = match cloth.shape {
            ClothShape::Sheet { size, particles } => Some(RestShape::Sheet { size, particles }),
            ClothShape::Mesh => meshes.read(source, cache).map_err(ClothErrorKind::Mesh)?,
        };
        let Some(drawn) = drawn else { return Ok(None) };
        let Some(asked) = asked else {
            return Ok(Some(Self { simulated: drawn, proxy: None }));
        };
        // What makes no cloth itself is told of as without a proxy.
        if let RestShape::Sheet { size, particles } = drawn {
            let (rows, columns) = (particles.y as usize, particles.x as usize);
            Lattice::check_sheet(size, rows, columns).map_err(ClothErrorKind::Shape)?;
        }
        let of_mesh = |problem| ClothErrorKind::Proxy(ProxyProblem::Mesh(problem));
        let coarse = match asked {
            ClothProxy::Grid(particles) => Some(Coarse::Grid(*particles)),
            ClothProxy::Ratio(ratio) => Some(Coarse::Ratio(*ratio)),
            ClothProxy::Mesh(mesh) => meshes.read_coarse(mesh).map_err(of_mesh)?,
        };
        let Some(coarse) = coarse else { return Ok(None) };
        let proxy = cache.proxy(drawn, coarse).map_err(ClothErrorKind::Proxy)?;
        let shapes = |proxy: Arc<Proxy>| Self {
            simulated: RestShape::Mesh(proxy.simulated.clone()),
            proxy: Some(proxy),
        };
        Ok(proxy.map(shapes))
    }

    /// The shape that is drawn.
    pub fn drawn(&self) -> &RestShape {
        self.proxy.as_ref().map_or(&self.simulated, |proxy| &proxy.drawn)
    }
}

impl ClothSimulation {
    /// The shape that is drawn.
    pub(crate) fn drawn_shape(&self) -> &RestShape {
        let proxy = self.in_force.proxy.as_ref();
        proxy.map_or(&self.in_force.rest_shape, |proxy| &proxy.drawn)
    }

    /// Whether a running cloth can go on as this one: what is drawn is the same, on the same skeleton if it is worn, and another shape is
    /// simulated.
    pub(crate) fn can_go_on_from(&self, before: &Self) -> bool {
        before.progress.tick_count > 0
            && !before.progress.quarantined
            && !before.is_hanging()
            && (before.in_force.placed.scale / self.in_force.placed.scale - 1.0).abs() <= OTHER_SIZE
            && before.skeleton() == self.skeleton()
            && before.drawn_shape().is(self.drawn_shape())
            && !before.in_force.rest_shape.is(&self.in_force.rest_shape)
    }

    /// The skeleton that it is worn on.
    fn skeleton(&self) -> Option<&Skeleton> {
        self.skin.as_ref().map(|skin| &skin.skeleton)
    }

    /// Goes on where another was, as fast as it was, with what led it. Pins take hold anew.
    ///
    /// # Errors
    /// Where a place is too far away.
    pub(crate) fn go_on_from(&mut self, before: &Self) -> Result<(), SolverError> {
        let scale = self.in_force.placed.scale;
        let (new, old) = (&self.in_force.rest_shape, &before.in_force.rest_shape);
        let mut old_faces = Faces::of(old);
        // Cloths of one proxy share it; from one proxy to another it is made.
        let mut proxies = [&self.in_force.proxy, &before.in_force.proxy].into_iter().flatten();
        let made;
        let binding = match proxies.find_map(|proxy| proxy.between(new, old)) {
            Some(shared) => shared,
            None => {
                made = Faces::of(new).onto(&old_faces);
                &made
            }
        };
        // At the start of the last tick, from where it is drawn, and at its end.
        let mut at = |blend| {
            // Near the cloth's own origin: far from the world's, places are coarse.
            let from_origin = Placing { blend, turn: Mat3::IDENTITY, shift: Vec3::ZERO };
            from_origin.write(&before.solver, &mut old_faces.points);
            old_faces.points.iter_mut().for_each(|place| *place /= scale);
            old_faces.update_normals();
            let mut places = vec![Vec3::ZERO; new.particle_count()];
            binding.write(&old_faces.points, &old_faces.normals, 1.0, &mut places);
            let is_held = |particle: u32| before.pinned().binary_search(&particle).is_ok();
            for (particle, bond) in binding.bonds().iter().enumerate() {
                let share = bond.held(is_held);
                if share > 0.0 {
                    let rigid = binding.rigid(particle, &old_faces.points, 1.0);
                    places[particle] = places[particle].lerp(rigid, share);
                }
            }
            let origin = before.solver.origin();
            places.iter_mut().for_each(|place| *place = *place * scale + origin);
            places
        };
        let (starts, ends) = (at(0.0), at(1.0));
        let speeds: Vec<_> =
            (0..before.particle_count()).map(|i| before.solver.velocity(i)).collect();
        self.solver.place(&ends)?;
        self.solver.come_from(&starts)?;
        for (particle, velocity) in binding.means(&speeds).enumerate() {
            self.solver.set_velocity(particle, velocity)?;
        }
        if let (Some(skin), Some(worn)) = (&mut self.skin, &before.skin) {
            skin.go_on_from(worn, binding.means(worn.starts()).collect());
        }
        let anchors = before.held.attachments.anchors.iter();
        let anchors = anchors.map(|anchor| Anchor { holds: 0, pulls: 0, ..*anchor }).collect();
        self.held.attachments = Attachments { anchors, ..default() };
        let told_ready = before.start.told_ready;
        self.start = Start { told_ready, takes_hold: true, ..default() };
        self.frame = before.frame.clone();
        self.culling = before.culling.clone();
        if let Some(grabbed) = &before.held.grab {
            self.held.grab = Some(Box::new(grabbed.go_on(&before.solver, &self.solver)));
        }
        self.progress = before.progress.clone();
        Ok(())
    }
}

/// The rest shape as the solver has it.
pub(crate) fn topology(
    rest: &RestShape,
    scale: f32,
    masses: MassLumping,
    weights: Option<&ClothWeights>,
    cache: &mut RestCache,
) -> Result<Topology, ClothErrorKind> {
    let factors = factors(rest, weights)?;
    cache.topology(rest, scale, masses, factors.as_ref()).map_err(solver_error)
}

/// The factors that a cloth's weights give the particles of its rest shape; none without weights.
pub(crate) fn factors(
    rest: &RestShape,
    weights: Option<&ClothWeights>,
) -> Result<Option<Factors>, ClothErrorKind> {
    match weights {
        Some(weights) => weights.factors(rest).map_err(ClothErrorKind::Weights),
        None => Ok(None),
    }
}
