//! Where the joints of a skinned mesh are now.

use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use crate::pose::root::Root;

/// The joints of a skinned mesh, in its order.
#[derive(Clone, Debug)]
pub(crate) struct Skeleton {
    pub joints: Vec<Entity>,
    /// From the mesh's frame to each joint's, when the mesh is as it was modelled.
    inverse_bindposes: Vec<Affine3A>,
    /// All of them, parents before their children, each with its parent where that is a joint as well.
    order: Vec<(u16, Option<u16>)>,
}

impl PartialEq for Skeleton {
    /// Whether it has the same joints, bound alike. How they are connected may change.
    fn eq(&self, other: &Self) -> bool {
        self.joints == other.joints && self.inverse_bindposes == other.inverse_bindposes
    }
}

/// Where the joints of a skeleton were seen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seen {
    /// Places of the joints in the world.
    places: Vec<Affine3A>,
    /// How they move the mesh: from its own frame into the world.
    pub matrices: Vec<Affine3A>,
}

/// Looks where joints are.
#[derive(SystemParam)]
pub(crate) struct Joints<'w, 's> {
    places: Query<'w, 's, (&'static Transform, Option<&'static ChildOf>)>,
}

impl Joints<'_, '_> {
    /// The skeleton of these joints, as they are connected now.
    pub fn skeleton(&self, joints: &[Entity], inverse_bindposes: &[Mat4]) -> Skeleton {
        let index_of: HashMap<Entity, u16> = joints.iter().copied().zip(0..).collect();
        let parent_of = |entity| self.places.get(entity).ok()?.1.map(ChildOf::parent);
        let depth = |joint: &u16| {
            let up = |entity: &Entity| parent_of(*entity);
            core::iter::successors(Some(joints[*joint as usize]), up).count()
        };
        let mut order: Vec<u16> = (0..joints.len() as u16).collect();
        order.sort_by_cached_key(depth);
        let with_parent = |joint: u16| {
            let parent = parent_of(joints[joint as usize]);
            (joint, parent.and_then(|parent| index_of.get(&parent).copied()))
        };
        Skeleton {
            joints: joints.to_vec(),
            inverse_bindposes: inverse_bindposes
                .iter()
                .map(|it| Affine3A::from_mat4(*it))
                .collect(),
            order: order.into_iter().map(with_parent).collect(),
        }
    }

    /// The root of an entity.
    pub fn root(&self, entity: Entity) -> Root {
        Root::of(entity, |it| {
            let (place, parent) = self.places.get(it).ok()?;
            Some((*place, parent.map(ChildOf::parent)))
        })
    }

    /// Looks where all joints are.
    ///
    /// # Errors
    /// The first joint that has no place (it, or one of its ancestors, is not there or has no `Transform`). Such joints stay where
    /// they were seen last.
    pub fn look(&self, skeleton: &Skeleton, seen: &mut Seen) -> Result<(), Entity> {
        let mut gone = Ok(());
        let Seen { places: out, matrices } = seen;
        out.resize(skeleton.joints.len(), Affine3A::IDENTITY);
        for &(joint, parent) in &skeleton.order {
            let entity = skeleton.joints[joint as usize];
            let place = match self.places.get(entity) {
                // Without a walk up to the root.
                Ok((local, Some(above)))
                    if parent.is_some_and(|it| skeleton.joints[it as usize] == above.parent()) =>
                {
                    let parent = usize::from(parent.unwrap_or_default());
                    Some(out[parent] * local.compute_affine())
                }
                Ok((local, above)) => self.below(above, local.compute_affine()),
                Err(_) => None,
            };
            match place {
                Some(place) => out[joint as usize] = place,
                None => gone = gone.and(Err(entity)),
            }
        }
        matrices.clear();
        matrices
            .extend(out.iter().zip(&skeleton.inverse_bindposes).map(|(out, bind)| *out * *bind));
        gone
    }

    /// What is at a place of its parent, in the world.
    fn below(&self, parent: Option<&ChildOf>, local: Affine3A) -> Option<Affine3A> {
        let (mut above, mut place) = (parent, local);
        while let Some(parent) = above {
            let (local, next) = self.places.get(parent.parent()).ok()?;
            place = local.compute_affine() * place;
            above = next;
        }
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::ecs::system::RunSystemOnce;

    #[test]
    fn joints_are_where_their_ancestors_put_them() {
        let mut world = World::new();
        let turn =
            Transform::from_rotation(Quat::from_rotation_z(0.7)).with_scale(Vec3::splat(2.0));
        let root = world.spawn(Transform::from_xyz(1.0, 2.0, 3.0)).id();
        let hip = world.spawn((turn, ChildOf(root))).id();
        // Between two joints is an entity that is none.
        let between = world.spawn((Transform::from_xyz(0.0, 0.5, 0.0), ChildOf(hip))).id();
        let knee = world.spawn((Transform::from_xyz(0.0, -1.0, 0.0), ChildOf(between))).id();
        let foot = world.spawn((Transform::from_xyz(0.3, 0.0, 0.0), ChildOf(knee))).id();
        // Children first.
        let joints = [foot, knee, hip];
        let bind = Mat4::from_translation(Vec3::new(0.0, -1.0, 0.0));
        let skeleton = move |it: Joints| it.skeleton(&joints, &[bind; 3]);
        let skeleton = world.run_system_once(skeleton).unwrap();
        assert_eq!(skeleton.order, [(2, None), (1, None), (0, Some(1))]);
        let mut seen = Seen::default();
        let mut look = |world: &mut World| {
            let (skeleton, mut now) = (skeleton.clone(), seen.clone());
            let look = move |joints: Joints, transforms: TransformHelper| {
                let gone = joints.look(&skeleton, &mut now);
                let place = |&joint: &Entity| transforms.compute_global_transform(joint).ok();
                (gone, now.clone(), skeleton.joints.iter().map(place).collect::<Vec<_>>())
            };
            let (gone, now, expected) = world.run_system_once(look).unwrap();
            seen = now.clone();
            (gone, now.matrices, expected)
        };
        let at = |place: Option<GlobalTransform>| {
            place.unwrap().affine() * Affine3A::from_translation(Vec3::NEG_Y)
        };
        let (gone, before, expected) = look(&mut world);
        assert_eq!(gone, Ok(()));
        for (seen, expected) in before.iter().zip(expected) {
            assert!(seen.abs_diff_eq(at(expected), 1e-6), "{seen} {expected:?}");
        }
        // Another parent, and one that is gone.
        world.entity_mut(foot).insert(ChildOf(root));
        world.entity_mut(hip).insert(Transform::from_xyz(5.0, 0.0, 0.0));
        world.entity_mut(between).remove::<Transform>();
        let (gone, now, expected) = look(&mut world);
        assert_eq!(gone, Err(knee));
        for joint in [0, 2] {
            assert!(now[joint].abs_diff_eq(at(expected[joint]), 1e-6));
            assert!(!now[joint].abs_diff_eq(before[joint], 0.1));
        }
        assert_eq!((expected[1], now[1]), (None, before[1]));
    }
}
