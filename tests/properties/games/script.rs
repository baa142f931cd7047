//! Scripts of what a game may do to its entities: spawn them, put any component on any of them, take it off, move them, trigger events.

use bevy::math::{
    Quat, UVec2, Vec2, Vec3,
    primitives::{Capsule3d, Cone, Cuboid, Cylinder, Sphere, Torus},
};
use bevy_drape::{
    ClothAir, ClothBody, ClothCulling, ClothForce, ClothForces, ClothGrab, ClothGravityOverride,
    ClothInterpolation, ClothLevel, ClothLod, ClothProxy, ClothShape, ClothSkin,
    ClothSleepThreshold, ClothWeights, ClothWindOverride, ColliderImpulse, ColliderMass,
    SdfColliderDisabled, VertexFactor, WindZone,
    prelude::*,
    sdf::shapes::CapsuleBetween,
    solver::{PushOn, PushWith},
};
use proptest::prelude::*;

use crate::choices::{
    any_vector, logarithmic, material, rotation, settings, vector, wild_vector, zone,
};

/// Entities that a script knows of.
pub const SLOTS: usize = 6;

/// One of the entities, whether it is there or not.
pub type Slot = usize;

/// A component that is put on an entity.
#[derive(Clone, Debug)]
pub enum Part {
    Cloth(Cloth),
    Mesh(MeshKind),
    Material(ClothMaterial),
    Settings(ClothSettings),
    Pins(ClothPins, Option<Slot>),
    Weights(ClothWeights),
    Air(ClothAir),
    SelfCollision(ClothSelfCollision),
    InterCollision(ClothInterCollision),
    Lod(ClothLod),
    Proxy(ClothProxy),
    Paused(ClothPaused),
    Sleep(ClothSleepThreshold),
    Forces(ClothForces),
    Grab(ClothGrab),
    Inertia(ClothInertia),
    Teleport(ClothTeleport),
    Culling(ClothCulling),
    Interpolation(ClothInterpolation),
    Skin(ClothSkin),
    Body(ClothBody),
    Gravity(ClothGravityOverride),
    Wind(ClothWindOverride),
    Zone(WindZone),
    Collider(SdfCollider),
    Disabled(SdfColliderDisabled),
    Mass(ColliderMass),
    BodyOf(Slot),
    Impulse(ColliderImpulse),
    Hang(HangOnStart),
}

/// A mesh of a cloth's own.
#[derive(Clone, Copy, Debug)]
pub enum MeshKind {
    Grid(u32, u32),
    Holed,
    Box,
    Looped,
    Nothing,
}

/// One thing that a game does.
#[derive(Clone, Debug)]
pub enum Deed {
    Spawn(Slot, Vec3, Vec<Part>),
    Despawn(Slot),
    Insert(Slot, Part),
    Remove(Slot, usize),
    Move(Slot, Vec3, Quat),
    Scale(Slot, Vec3),
    Child(Slot, Slot),
    Orphan(Slot),
    Push(Slot, PushOn, PushWith),
    Teleport(Slot),
    Reset(Slot),
    Wake(Slot),
    /// The state of one is put on another.
    Restore(Slot, Slot),
    /// The mesh that an entity has is made another.
    Remake(Slot, MeshKind),
    DropMesh(Slot),
}

/// Seldom a number that is none.
fn wild(usual: impl Strategy<Value = f32> + Clone) -> impl Strategy<Value = f32> + Clone {
    let odd = vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e30];
    prop_oneof![1 => prop::sample::select(odd), 12 => usual]
}

fn mesh_kind() -> impl Strategy<Value = MeshKind> + Clone {
    prop_oneof![
        4 => (2_u32..9, 2_u32..9).prop_map(|(r, c)| MeshKind::Grid(r, c)),
        3 => Just(MeshKind::Holed),
        1 => Just(MeshKind::Box),
        1 => Just(MeshKind::Looped),
        1 => Just(MeshKind::Nothing),
    ]
}

fn cloth() -> impl Strategy<Value = Cloth> {
    let sheet =
        (wild(0.2_f32..2.0), 0_u32..12, 2_u32..12).prop_map(|(size, columns, rows)| Cloth {
            shape: ClothShape::Sheet {
                size: Vec2::new(size, 1.0),
                particles: UVec2::new(columns, rows),
            },
        });
    prop_oneof![3 => sheet, 2 => Just(Cloth::of_mesh3d())]
}

