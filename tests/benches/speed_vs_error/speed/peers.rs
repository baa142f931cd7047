//! What other solvers reached in HANG and DRAPE, as recorded (`tests/data/peer_levels.csv`).

use super::Outcome;
use examples_common::repository;

/// Which error of theirs is drawn.
#[derive(Clone, Copy, PartialEq)]
pub enum Error {
    /// RMS distance from the exact motion \[mm\].
    Rms,
    /// 99th percentile of the strain, the worst of three times \[%\].
    Strain,
}

/// One setting of one of them.
pub struct Level {
    pub peer: String,
    pub scene: String,
    pub n: usize,
    /// Milliseconds a frame on their machine.
    pub time: f64,
    pub rms: f64,
    pub strain: f64,
    pub depth: f64,
    /// It blew up, or does not even fall.
    pub failed: bool,
}

impl Level {
    pub fn error(&self, which: Error) -> f64 {
        match which {
            Error::Rms => self.rms,
            Error::Strain => self.strain,
        }
    }
}

/// All levels on record.
pub fn read() -> Outcome<Vec<Level>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(repository("tests/data/peer_levels.csv"))?;
    let heads = reader.headers()?.clone();
    let column = |name: &str| heads.iter().position(|head| head == name).ok_or(name.to_owned());
    let [peer, scene, n, ms] = [column("peer")?, column("scene")?, column("n")?, column("ms")?];
    let strains = [column("p99_1s")?, column("p99_2s")?, column("p99_3s")?];
    let [rms, depth, blew] = [column("rms_mm")?, column("depth_mm")?, column("blew_up")?];
    let mut levels = Vec::new();
    for row in reader.records() {
        let row = row?;
        let number = |at: usize| row[at].parse().unwrap_or(f64::NAN);
        let strain = strains.map(number).into_iter().fold(0.0, f64::max);
        // In f32 many substeps stop a fall: what hangs in the air is not strained.
        let hovers = &row[scene] == "DRAPE" && strain < 1e-3;
        levels.push(Level {
            peer: row[peer].into(),
            scene: row[scene].to_lowercase(),
            n: row[n].parse()?,
            time: number(ms),
            rms: number(rms),
            strain,
            depth: number(depth),
            failed: hovers || &row[blew] == "True" || number(strains[2]).is_nan(),
        });
    }
    Ok(levels)
}

/// The peers that are drawn, with the names that they go by; those that fit into no plot are in the tables.
pub const DRAWN: [(&str, &str); 8] = [
    ("NvCloth 1.1.6 + tethers", "NvCloth + tethers"),
    ("NvCloth 1.1.6", "NvCloth"),
    ("Jolt c=m dt2 + LRA", "Jolt + long-range attachments"),
    ("Jolt c=m dt2", "Jolt"),
    ("Jolt c=0 re-sorted (modified)", "Jolt, re-sorted (modified)"),
    ("Bullet 3.24", "Bullet"),
    ("bevy_silk 0.10 triangles", "bevy_silk"),
    ("grid XPBD (yardstick)", "yardstick"),
];
