//! The exact motion of HANG: columns of rigid links, the first held.

use std::{error::Error, fs};

use bevy_drape::solver::ClothSolver;
use examples_common::repository;

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
        let is_data = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
        let rows: Result<_, _> = fs::read_to_string(repository("tests/data/hang_exact.csv"))?
            .lines()
            .filter(is_data)
            .map(Row::read)
            .collect();
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