fn cloth_material() -> impl Strategy<Value = ClothMaterial> {
    let usual = (wild(0.0_f32..3.0), wild(0.0_f32..1.0), wild(0.0_f32..0.02)).prop_map(
        |(drag, friction, thickness)| ClothMaterial {
            drag,
            friction,
            thickness,
            ..ClothMaterial::default()
        },
    );
    let any = material().prop_map(|m| ClothMaterial {
        area_density: m.area_density,
        thread_stiffness: m.thread_stiffness,
        shear_stiffness: m.shear_stiffness,
        flexural_rigidity: m.flexural_rigidity,
        bending_friction: m.bending_friction,
        damping: m.damping,
        damping_form: m.damping_form,
        drag: m.drag,
        max_strain: m.max_strain,
        friction: m.friction,
        thickness: m.thickness,
    });
    prop_oneof![2 => usual, 1 => any]
}

fn selection() -> impl Strategy<Value = PinSelection> {
    prop_oneof![
        prop::collection::vec(0_u32..80, 0..4).prop_map(PinSelection::Vertices),
        (wild_vector(0), wild_vector(0)).prop_map(|(min, max)| PinSelection::Within { min, max }),
        Just(PinSelection::Corners),
        Just(PinSelection::FirstRow),
        Just(PinSelection::LastColumn),
        Just(PinSelection::All),
    ]
}

fn pins() -> impl Strategy<Value = ClothPins> {
    let one = (selection(), prop::option::of((wild(0.1_f32..1e4), wild(0.0_f32..10.0)))).prop_map(
        |(selection, soft)| {
            let pins = ClothPins::from(selection);
            match soft {
                Some((stiffness, damping)) => pins.softly(stiffness, damping),
                None => pins,
            }
        },
    );
    prop::collection::vec(one, 1..3)
        .prop_map(|all| all.into_iter().reduce(ClothPins::and).unwrap_or_default())
}

fn factor() -> impl Strategy<Value = VertexFactor> {
    prop_oneof![
        Just(VertexFactor::Uniform),
        prop::collection::vec(wild(0.1_f32..4.0), 60..70).prop_map(VertexFactor::Data),
    ]
}

fn push_on() -> impl Strategy<Value = PushOn> {
    prop_oneof![
        (0_u32..90).prop_map(PushOn::Particle),
        (wild_vector(0), wild(0.1_f32..2.0), wild(0.0_f32..2.0))
            .prop_map(|(centre, radius, falloff)| PushOn::Within { centre, radius, falloff }),
    ]
}

fn push_with() -> impl Strategy<Value = PushWith> {
    (0..3_u8, wild_vector(1)).prop_map(|(which, by)| match which {
        0 => PushWith::Force(by),
        1 => PushWith::Impulse(by * 0.01),
        _ => PushWith::Velocity(by),
    })
}

fn proxy() -> impl Strategy<Value = ClothProxy> + Clone {
    prop_oneof![
        4 => (0_u32..9, 2_u32..9).prop_map(|(columns, rows)| ClothProxy::grid(columns, rows)),
        1 => wild(0.0_f32..1.0).prop_map(ClothProxy::ratio),
    ]
}

fn lod() -> impl Strategy<Value = ClothLod> {
    let level = (wild(0.0_f32..9.0), prop::option::of(1_u32..20), prop::option::of(proxy()))
        .prop_map(|(distance, substeps, proxy)| {
            let mut level = ClothLevel::at(distance);
            if let Some(budget) = substeps {
                level = level.substeps(budget);
            }
            ClothLevel { proxy, ..level }
        });
    (prop::collection::vec(level, 0..3), prop::option::of(0_u32..4))
        .prop_map(|(levels, given)| ClothLod { levels, given })
}

fn grab() -> impl Strategy<Value = ClothGrab> {
    let place = || wild_vector(0);
    prop_oneof![
        (0_u32..90, place()).prop_map(|(particle, to)| ClothGrab::particle(particle, to)),
        (place(), wild(0.1_f32..1.0), place())
            .prop_map(|(centre, radius, to)| ClothGrab::within(centre, radius, to)),
    ]
}

fn mass() -> impl Strategy<Value = ColliderMass> {
    (wild(0.1_f32..20.0), wild(0.1_f32..0.5), any::<bool>()).prop_map(|(mass, radius, sleeps)| {
        ColliderMass { sleeps, ..ColliderMass::sphere(mass, radius) }
    })
}

