//! The check that every example ends in.

use bevy::prelude::*;
use bevy_drape::{ClothInterCollision, ClothSelfCollision, prelude::*};

/// Where the scene's cloths must be at the end \[m\]; the ground is at y = 0.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Bounds {
    /// Their lowest corner.
    pub min: Vec3,
    /// Their highest.
    pub max: Vec3,
}

/// How deep a particle may be in the ground \[m\].
const DEEPEST: f32 = 1e-4;

/// Checks that every cloth runs, is finite, above the ground and inside the scene's box, and that none which collides with
/// itself or with others has passed through itself or through these.
///
/// # Errors
/// What is wrong, in words.
pub fn check(world: &mut World) -> Result<(), String> {
    let bounds = *world.resource::<Bounds>();
    if let Some(failure) = world.query::<&ClothFailure>().iter(world).next() {
        return Err(failure.error.to_string());
    }
    let mut cloths =
        world.query_filtered::<(Option<&ClothSimulation>, Has<ClothSelfCollision>), With<Cloth>>();
    if cloths.iter(world).len() == 0 {
        return Err("there is no cloth".into());
    }
    for (cloth, collides) in cloths.iter(world) {
        let cloth = cloth.ok_or("a cloth has not been set up")?;
        if cloth.tick_count() == 0 {
            return Err("a cloth has not been simulated".into());
        }
        if collides && cloth.crossings() > 0 {
            let crossings = cloth.crossings();
            return Err(format!("a cloth has passed through itself: {crossings} crossings"));
        }
        for position in cloth.positions() {
            if !position.is_finite() {
                return Err(format!("a particle is at {position}"));
            }
            if position.y < -DEEPEST {
                return Err(format!("a particle at {position} is below the ground"));
            }
            let inside = position.cmpge(bounds.min - DEEPEST) & position.cmple(bounds.max);
            if !inside.all() {
                return Err(format!(
                    "a particle at {position} has left the scene's box {bounds:?}"
                ));
            }
        }
    }
    let mut colliding = world.query_filtered::<&ClothSimulation, With<ClothInterCollision>>();
    let colliding: Vec<_> = colliding.iter(world).collect();
    for (place, one) in colliding.iter().enumerate() {
        let crossings: u32 = colliding[..place].iter().map(|other| one.crossings_with(other)).sum();
        if crossings > 0 {
            return Err(format!("cloths have passed through each other: {crossings} crossings"));
        }
    }
    Ok(())
}
