//! The scenes HANG and DRAPE, and the exact motion of the first: columns of rigid links, the first held.

use std::{error::Error, fs, sync::Arc};

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, DampingForm, Lattice, MassLumping, Material, Settings, Substeps,
};

/// Threads that do not stretch, as the scenes ask; no bending, no damping.
const MATERIAL: Material = Material {
    area_density: 0.2,
    thread_stiffness: 1e6,
    shear_stiffness: 1e6,
    flexural_rigidity: 0.0,
    damping: 0.0,
    damping_form: DampingForm::Axial,
    drag: 0.0,
    max_strain: 0.1,
    friction: 0.5,
    thickness: 0.0,
};

/// A scene with a known answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scene {
    /// A square of 1 m, held by two corners, falls from rest.
    Hang,
    /// A square of 2 m falls onto a sphere of radius 0.5 m at the origin.
    Drape,
}

impl Scene {
    /// Its cloth of n x n particles of equal mass.
    pub fn cloth(self, n: usize, substeps: Substeps) -> Result<ClothSolver, Box<dyn Error>> {
        let (side, offset) = match self {
            Self::Hang => (1.0, Vec3::new(0.0, 0.0, 0.5)),
            Self::Drape => (2.0, Vec3::new(0.0, 0.6, 0.0)),
        };
        let lattice = Arc::new(Lattice::sheet(Vec2::splat(side), n, n, MassLumping::Equal)?);
        let start: Vec<Vec3> = lattice.rest_positions().iter().map(|&p| p + offset).collect();
        let settings = Settings { substeps, lumping: MassLumping::Equal, ..Settings::default() };
        let mut cloth = ClothSolver::new(lattice, &start, MATERIAL, settings)?;
        if self == Self::Hang {
            cloth.set_pins(&[0, n as u32 - 1])?;
        }
        Ok(cloth)
    }
}

/// One particle row at one time.
struct Row {
    n: usize,
    time: f64,
    row: usize,
    /// Distance from the held edge [m].
    out: f64,
    /// Height [m].
    y: f64,
}

/// Where the rows of the sheet are, for some numbers of particles and some times.
pub struct Motion(Vec<Row>);

impl Motion {
    /// Reads the table.
    pub fn read() -> Result<Self, Box<dyn Error>> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hang_exact.csv");
        let is_data = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
        let rows: Result<_, _> =
            fs::read_to_string(path)?.lines().filter(is_data).map(Row::read).collect();
        rows.map(Self)
    }

    /// Mean square distance of all particles to the exact motion [m2]; NaN where it is not known.
    pub fn mean_square(&self, cloth: &ClothSolver, n: usize, time: f64) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for row in self.0.iter().filter(|row| row.n == n && (row.time - time).abs() < 1e-6) {
            for column in 0..n {
                let p = cloth.position(row.row * n + column).as_dvec3();
                let x = column as f64 / (n - 1) as f64 - 0.5;
                sum += (p.x - x).powi(2) + (p.y - row.y).powi(2) + (p.z - row.out).powi(2);
                count += 1;
            }
        }
        sum / f64::from(count)
    }
}

impl Row {
    fn read(line: &str) -> Result<Self, Box<dyn Error>> {
        let numbers = line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let [n, time, row, out, y] = numbers[..] else {
            return Err("a row of the table has five numbers".into());
        };
        Ok(Self { n: n as usize, time, row: row as usize, out, y })
    }
}