/// Solids of usual sizes, which reach nothing far away, and some of none.
fn collider() -> impl Strategy<Value = SdfCollider> {
    let size = || wild(0.05_f32..0.6).prop_map(|size| if size > 9.0 { 0.0 } else { size });
    let shape = (0..8_u8, size(), size(), vector(0.5)).prop_map(|(which, a, b, way)| match which {
        0 => SdfShape::from(Sphere::new(a)),
        1 => SdfShape::from(Cuboid::new(a, 0.3, b)),
        2 => SdfShape::from(Capsule3d::new(a, b)),
        3 => SdfShape::CapsuleBetween(CapsuleBetween { from: way, to: -way, radius: a }),
        4 => SdfShape::from(Cylinder::new(a, b)),
        5 => SdfShape::from(Torus { minor_radius: a, major_radius: b }),
        6 => SdfShape::from(Cone::new(a, b)),
        _ => SdfShape::from(Cuboid::new(a, 0.005, b)),
    });
    (shape, wild(0.0_f32..1.0))
        .prop_map(|(shape, friction)| SdfCollider::new(shape).with_friction(friction))
}

fn part() -> impl Strategy<Value = Part> {
    let distance = || prop::option::of(wild(0.001_f32..0.2));
    let surroundings = prop_oneof![
        3 => (pins(), prop::option::of(0..SLOTS)).prop_map(|(pins, anchor)| Part::Pins(pins, anchor)),
        1 => (factor(), factor()).prop_map(|(mass, stiffness)| Part::Weights(ClothWeights { mass, stiffness })),
        1 => (wild(0.0_f32..2.0), wild(0.0_f32..2.0), wild(0.0_f32..2.0))
            .prop_map(|(density, drag, lift)| Part::Air(ClothAir { density, drag, lift })),
        1 => (distance(), wild(0.0_f32..1.0))
            .prop_map(|(distance, friction)| Part::SelfCollision(ClothSelfCollision { distance, friction })),
        2 => (distance(), wild(0.0_f32..1.0), any::<u32>()).prop_map(|(distance, friction, layers)| {
            Part::InterCollision(ClothInterCollision { layers: (layers | 1).into(), distance, friction })
        }),
        1 => lod().prop_map(Part::Lod),
        1 => proxy().prop_map(Part::Proxy),
        1 => (0_u32..3).prop_map(|steps| Part::Paused(ClothPaused { steps })),
        1 => (wild(0.0_f32..0.1), wild(0.0_f32..0.2))
            .prop_map(|(distance, time)| Part::Sleep(ClothSleepThreshold { distance, time })),
        1 => (push_on(), wild_vector(0))
            .prop_map(|(on, force)| Part::Forces(ClothForce { on, force }.into())),
        2 => grab().prop_map(Part::Grab),
        1 => (wild(0.0_f32..1.0), wild(0.0_f32..1.0))
            .prop_map(|(linear, angular)| Part::Inertia(ClothInertia { linear, angular })),
        1 => (wild(0.0_f32..1.0), wild(0.0_f32..1.0))
            .prop_map(|(distance, angle)| Part::Teleport(ClothTeleport { distance, angle })),
    ];
    let others = prop_oneof![
        1 => wild(0.0_f32..1.0).prop_map(|after| Part::Culling(ClothCulling { after })),
        1 => prop::sample::select(&[ClothInterpolation::Blend, ClothInterpolation::LastTick][..])
            .prop_map(Part::Interpolation),
        1 => Just(Part::Skin(ClothSkin::default())),
        1 => Just(Part::Body(ClothBody::default())),
        1 => wild_vector(1).prop_map(|it| Part::Gravity(ClothGravityOverride(it))),
        1 => wild_vector(1).prop_map(|it| Part::Wind(ClothWindOverride(ClothWind::steady(it)))),
        1 => zone().prop_map(|zone| Part::Zone(WindZone { shape: zone.shape, flow: zone.flow, falloff: zone.falloff })),
        3 => collider().prop_map(Part::Collider),
        1 => Just(Part::Disabled(SdfColliderDisabled)),
        2 => mass().prop_map(Part::Mass),
        1 => (0..SLOTS).prop_map(Part::BodyOf),
        1 => Just(Part::Impulse(ColliderImpulse::default())),
        1 => (wild(0.001_f32..0.1), wild(0.1_f32..2.0))
            .prop_map(|(speed, longest)| Part::Hang(HangOnStart { speed, longest, ..HangOnStart::default() })),
    ];
    prop_oneof![
        3 => cloth().prop_map(Part::Cloth),
        2 => mesh_kind().prop_map(Part::Mesh),
        2 => cloth_material().prop_map(Part::Material),
        1 => settings().prop_map(|settings| Part::Settings(settings.into())),
        8 => surroundings,
        6 => others,
    ]
}

