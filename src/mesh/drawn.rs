//! The mesh that a cloth draws into.

use std::sync::Arc;

use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_drape_core::surface::{GridNormals, GroupSums, Tangents};

use crate::mesh::intake::NormalPlan;
use crate::mesh::proxy::Proxy;
use crate::mesh::rest_shape::RestShape;
use crate::pose::skeleton::Seen;
use crate::solver::Pose;

/// The mesh that a cloth draws into, and what was last drawn.
#[derive(Component)]
pub(crate) struct ClothMesh {
    pub handle: Handle<Mesh>,
    /// The mesh that it is a copy of.
    pub source: Option<Handle<Mesh>>,
    /// The rest shape that is drawn: the particle and the normal of each vertex.
    pub rest: RestShape,
    /// The coarse shape that carries it, where there is one.
    pub carrier: Option<Box<Carrier>>,
    /// Positions in the entity's frame, by particle of what is drawn.
    pub points: Vec<Vec3>,
    /// The same, as last written.
    pub written: Vec<Vec3>,
    /// Room to work out normals in, by rows or by groups.
    pub cells: GridNormals,
    pub sums: GroupSums,
    /// The mesh's tangents, once it has been looked at.
    pub tangents: Option<Option<Box<Tangents>>>,
    pub drawn: Option<Drawn>,
    /// Where the cloth's anchors were in the last frame, in their order; `None` where one has no pose.
    pub anchors: Vec<Option<Pose>>,
    /// Where the joints of a worn cloth were in the last frame.
    pub joints: Seen,
}

/// The shape that is simulated in the place of the one that is drawn, in a frame.
pub(crate) struct Carrier {
    pub proxy: Arc<Proxy>,
    /// Positions in the entity's frame, by particle of what is simulated, and normals.
    pub points: Vec<Vec3>,
    pub normals: Vec<[f32; 3]>,
    /// What holds each particle hard.
    pub held: Vec<Held>,
    /// Room to work out normals in.
    pub cells: GridNormals,
    pub sums: GroupSums,
}

/// What holds a particle hard.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Held {
    Free,
    /// Its place on the skin of a worn cloth.
    OnSkin,
    /// An anchor.
    Attached,
}

/// The state of things when the mesh was written.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Drawn {
    pub tick: u64,
    /// The cloth's `shape_version`.
    pub version: u64,
    pub blend: f32,
    pub transform: Affine3A,
    /// Nothing moved in the tick, so that it looks the same at any blend.
    pub settled: bool,
}

impl ClothMesh {
    pub fn new(
        handle: Handle<Mesh>,
        source: Option<Handle<Mesh>>,
        rest: RestShape,
        proxy: Option<Arc<Proxy>>,
    ) -> Self {
        let count = rest.particle_count();
        let columns = match &rest {
            RestShape::Sheet { particles, .. } => particles.x as usize,
            RestShape::Mesh(shape) => columns(&shape.normals),
        };
        Self {
            handle,
            source,
            rest,
            carrier: proxy.map(Carrier::new).map(Box::new),
            points: vec![Vec3::ZERO; count],
            written: vec![Vec3::ZERO; count],
            cells: GridNormals::new(columns),
            sums: GroupSums::default(),
            tangents: None,
            drawn: None,
            anchors: Vec::new(),
            joints: Seen::default(),
        }
    }

    /// Draws the same mesh, which another shape carries now.
    pub fn be_carried_by(&mut self, proxy: Option<Arc<Proxy>>) {
        self.carrier = proxy.map(Carrier::new).map(Box::new);
        self.anchors.clear();
    }
}

impl Carrier {
    fn new(proxy: Arc<Proxy>) -> Self {
        let count = proxy.simulated.positions.len();
        Self {
            points: vec![Vec3::ZERO; count],
            normals: vec![[0.0; 3]; count],
            held: vec![Held::Free; count],
            cells: GridNormals::new(columns(&proxy.simulated.normals)),
            sums: GroupSums::default(),
            proxy,
        }
    }
}

/// Columns of a plan by rows and columns; none of one by groups.
fn columns(plan: &NormalPlan) -> usize {
    match plan {
        NormalPlan::Grid { columns, .. } => *columns,
        NormalPlan::Groups(_) => 0,
    }
}
