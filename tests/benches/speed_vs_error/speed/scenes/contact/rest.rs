//! P9 REST: a cloth dropped on a solid comes to rest.

use bevy::math::{
    Vec3,
    primitives::{Cone, Cuboid, Cylinder, Sphere},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Material, Pose},
};

use super::super::super::run::{GRAVITY, Run};
use super::super::super::{Extent, Job, Measured, Metric, Outcome, Scene};
use super::{Cloth, ground, over_ground, peers, places};

const N: usize = 64;
const SECOND: usize = 60;
/// 20 s.
const FRAMES: usize = 20 * SECOND;
/// Speed of a particle that moves to be seen \[m/s\].
const SEEN: f32 = 0.01;

#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    side: f32,
    from: f32,
}

const CASES: [Case; 4] = [
    Case { name: "cube", side: 2.0, from: 1.2 },
    Case { name: "cylinder", side: 1.6, from: 1.3 },
    Case { name: "cone", side: 1.6, from: 1.3 },
    Case { name: "ball", side: 1.6, from: 1.3 },
];

impl Case {
    fn solid(&self) -> (Box<dyn SignedDistance>, Pose) {
        let at = |height: f32| Pose::from_translation(Vec3::Y * height);
        match self.name {
            "cube" => (Box::new(Cuboid::new(0.8, 0.8, 0.8)), at(0.4)),
            "cylinder" => (Box::new(Cylinder::new(0.5, 0.8)), at(0.4)),
            "cone" => (Box::new(Cone::new(0.5, 0.8)), at(0.4)),
            _ => (Box::new(Sphere::new(0.05)), at(0.05)),
        }
    }

    fn run(&self, cloth: Cloth) -> Outcome<Measured> {
        let (ground, (solid, pose)) = (ground(), self.solid());
        let colliders = over_ground(&ground, &*solid, pose);
        let from = Vec3::Y * self.from;
        let solver = cloth.solver(Material::USUAL, |at| at + from)?;
        let mut run = Run::new(solver, &colliders);
        let mut last = Second::default();
        let mut energies = Vec::new();
        let mut still = f64::NAN;
        for second in 1..=FRAMES / SECOND {
            last = Second::of(&mut run);
            energies.push(energy(&run.cloth));
            if last.seen > 0 {
                still = f64::NAN;
            } else if still.is_nan() {
                still = second as f64;
            }
        }
        let rises = energies.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        let count = run.cloth.topology().particle_count();
        let square = |i| f64::from(run.cloth.velocity(i).length_squared());
        let velocity = ((0..count).map(square).sum::<f64>() / count as f64).sqrt() * 1e3;
        let strain = run.cloth.strain();
        let [p99, largest] = [strain.p99, strain.max].map(|strain| f64::from(strain) * 100.0);
        let errors = vec![
            last.rms,
            velocity,
            last.largest,
            last.seen as f64 / SECOND as f64,
            p99,
            largest,
            still,
            rises * 1e3,
        ];
        Ok(run.measured(errors))
    }
}

/// How a cloth moved in a second, once a frame.
#[derive(Default)]
struct Second {
    /// \[mm/s\].
    rms: f64,
    /// Largest move of a particle in a frame \[mm\].
    largest: f64,
    /// How many moved to be seen, summed up over the frames.
    seen: usize,
}

impl Second {
    fn of(run: &mut Run<'_>) -> Self {
        let mut second = Self::default();
        let mut square = 0.0;
        let mut before = places(&run.cloth);
        for _ in 0..SECOND {
            run.frame();
            let now = places(&run.cloth);
            for (before, now) in before.iter().zip(&now) {
                let way = before.distance(*now);
                square += f64::from(way * way);
                second.largest = second.largest.max(f64::from(way) * 1e3);
                second.seen += usize::from(way * SECOND as f32 > SEEN);
            }
            before = now;
        }
        second.rms = (square / (SECOND * before.len()) as f64).sqrt() * SECOND as f64 * 1e3;
        second
    }
}

/// Energy of motion, height and threads \[J\].
fn energy(cloth: &ClothSolver) -> f64 {
    let particle = |i: usize| {
        let (mass, at, velocity) = (cloth.mass(i), cloth.position(i), cloth.velocity(i));
        f64::from(mass) * f64::from(0.5 * velocity.length_squared() - GRAVITY.dot(at))
    };
    let count = cloth.topology().particle_count();
    let cell = (cloth.topology().total_area() / count as f32).sqrt();
    let thread = |(a, b, rest): (usize, usize, f32)| {
        // As wide as a cell.
        let stretch = cloth.position(a).distance(cloth.position(b)) - rest;
        let stiffness = Material::USUAL.thread_stiffness * cell / rest;
        0.5 * f64::from(stiffness) * f64::from(stretch * stretch)
    };
    (0..count).map(particle).sum::<f64>()
        + cloth.topology().structural_springs().map(thread).sum::<f64>()
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let mut jobs = Vec::new();
    for case in CASES {
        for cloth in Cloth::all(case.side, N, extent) {
            jobs.push(Job {
                method: format!("{}, {}", case.name, cloth.method()),
                n: N,
                knob: cloth.knob(),
                run: Box::new(move || case.run(cloth)),
            });
        }
    }
    let columns = ["rms_mm_s", "", "move_mm", "above_1_cm_s", "p99", "largest", "", ""];
    jobs.extend(peers::jobs("peer_contact.csv", "rest", N, &columns)?);
    Ok(Scene {
        name: "p9",
        title: "P9 REST: a cloth dropped on a solid comes to rest",
        about: "64 x 64 particles of the usual material, 1.6 m x 1.6 m from 1.3 m (2 m x 2 m from 1.2 m on the cube), on the ground with a cube \
                of 0.8 m, a cylinder or a cone of radius 0.5 m and height 0.8 m, or a ball of 5 cm; a sheet, and a mesh with \
                vertices jittered by 0.3 spacings and random diagonals. After 20 s: motion once a frame over the last second (rms, largest \
                move, particles above 1 cm/s in a frame), rms of the velocity inside the solver, strain of the threads; when no particle \
                moved faster than 1 cm/s any more; the most that energy of motion, height and threads rose from one second to \
                the next. Others: their strain after 40 s, times of their own machine."
            .into(),
        errors: vec![
            Metric::new("motion", "mm/s"),
            Metric::new("velocity", "mm/s"),
            Metric::new("largest move", "mm"),
            Metric::new("above 1 cm/s", ""),
            Metric::new("p99 strain", "%"),
            Metric::new("largest strain", "%"),
            Metric::new("still after", "s"),
            Metric::new("energy gained", "mJ"),
        ],
        jobs,
        plots: Vec::new(),
    })
}
