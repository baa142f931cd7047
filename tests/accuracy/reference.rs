//! The mass-spring model in `f64`, written from its formulas and from nothing of the crate's: what the
//! solver of `f32` is held to, and what meets closed forms to rounding.
//!
//! A sheet of spacing a x b has, for widths of cloth w that a thread stands for: structural springs
//! `ks w / a`; two shear springs a cell, `kd (a^2 + b^2) / (2 a b)`; hinges of energy
//! `B w / (2 a^3) |x0 - 2 x1 + x2|^2`, twice that at a clamp; or flexion springs over two cells, which
//! resist as the rigidity B does at the curvature of 20 1/m: `8 B w / (20^2 a^5)`. Springs are damped by
//! `C` times the same shape factor.

use bevy::math::{DVec2, DVec3};

/// Curvature at which flexion springs resist as much as second differences do [1/m].
pub const FLEXION_CURVATURE: f64 = 20.0;

#[derive(Clone, Copy)]
pub struct Spring {
    pub ends: [usize; 2],
    pub constant: f64,
    pub rest: f64,
}

/// Energy `constant / 2 |x0 - 2 x1 + x2|^2`.
#[derive(Clone, Copy)]
pub struct Hinge {
    pub at: [usize; 3],
    pub constant: f64,
}

#[derive(Clone, Copy)]
pub struct Damper {
    pub ends: [usize; 2],
    pub constant: f64,
}

/// What a sheet is made of; all else than its density is off by default.
#[derive(Clone, Copy)]
pub struct Fabric {
    pub density: f64,
    pub thread: f64,
    pub shear: f64,
    pub rigidity: f64,
    pub flexion: bool,
    pub damping: f64,
    pub axial: bool,
    pub drag: f64,
    /// Every particle weighs the same, and springs of the border are whole.
    pub equal: bool,
}

impl Default for Fabric {
    fn default() -> Self {
        Self {
            density: 0.2,
            thread: 0.0,
            shear: 0.0,
            rigidity: 0.0,
            flexion: false,
            damping: 0.0,
            axial: true,
            drag: 0.0,
            equal: false,
        }
    }
}

#[derive(Clone, Default)]
pub struct Model {
    pub mass: Vec<f64>,
    pub held: Vec<bool>,
    pub springs: Vec<Spring>,
    pub hinges: Vec<Hinge>,
    pub dampers: Vec<Damper>,
    pub axial: bool,
    pub drag: f64,
    pub gravity: DVec3,
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Method {
    Verlet,
    Euler,
    Midpoint,
}

/// Where the particles are, and how fast: with Verlet at the middle of the last step, of length `last`.
#[derive(Clone)]
pub struct Motion {
    pub x: Vec<DVec3>,
    pub v: Vec<DVec3>,
    pub last: f64,
}

impl Motion {
    pub fn at_rest(x: &[DVec3]) -> Self {
        Self { x: x.to_vec(), v: vec![DVec3::ZERO; x.len()], last: 0.0 }
    }
}

impl Model {
    /// A sheet of `cells` of size `cell`: columns along the first axis, rows along the second.
    pub fn sheet(fabric: &Fabric, cells: [usize; 2], cell: DVec2, held: &[usize]) -> Self {
        let (columns, rows) = (cells[0] + 1, cells[1] + 1);
        let count = rows * columns;
        let is_held = |i: usize| held.contains(&i);
        let mut model = Self {
            held: (0..count).map(is_held).collect(),
            axial: fabric.axial,
            drag: fabric.drag,
            ..Self::default()
        };
        // A border particle stands for half a cell.
        let half = |i: usize, n: usize| if i == 0 || i + 1 == n { 0.5 } else { 1.0 };
        let area = cell.x * cell.y * (cells[0] * cells[1]) as f64;
        for r in 0..rows {
            for c in 0..columns {
                let share = half(r, rows) * half(c, columns) * cell.x * cell.y;
                let area = if fabric.equal { area / count as f64 } else { share };
                model.mass.push(fabric.density * area);
            }
        }
        let width = |i: usize, n: usize| if fabric.equal { 1.0 } else { half(i, n) };
        for r in 0..rows {
            for c in 0..columns {
                // Along weft, then along warp.
                for (place, n, other, hop, a) in [
                    (c, columns, width(r, rows) * cell.y, 1, cell.x),
                    (r, rows, width(c, columns) * cell.x, columns, cell.y),
                ] {
                    let i = r * columns + c;
                    if place + 1 < n {
                        model.join(fabric, [i, i + hop], fabric.thread, other / a, a);
                    }
                    if place + 2 < n {
                        model.bend(fabric, [i, i + hop, i + 2 * hop], other, a);
                    }
                }
                if r + 1 < rows && c + 1 < columns && fabric.shear > 0.0 {
                    let i = r * columns + c;
                    let shape = cell.length_squared() / (2.0 * cell.x * cell.y);
                    for ends in [[i, i + columns + 1], [i + 1, i + columns]] {
                        model.join(fabric, ends, fabric.shear, shape, cell.length());
                    }
                }
            }
        }
        model
    }