fn scale() -> impl Strategy<Value = Vec3> {
    let even = || (0.2_f32..3.0).prop_map(Vec3::splat);
    prop_oneof![4 => even(), 1 => (even(), vector(0.2)).prop_map(|(s, off)| s + off), 1 => wild_vector(1)]
}

fn deed() -> impl Strategy<Value = Deed> {
    let slot = || 0..SLOTS;
    prop_oneof![
        4 => (slot(), vector(0.8), prop::collection::vec(part(), 0..5))
            .prop_map(|(slot, at, parts)| Deed::Spawn(slot, at, parts)),
        1 => slot().prop_map(Deed::Despawn),
        12 => (slot(), part()).prop_map(|(slot, part)| Deed::Insert(slot, part)),
        4 => (slot(), 0..40_usize).prop_map(|(slot, which)| Deed::Remove(slot, which)),
        4 => (slot(), wild_vector(0), rotation()).prop_map(|(slot, by, turn)| Deed::Move(slot, by, turn)),
        1 => (slot(), scale()).prop_map(|(slot, scale)| Deed::Scale(slot, scale)),
        1 => (slot(), slot()).prop_map(|(child, parent)| Deed::Child(child, parent)),
        1 => slot().prop_map(Deed::Orphan),
        2 => (slot(), push_on(), push_with()).prop_map(|(slot, on, with)| Deed::Push(slot, on, with)),
        1 => slot().prop_map(Deed::Teleport),
        1 => slot().prop_map(Deed::Reset),
        1 => slot().prop_map(Deed::Wake),
        2 => (slot(), slot()).prop_map(|(from, to)| Deed::Restore(from, to)),
        1 => (slot(), mesh_kind()).prop_map(|(slot, kind)| Deed::Remake(slot, kind)),
        1 => slot().prop_map(Deed::DropMesh),
    ]
}

/// A frame: the deeds before it, and how many ticks it takes.
#[derive(Clone, Debug)]
pub struct Frame {
    pub deeds: Vec<Deed>,
    pub ticks: u32,
}

impl Frame {
    /// Without what happens in a frame and not in a tick: events of assets, and what is made in the background.
    pub fn in_ticks(mut self) -> Self {
        let hangs = |part: &Part| matches!(part, Part::Hang(_));
        self.deeds.retain_mut(|deed| match deed {
            Deed::Spawn(.., parts) => {
                parts.retain(|part| !hangs(part));
                true
            }
            Deed::Insert(_, part) => !hangs(part),
            Deed::Remake(..) | Deed::DropMesh(_) => false,
            // It comes from elsewhere, by a way that is spread over the ticks of the next frame.
            Deed::Restore(..) => self.ticks == 1,
            _ => true,
        });
        self
    }
}

pub fn script() -> impl Strategy<Value = Vec<Frame>> {
    let ticks = prop_oneof![6 => Just(1_u32), 1 => Just(0), 1 => 2_u32..4];
    let frame = (prop::collection::vec(deed(), 0..5), ticks)
        .prop_map(|(deeds, ticks)| Frame { deeds, ticks });
    let cloth = || (cloth(), any_vector(0), prop::collection::vec(part(), 0..4));
    // Two cloths and a solid to begin with.
    let first = (cloth(), cloth(), collider(), logarithmic(-1, 0)).prop_map(|(a, b, solid, y)| {
        let deed = |slot, (cloth, at, mut parts): (Cloth, Vec3, Vec<Part>)| {
            parts.extend([Part::Mesh(MeshKind::Grid(6, 7)), Part::Cloth(cloth)]);
            Deed::Spawn(slot, at, parts)
        };
        let solid = Deed::Spawn(2, Vec3::NEG_Y * y, vec![Part::Collider(solid)]);
        Frame { deeds: vec![deed(0, a), deed(1, b), solid], ticks: 1 }
    });
    (first, prop::collection::vec(frame, 1..16)).prop_map(|(first, mut frames)| {
        frames.insert(0, first);
        frames
    })
}
