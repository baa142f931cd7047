//! Scenes that several modules settle or compare.

use bevy::math::{DVec2, DVec3, Vec3};
use bevy_drape::solver::{
    Bending, ClothSolver, DampingForm, Graph, Integrator, MassLumping, Material, Settings,
};

use super::reference::{Fabric, Method, Model};
use crate::support::solver::*;

/// A sheet in the xz plane with its first particle at the origin: as the solver and as the reference have
/// it.
pub struct Sheet {
    pub cells: [usize; 2],
    pub cell: DVec2,
}

impl Sheet {
    pub fn square(cells: usize, size: f64) -> Self {
        Self { cells: [cells; 2], cell: DVec2::splat(size / cells as f64) }
    }

    pub fn columns(&self) -> usize {
        self.cells[0] + 1
    }

    pub fn rows(&self) -> usize {
        self.cells[1] + 1
    }

    pub fn count(&self) -> usize {
        self.rows() * self.columns()
    }

    pub fn at(&self, row: usize, column: usize) -> usize {
        row * self.columns() + column
    }

    pub fn rest(&self) -> Vec<DVec3> {
        (0..self.count())
            .map(|i| {
                let (row, column) = (i / self.columns(), i % self.columns());
                DVec3::new(column as f64 * self.cell.x, 0.0, row as f64 * self.cell.y)
            })
            .collect()
    }

    fn rest_32(&self) -> Vec<Vec3> {
        self.rest().iter().map(|p| p.as_vec3()).collect()
    }

    pub fn lattice(&self, lumping: MassLumping) -> std::sync::Arc<bevy_drape::solver::Lattice> {
        let lattice =
            bevy_drape::solver::Lattice::new(self.rows(), self.columns(), &self.rest_32(), lumping);
        std::sync::Arc::new(lattice.unwrap())
    }

    /// The same of triangles, each cell cut along either diagonal.
    pub fn graph(&self, lumping: MassLumping) -> std::sync::Arc<Graph> {
        self.jittered(0.0, lumping)
    }

    /// The same, its inner particles off their places by up to 0.3 cells. The first two rows, which clamp a strip, are straight.
    pub fn irregular(&self, lumping: MassLumping) -> std::sync::Arc<Graph> {
        self.jittered(0.3, lumping)
    }

    fn jittered(&self, jitter: f32, lumping: MassLumping) -> std::sync::Arc<Graph> {
        let mut dice = Dice(5);
        let mut triangles = Vec::new();
        for row in 0..self.cells[1] {
            for column in 0..self.cells[0] {
                let at = self.at(row, column) as u32;
                triangles.extend(halves(at, self.columns(), dice.roll() > 0.0));
            }
        }
        let mut rest = self.rest_32();
        let cell = self.cell.as_vec2() * jitter;
        for (row, column) in
            (2..self.cells[1]).flat_map(|r| (1..self.cells[0]).map(move |c| (r, c)))
        {
            rest[self.at(row, column)] +=
                Vec3::new(dice.roll() * cell.x, 0.0, dice.roll() * cell.y);
        }
        std::sync::Arc::new(Graph::new(&rest, &triangles, lumping).unwrap())
    }

    pub fn model(&self, fabric: &Fabric, held: &[usize], gravity: DVec3) -> Model {
        let mut model = Model::sheet(fabric, self.cells, self.cell, held);
        model.gravity = gravity;
        model
    }
}

/// The fabric as the solver's material.
pub fn material(fabric: &Fabric) -> Material {
    Material {
        area_density: fabric.density as f32,
        thread_stiffness: fabric.thread as f32,
        shear_stiffness: fabric.shear as f32,
        flexural_rigidity: fabric.rigidity as f32,
        damping: fabric.damping as f32,
        damping_form: if fabric.axial { DampingForm::Axial } else { DampingForm::Relative },
        drag: fabric.drag as f32,
        ..plain()
    }
}

/// What the fabric and a method ask of the settings.
pub fn settings_for(fabric: &Fabric, method: Method, base: Settings) -> Settings {
    Settings {
        lumping: lumping(fabric),
        bending: if fabric.flexion { Bending::Flexion } else { Bending::SecondDifference },
        integrator: match method {
            Method::Verlet => Integrator::Verlet,
            Method::Euler => Integrator::Euler,
            Method::Midpoint => Integrator::Midpoint,
        },
        tethers: false,
        ..base
    }
}

pub fn lumping(fabric: &Fabric) -> MassLumping {
    if fabric.equal { MassLumping::Equal } else { MassLumping::Lumped }
}

pub fn places(solver: &ClothSolver) -> Vec<DVec3> {
    positions(solver).iter().map(|p| p.as_dvec3()).collect()
}

pub fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// Takes ticks until no particle is faster than `speed`, at most `ticks`. Gives the speed that is left.
pub fn settle(solver: &mut ClothSolver, gravity: Vec3, speed: f64, ticks: usize) -> f64 {
    for _ in 0..ticks.div_ceil(16) {
        run(solver, 16, gravity, &[]);
        if fastest(solver) < speed {
            break;
        }
    }
    fastest(solver)
}

/// Numbers to print.
pub fn list(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:.3e}")).collect::<Vec<_>>().join(", ")
}

/// A strip along z in the xz plane: `cells` along, two across.
pub fn strip(cells: usize, length: f64) -> Sheet {
    Sheet { cells: [2, cells], cell: DVec2::splat(length / cells as f64) }
}