    fn join(&mut self, fabric: &Fabric, ends: [usize; 2], k: f64, shape: f64, rest: f64) {
        if k > 0.0 {
            self.springs.push(Spring { ends, constant: k * shape, rest });
        }
        if fabric.damping > 0.0 {
            self.dampers.push(Damper { ends, constant: fabric.damping * shape });
        }
    }

    fn bend(&mut self, fabric: &Fabric, at: [usize; 3], width: f64, a: f64) {
        if fabric.rigidity == 0.0 {
            return;
        }
        if fabric.flexion {
            let rigidity = 8.0 * fabric.rigidity / FLEXION_CURVATURE.powi(2);
            let constant = rigidity * width / a.powi(5);
            self.springs.push(Spring { ends: [at[0], at[2]], constant, rest: 2.0 * a });
        } else {
            let clamp = self.held[at[1]] && self.held[at[0]] != self.held[at[2]];
            let constant = fabric.rigidity * width / a.powi(3) * if clamp { 2.0 } else { 1.0 };
            self.hinges.push(Hinge { at, constant });
        }
    }

    /// Forces of springs and hinges alone [N].
    pub fn forces(&self, x: &[DVec3]) -> Vec<DVec3> {
        let mut force = vec![DVec3::ZERO; x.len()];
        for spring in &self.springs {
            let [i, j] = spring.ends;
            let pull = (x[j] - x[i]).normalize_or_zero()
                * (spring.constant * (x[i].distance(x[j]) - spring.rest));
            force[i] += pull;
            force[j] -= pull;
        }
        for hinge in &self.hinges {
            let [i, j, k] = hinge.at;
            let moment = (x[i] - 2.0 * x[j] + x[k]) * hinge.constant;
            force[i] -= moment;
            force[j] += 2.0 * moment;
            force[k] -= moment;
        }
        force
    }

    /// Energy of springs, hinges and gravity [J].
    pub fn energy(&self, x: &[DVec3]) -> f64 {
        let springs: f64 = self
            .springs
            .iter()
            .map(|s| {
                let stretch = x[s.ends[0]].distance(x[s.ends[1]]) - s.rest;
                0.5 * s.constant * stretch * stretch
            })
            .sum();
        let hinges: f64 = self
            .hinges
            .iter()
            .map(|h| {
                0.5 * h.constant * (x[h.at[0]] - 2.0 * x[h.at[1]] + x[h.at[2]]).length_squared()
            })
            .sum();
        let height: f64 = x.iter().zip(&self.mass).map(|(x, m)| -m * self.gravity.dot(*x)).sum();
        springs + hinges + height
    }

    fn accelerations(&self, x: &[DVec3]) -> Vec<DVec3> {
        let force = self.forces(x);
        (0..x.len())
            .map(
                |i| if self.held[i] { DVec3::ZERO } else { force[i] / self.mass[i] + self.gravity },
            )
            .collect()
    }

    /// Accelerations by damping.
    fn braking(&self, x: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let mut force = vec![DVec3::ZERO; x.len()];
        for damper in &self.dampers {
            let [i, j] = damper.ends;
            let mut relative = v[j] - v[i];
            if self.axial {
                let along = (x[j] - x[i]).normalize_or_zero();
                relative = along * relative.dot(along);
            }
            force[i] += relative * damper.constant;
            force[j] -= relative * damper.constant;
        }
        (0..x.len())
            .map(|i| if self.held[i] { DVec3::ZERO } else { force[i] / self.mass[i] })
            .collect()
    }

