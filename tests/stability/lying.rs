//! Sheets and meshes of 64 x 64 that have been dropped on solids with edges and tips, as a user has them. Truth: after twenty
//! seconds a cloth hardly moves, and no thread is longer than its strain limit allows.

use crate::support::{kinds::*, sheets::mesh, solver::*};
use bevy::math::{
    Vec2, Vec3,
    primitives::{Cone, Cuboid, Cylinder, InfinitePlane3d, Sphere},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Collider, MassLumping, Material, Pose, Settings, Substeps, Topology},
};

const N: usize = 64;

/// A cloth that is dropped on a solid which stands on the ground.
struct Scene<'a> {
    solid: &'a dyn SignedDistance,
    /// Height of its middle \[m\].
    middle: f32,
    /// Side of the cloth, and how high above the ground it starts \[m\].
    side: f32,
    from: f32,
    budget: u32,
    /// The rms speed that is at rest \[m/s\].
    speed: f64,
}

impl Scene<'_> {
    /// Drops a sheet, and checks that it has come to rest within its strain limit.
    fn sheet(self) -> ClothSolver {
        let sheet = sheet(Vec2::splat(self.side), N, N, MassLumping::Lumped);
        let (solver, _) = self.of(sheet.into(), Vec3::ZERO);
        let [p99, largest] = strains(&solver);
        check_at_most("strain of 99 in 100", p99, 0.01);
        check_at_most("largest strain", largest, 0.11);
        solver
    }

    /// Drops an irregular mesh, and checks that it has come to rest; it stretches by 1.5 in 100 at most, where 5 in 100 were
    /// left before what chains leave was made up for.
    fn mesh(self) -> (ClothSolver, f64) {
        let mesh = mesh(N, N, self.side / (N - 1) as f32, 0.3);
        let to_middle = Vec3::new(-0.5, 0.0, -0.5) * self.side;
        let (solver, speed) = self.of(mesh.into(), to_middle);
        check_at_most("strain of 99 in 100", strains(&solver)[0], 0.015);
        (solver, speed)
    }

    /// Tells the rms speed of its twentieth second as well \[m/s\].
    fn of(&self, topology: Topology, by: Vec3) -> (ClothSolver, f64) {
        let by = by + Vec3::Y * self.from;
        let start: Vec<_> = topology.rest_positions().iter().map(|&p| p + by).collect();
        let substeps = Substeps::Automatic { budget: self.budget };
        let settings = Settings { substeps, ..Settings::default() };
        // Hardly anything stops it. Whether a mesh's hem trembles depends on how it happens to lie: with other drags, some do.
        let material = Material { drag: 0.2, ..usual() };
        let mut solver = ClothSolver::new(topology, &start, material, settings).unwrap();
        let floor = InfinitePlane3d::new(Vec3::Y);
        let colliders = [
            Collider::new(&floor, Pose::IDENTITY),
            Collider::new(self.solid, Pose::from_translation(Vec3::Y * self.middle)),
        ];
        run(&mut solver, 19 * SECOND, GRAVITY, &colliders);
        let speed = speed_of(&mut solver, &colliders);
        check_at_most("rms speed [m/s]", speed, self.speed);
        (solver, speed)
    }
}

/// Rms speed in the next second \[m/s\].
pub(crate) fn speed_of(solver: &mut ClothSolver, colliders: &[Collider<'_>]) -> f64 {
    let mut squares = 0.0;
    let mut before = positions(solver);
    for _ in 0..SECOND {
        run(solver, 1, GRAVITY, colliders);
        let now = positions(solver);
        let moved = before.iter().zip(&now).map(|(a, b)| f64::from(a.distance_squared(*b)));
        squares += moved.sum::<f64>();
        before = now;
    }
    (squares / (SECOND * before.len()) as f64).sqrt() * SECOND as f64
}

/// The strain that 99 in 100 springs stay below, and the largest.
fn strains(solver: &ClothSolver) -> [f64; 2] {
    let places = positions(solver);
    let mut strains: Vec<f64> = solver
        .topology()
        .structural_springs()
        .map(|(a, b, rest)| f64::from(places[a].distance(places[b]) / rest) - 1.0)
        .collect();
    strains.sort_by(f64::total_cmp);
    [strains[strains.len() * 99 / 100], strains[strains.len() - 1]]
}

#[test]
fn on_a_cube() {
    Scene {
        solid: &Cuboid::new(0.8, 0.8, 0.8),
        middle: 0.4,
        side: 2.0,
        from: 1.2,
        budget: 8,
        speed: 1.5e-3,
    }
    .sheet();
}

/// Chains of few substeps leave much to do, and shake the cloth where nothing is carried on.
#[test]
fn a_mesh_on_a_cube() {
    let solid = &Cuboid::new(0.8, 0.8, 0.8);
    let scene = |from| Scene { solid, middle: 0.4, side: 2.0, from, budget: 8, speed: 2e-2 };
    are_mostly_still([1.18, 1.19, 1.2, 1.21, 1.22].map(scene), 2e-3);
}

#[test]
fn a_mesh_on_a_cone() {
    let solid = &Cone { radius: 0.5, height: 0.8 };
    let scene = |from| Scene { solid, middle: 0.4, side: 1.6, from, budget: 20, speed: 3e-3 };
    are_mostly_still([1.28, 1.29, 1.3, 1.31, 1.32].map(scene), 3e-4);
}

/// Whether a mesh's hem trembles depends on how it happens to lie: most hardly do.
fn are_mostly_still(draws: [Scene<'_>; 5], speed: f64) {
    let speeds = draws.map(|draw| {
        let (solver, speed) = draw.mesh();
        assert!(solver.bounds().1.y > 0.75, "it slid off: {}", solver.bounds().1);
        speed
    });
    let still = speeds.iter().filter(|&&own| own < speed).count();
    println!("{still} of 5 are still: {speeds:?} m/s");
    assert!(still >= 3, "{speeds:?} m/s");
}

#[test]
fn on_a_cylinder() {
    Scene {
        solid: &Cylinder::new(0.5, 0.8),
        middle: 0.4,
        side: 1.6,
        from: 1.3,
        budget: 8,
        speed: 6e-4,
    }
    .sheet();
}

/// Its tip carries all of the cloth on a particle or two. With few substeps it is stretched the most, and there it swings
/// the longest: 0.00 to 1.3 mm/s are left, as the drop comes out.
#[test]
fn on_a_cone() {
    let solver = Scene {
        solid: &Cone { radius: 0.5, height: 0.8 },
        middle: 0.4,
        side: 1.6,
        from: 1.3,
        budget: 8,
        speed: 1.5e-3,
    }
    .sheet();
    assert!(solver.bounds().1.y > 0.75, "it slid off: {}", solver.bounds().1);
}

/// A small ball under a cloth that lies on the ground.
#[test]
fn on_a_small_ball() {
    for budget in [20, 8] {
        Scene {
            solid: &Sphere::new(0.05),
            middle: 0.05,
            side: 1.6,
            from: 1.3,
            budget,
            speed: 2e-4,
        }
        .sheet();
    }
}
