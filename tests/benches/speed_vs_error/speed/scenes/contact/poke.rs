//! P11 POKE: no solid shows through a cloth that lies on it, and none that is thin falls through it.

use bevy::math::{
    Quat, Vec3,
    primitives::{Cone, Cuboid, Cylinder},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Material, Pose},
};

use super::super::super::run::Run;
use super::super::super::{Extent, Job, Measured, Metric, Outcome, Scene};
use super::{Cloth, ground, over_ground, places};

const SIDE: f32 = 1.6;
/// 10 s.
const FRAMES: usize = 600;
/// A face is looked at in so many places along each side.
const LOOKS: u32 = 12;

#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    /// Speed that it is dropped with \[m/s\].
    speed: f32,
}

const CASES: [Case; 8] = [
    Case { name: "cube", speed: 0.0 },
    Case { name: "cone", speed: 0.0 },
    Case { name: "post of 2 cm", speed: 0.0 },
    Case { name: "post of 2 cm", speed: 3.0 },
    Case { name: "rod of 1 cm", speed: 0.0 },
    Case { name: "rod of 5 mm", speed: 3.0 },
    Case { name: "plate of 5 mm", speed: 0.0 },
    Case { name: "plate of 5 mm", speed: 3.0 },
];

impl Case {
    fn solid(self) -> (Box<dyn SignedDistance>, Pose) {
        let upright = Pose::from_translation(Vec3::Y * 0.4);
        let rotation = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
        let lying = Pose { rotation, ..Pose::from_translation(Vec3::Y * 0.7) };
        match self.name {
            "cube" => (Box::new(Cuboid::new(0.8, 0.8, 0.8)), upright),
            "cone" => (Box::new(Cone::new(0.5, 0.8)), upright),
            "post of 2 cm" => (Box::new(Cylinder::new(0.02, 0.8)), upright),
            "rod of 1 cm" => (Box::new(Cylinder::new(0.01, 2.4)), lying),
            "rod of 5 mm" => (Box::new(Cylinder::new(0.005, 2.4)), lying),
            _ => (Box::new(Cuboid::new(0.8, 0.8, 0.005)), upright),
        }
    }

    fn run(self, cloth: Cloth) -> Outcome<Measured> {
        let (ground, (solid, pose)) = (ground(), self.solid());
        let colliders = over_ground(&ground, &*solid, pose);
        // Off the middle of what is thinner than the particles are apart.
        let from = Vec3::new(0.01, 1.2, 0.007);
        let mut solver = cloth.solver(Material::USUAL, |at| at + from)?;
        for i in 0..cloth.n * cloth.n {
            solver.set_velocity(i, Vec3::NEG_Y * self.speed)?;
        }
        let mut run = Run::new(solver, &colliders);
        run.frames(FRAMES);
        let deepest = deepest(&run.cloth, cloth, &*solid, pose);
        let top = f64::from(run.cloth.bounds().1.y);
        let strain = f64::from(run.cloth.strain().max) * 100.0;
        // What lies on the ground as a whole has slid off.
        let fell_through = (0.05..=0.5).contains(&top);
        let mut measured = run.measured(vec![deepest * 1e3, top, strain]);
        if fell_through {
            measured.failed = Some("fell through".into());
        }
        Ok(measured)
    }
}

/// How deep any place of any face is inside \[m\].
fn deepest(solver: &ClothSolver, cloth: Cloth, solid: &dyn SignedDistance, pose: Pose) -> f64 {
    let (at, back) = (places(solver), pose.rotation.inverse());
    let faces: Vec<_> = match solver.topology().as_graph() {
        Some(graph) => graph.triangles().to_vec(),
        None => cloth.cells().flat_map(|[a, b, c, d]| [[a, c, d], [a, d, b]]).collect(),
    };
    let mut least = f32::INFINITY;
    for face in faces {
        let [a, b, c] = face.map(|i| at[i as usize]);
        for i in 0..=LOOKS {
            for j in 0..=LOOKS - i {
                let [u, v] = [i, j].map(|part| part as f32 / LOOKS as f32);
                let place = a + (b - a) * u + (c - a) * v;
                least = least.min(solid.distance(back * (place - pose.translation)));
            }
        }
    }
    f64::from(-least).max(0.0)
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let sizes: &[usize] = if extent.quick { &[32] } else { &[16, 32, 64, 128] };
    let mut jobs = Vec::new();
    for case in CASES {
        for &n in sizes {
            // The smaller budget changes little here.
            for cloth in Cloth::all(SIDE, n, extent).into_iter().filter(|cloth| cloth.budget == 20)
            {
                jobs.push(Job {
                    method: format!("{} at {} m/s, {}", case.name, case.speed, cloth.method()),
                    n,
                    knob: cloth.knob(),
                    run: Box::new(move || case.run(cloth)),
                });
            }
        }
    }
    Ok(Scene {
        name: "p11",
        title: "P11 POKE: what a cloth lies on does not show through it",
        about: "1.6 m x 1.6 m of the usual material, dropped from 1.2 m on a cube of 0.8 m, a cone of radius 0.5 m and height 0.8 m, an upright \
                post, a lying rod or a plate on edge; 10 s. The deepest place of any face inside the solid (particles are held 5 mm \
                outside), the highest particle, the largest strain. Particles at 16 a side are 11 cm apart."
            .into(),
        errors: vec![
            Metric::new("depth", "mm"),
            Metric::new("highest", "m"),
            Metric::new("largest strain", "%"),
        ],
        jobs,
        plots: Vec::new(),
    })
}