    /// One step of length `h`.
    pub fn step(&self, motion: &mut Motion, method: Method, h: f64) {
        match method {
            Method::Verlet => self.verlet(motion, h),
            Method::Euler | Method::Midpoint => {
                let rate = |x: &[DVec3], v: &[DVec3]| -> Vec<DVec3> {
                    let (a, b) = (self.accelerations(x), self.braking(x, v));
                    (0..x.len()).map(|i| a[i] + b[i] - v[i] * self.drag).collect()
                };
                let first = rate(&motion.x, &motion.v);
                let (mut v, mut a) = (motion.v.clone(), first.clone());
                if method == Method::Midpoint {
                    let x = sum(&motion.x, &motion.v, 0.5 * h);
                    v = sum(&motion.v, &first, 0.5 * h);
                    a = rate(&x, &v);
                }
                motion.x = sum(&motion.x, &v, h);
                motion.v = sum(&motion.v, &a, h);
            }
        }
    }

    /// Leapfrog: the damping with a velocity that half a kick predicts, still air solved exactly.
    fn verlet(&self, motion: &mut Motion, h: f64) {
        let Motion { x, v, last } = motion;
        let mut a = self.accelerations(x);
        if !self.dampers.is_empty() {
            let with = sum(&a, &self.braking(x, v), 1.0);
            let (decay, gain) = self.kick(0.5 * *last);
            let slowed: Vec<_> = v.iter().map(|v| *v * decay).collect();
            let predicted = sum(&slowed, &with, gain);
            a = sum(&a, &self.braking(x, &predicted), 1.0);
        }
        let (decay, gain) = self.kick(0.5 * (*last + h));
        for i in 0..x.len() {
            if !self.held[i] {
                v[i] = v[i] * decay + a[i] * gain;
                x[i] += v[i] * h;
            }
        }
        *last = h;
    }

    /// What is left of a velocity after a time in still air, and what an acceleration adds to it.
    fn kick(&self, time: f64) -> (f64, f64) {
        let decay = (-self.drag * time).exp();
        (decay, if self.drag > 0.0 { (1.0 - decay) / self.drag } else { time })
    }

    pub fn steps(&self, motion: &mut Motion, method: Method, h: f64, count: usize) {
        for _ in 0..count {
            self.step(motion, method, h);
        }
    }

    /// The equilibrium near to `x`, by Newton's method: what is left of the forces is rounding.
    pub fn equilibrium(&self, x: &[DVec3]) -> Vec<DVec3> {
        let mut x = x.to_vec();
        let free: Vec<_> = (0..x.len()).filter(|&i| !self.held[i]).collect();
        let mut place = vec![usize::MAX; x.len()];
        for (k, &i) in free.iter().enumerate() {
            place[i] = k;
        }
        let residual = |x: &[DVec3]| -> Vec<f64> {
            let force = self.forces(x);
            free.iter().flat_map(|&i| (force[i] + self.gravity * self.mass[i]).to_array()).collect()
        };
        let weight: f64 = free.iter().map(|&i| self.mass[i] * self.gravity.length()).sum();
        let mut shift = 0.0;
        for _ in 0..3000 {
            let force = residual(&x);
            let norm = force.iter().map(|f| f * f).sum::<f64>().sqrt();
            if norm <= 1e-13 * weight {
                break;
            }
            let mut matrix = self.stiffness(&x, &place, free.len());
            matrix.shift(shift);
            let Some(step) = matrix.solve(&force) else {
                shift = (shift * 4.0).max(1e-3 * matrix.largest());
                continue;
            };
            let longest = step.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
            let part = (0.05 / longest).min(1.0);
            let mut moved = x.clone();
            for (k, &i) in free.iter().enumerate() {
                moved[i] += DVec3::new(step[3 * k], step[3 * k + 1], step[3 * k + 2]) * part;
            }
            if self.energy(&moved) <= self.energy(&x) + 1e-12 * self.energy(&x).abs() {
                x = moved;
                shift = if shift > 1e-12 * matrix.largest() { shift * 0.25 } else { 0.0 };
                if longest < 1e-15 {
                    break;
                }
            } else {
                shift = (shift * 4.0).max(1e-6 * matrix.largest());
            }
        }
        let left = residual(&x).iter().map(|f| f * f).sum::<f64>().sqrt();
        let stiffest = self.springs.iter().map(|s| s.constant).fold(0.0, f64::max);
        // Places are rounded, and stiff springs feel it.
        let rounding = 1e-13 * weight + 1e-15 * stiffest;
        assert!(left <= 1e-9 * weight + rounding, "no equilibrium: {left} N left of {weight} N");
        x
    }

