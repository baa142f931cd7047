//! The exact motion of HANG: columns of rigid links, the first mass held.
//!
//! An inextensible sheet that hangs from two corners one width apart keeps its first row straight, so that every column swings as
//! the same planar chain of equal masses. Its motion is integrated with the tensions of the links as multipliers (a tridiagonal
//! system) by the method of Runge and Kutta of fourth order. At 32, 64 and 128 masses it is that of
//! `tests/data/hang_exact.csv`, which others were measured against, to the nanometre that the file has.

use bevy::math::{DVec2, DVec3, Vec3};
use bevy_drape::solver::ClothSolver;

use crate::speed::run::GRAVITY;

/// Length of a step \[s\].
const STEP: f64 = 2e-5;
/// Steps from one of the instants that are kept to the next: 0.1 s.
const EACH: usize = 5000;
/// How many are kept.
const INSTANTS: usize = 6;

/// Where the masses of a chain of one metre are at 0.1, 0.2 ... 0.6 s: distance from the held edge and height \[m\].
pub struct Motion(Vec<Vec<DVec2>>);

impl Motion {
    /// The motion of `n` masses, released in a horizontal line.
    pub fn new(n: usize) -> Self {
        let mut chain = Chain::level(n);
        let instant = |_| {
            (0..EACH).for_each(|_| chain.step());
            chain.x.clone()
        };
        Self((0..INSTANTS).map(instant).collect())
    }

    /// Mean square distance of all particles to the exact motion \[m2\]. `rest` says where they began: how far to the side, and
    /// how far from the held edge. Between two masses the sheet is straight.
    pub fn mean_square(&self, cloth: &ClothSolver, rest: &[Vec3], time: f64) -> f64 {
        let Some(masses) = self.0.get((time * 10.0).round() as usize - 1) else { return f64::NAN };
        let square = |(particle, rest): (usize, &Vec3)| {
            let at = f64::from(rest.z) * (masses.len() - 1) as f64;
            let link = (at as usize).min(masses.len() - 2);
            let exact = masses[link].lerp(masses[link + 1], at - link as f64);
            let exact = DVec3::new(f64::from(rest.x), exact.y, exact.x);
            cloth.position(particle).as_dvec3().distance_squared(exact)
        };
        rest.iter().enumerate().map(square).sum::<f64>() / rest.len() as f64
    }
}

/// Places and velocities of the masses.
struct Chain {
    x: Vec<DVec2>,
    v: Vec<DVec2>,
}

impl Chain {
    fn level(n: usize) -> Self {
        let link = 1.0 / (n - 1) as f64;
        let x = (0..n).map(|i| DVec2::new(i as f64 * link, 0.0)).collect();
        Self { x, v: vec![DVec2::ZERO; n] }
    }

    /// The chain where these rates lead it in some time.
    fn moved(&self, v: &[DVec2], a: &[DVec2], time: f64) -> Self {
        let add = |to: &[DVec2], rate: &[DVec2]| {
            to.iter().zip(rate).map(|(to, rate)| to + time * rate).collect()
        };
        Self { x: add(&self.x, v), v: add(&self.v, a) }
    }

    fn step(&mut self) {
        let a1 = self.accelerations();
        let second = self.moved(&self.v, &a1, STEP / 2.0);
        let a2 = second.accelerations();
        let third = self.moved(&second.v, &a2, STEP / 2.0);
        let a3 = third.accelerations();
        let fourth = self.moved(&third.v, &a3, STEP);
        let a4 = fourth.accelerations();
        for i in 0..self.x.len() {
            self.x[i] += STEP / 6.0 * (self.v[i] + 2.0 * (second.v[i] + third.v[i]) + fourth.v[i]);
            self.v[i] += STEP / 6.0 * (a1[i] + 2.0 * (a2[i] + a3[i]) + a4[i]);
        }
    }

    /// Accelerations by gravity and by tensions under which no link changes its length.
    fn accelerations(&self) -> Vec<DVec2> {
        let Self { x, v } = self;
        let gravity = DVec2::new(0.0, f64::from(GRAVITY.y));
        let links = x.len() - 1;
        let way: Vec<_> = x.windows(2).map(|ends| (ends[1] - ends[0]) * links as f64).collect();
        // The second derivative of each link's square is zero; the first mass has no acceleration.
        let (mut factor, mut tension) = (vec![0.0; links], vec![0.0; links]);
        for i in 0..links {
            let turn = (v[i + 1] - v[i]).length_squared() * links as f64;
            let (held, own) = if i == 0 { (way[0].dot(gravity), 1.0) } else { (0.0, 2.0) };
            let before = i.checked_sub(1);
            let beside = before.map_or(0.0, |before| way[i].dot(way[before]));
            let pivot = own - beside * before.map_or(0.0, |before| factor[before]);
            factor[i] = way.get(i + 1).map_or(0.0, |next| way[i].dot(*next)) / pivot;
            let carried = beside * before.map_or(0.0, |before| tension[before]);
            tension[i] = (turn + held + carried) / pivot;
        }
        for i in (0..links - 1).rev() {
            tension[i] += factor[i] * tension[i + 1];
        }
        let mut a = vec![DVec2::ZERO; x.len()];
        for (i, way) in way.iter().enumerate() {
            if i > 0 {
                a[i] += tension[i] * way;
            }
            a[i + 1] += gravity - tension[i] * way;
        }
        a
    }
}