    fn stiffness(&self, x: &[DVec3], place: &[usize], free: usize) -> Band {
        let reach = |ends: &[usize]| {
            let there: Vec<_> =
                ends.iter().map(|&i| place[i]).filter(|&p| p != usize::MAX).collect();
            match (there.iter().max(), there.iter().min()) {
                (Some(high), Some(low)) => high - low,
                _ => 0,
            }
        };
        let springs = self.springs.iter().map(|s| reach(&s.ends));
        let hinges = self.hinges.iter().map(|h| reach(&h.at));
        let width = 3 * (springs.chain(hinges).max().unwrap_or(0) + 1);
        let mut band = Band::new(3 * free, width);
        for spring in &self.springs {
            let [i, j] = spring.ends;
            let (span, length) = (x[j] - x[i], x[i].distance(x[j]));
            let n = span / length;
            for p in 0..3 {
                for q in 0..3 {
                    let along = n[p] * n[q];
                    let across = if p == q { 1.0 } else { 0.0 } - along;
                    let k = spring.constant * (along + across * (1.0 - spring.rest / length));
                    band.add([place[i], p], [place[i], q], k);
                    band.add([place[j], p], [place[j], q], k);
                    band.add([place[i], p], [place[j], q], -k);
                    band.add([place[j], p], [place[i], q], -k);
                }
            }
        }
        for hinge in &self.hinges {
            let weights = [1.0, -2.0, 1.0];
            for (i, wi) in hinge.at.into_iter().zip(weights) {
                for (j, wj) in hinge.at.into_iter().zip(weights) {
                    for p in 0..3 {
                        band.add([place[i], p], [place[j], p], hinge.constant * wi * wj);
                    }
                }
            }
        }
        band
    }
}

fn sum(x: &[DVec3], v: &[DVec3], part: f64) -> Vec<DVec3> {
    x.iter().zip(v).map(|(x, v)| x + v * part).collect()
}

/// A symmetric matrix of few diagonals: its lower half, a row a row.
struct Band {
    rows: usize,
    width: usize,
    values: Vec<f64>,
}

impl Band {
    fn new(rows: usize, width: usize) -> Self {
        Self { rows, width, values: vec![0.0; rows * width] }
    }

    fn add(&mut self, [i, p]: [usize; 2], [j, q]: [usize; 2], value: f64) {
        if i == usize::MAX || j == usize::MAX {
            return;
        }
        let (row, column) = (3 * i + p, 3 * j + q);
        if column <= row {
            self.values[row * self.width + (row - column)] += value;
        }
    }

    fn largest(&self) -> f64 {
        (0..self.rows).map(|i| self.values[i * self.width].abs()).fold(0.0, f64::max)
    }

    fn shift(&mut self, by: f64) {
        for i in 0..self.rows {
            self.values[i * self.width] += by;
        }
    }

    /// Cholesky's method; `None` where the matrix is not positive definite.
    fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        let (n, w) = (self.rows, self.width);
        let mut l = self.values.clone();
        for i in 0..n {
            let first = (i + 1).saturating_sub(w);
            for j in first..=i {
                let from = first.max((j + 1).saturating_sub(w));
                let mut s = l[i * w + (i - j)];
                for k in from..j {
                    s -= l[i * w + (i - k)] * l[j * w + (j - k)];
                }
                if i == j {
                    if s <= 0.0 {
                        return None;
                    }
                    l[i * w] = s.sqrt();
                } else {
                    l[i * w + (i - j)] = s / l[j * w];
                }
            }
        }
        let mut y = right.to_vec();
        for i in 0..n {
            for k in (i + 1).saturating_sub(w)..i {
                y[i] -= l[i * w + (i - k)] * y[k];
            }
            y[i] /= l[i * w];
        }
        for i in (0..n).rev() {
            for k in i + 1..(i + w).min(n) {
                y[i] -= l[k * w + (k - i)] * y[k];
            }
            y[i] /= l[i * w];
        }
        Some(y)
    }
}
