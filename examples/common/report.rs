//! Watches a run without a window: time, strain, depth.

use bevy::{math::bounding::BoundingSphere, prelude::*};
use bevy_drape::{prelude::*, sdf::DistanceField};
use std::{fmt, time::Instant};

/// What has been seen so far of all cloths.
#[derive(Resource, Default)]
pub(crate) struct Watch {
    started: Option<Instant>,
    /// Time of each tick, from setting up to finishing [ms].
    pub(crate) milliseconds: Vec<f64>,
    /// Largest strain in each tick.
    peaks: Vec<f32>,
    /// Smallest distance of a particle from a solid in any tick [m].
    clearance: Option<f32>,
}

/// Watches every tick of an app.
pub(crate) fn watch(app: &mut App) {
    app.init_resource::<Watch>().add_systems(
        FixedPostUpdate,
        (
            (|mut watch: ResMut<Watch>| watch.started = Some(Instant::now()))
                .before(ClothSystems::Setup),
            (stop_clock, look_at_cloths).chain().after(ClothSystems::Finish),
        ),
    );
}

fn stop_clock(mut watch: ResMut<Watch>) {
    let started = watch.started.take();
    watch.milliseconds.extend(started.map(|at| at.elapsed().as_secs_f64() * 1e3));
}

fn look_at_cloths(
    cloths: Query<&ClothSimulation>,
    solids: Query<(Entity, &SdfCollider)>,
    transforms: TransformHelper,
    fields: Res<Assets<DistanceField>>,
    mut watch: ResMut<Watch>,
) {
    let ticks = cloths.iter().filter_map(ClothSimulation::last_tick);
    let peak = ticks.map(|tick| tick.max_strain).reduce(f32::max);
    watch.peaks.extend(peak);
    let balls: Vec<_> = cloths.iter().map(ball_around).collect();
    let mut clearance = watch.clearance.unwrap_or(f32::INFINITY);
    for (entity, solid) in &solids {
        // Of what moves, where it is at the tick's end: nothing has been propagated since.
        let place = transforms.compute_global_transform(entity);
        let (Some(shape), Ok(place)) = (solid.shape.get(Some(&fields)), place) else {
            continue;
        };
        let (to_solid, scale) = (place.affine().inverse(), place.scale().x);
        let distance = |at: Vec3| scale * shape.distance(to_solid.transform_point3(at));
        for (cloth, ball) in cloths.iter().zip(&balls) {
            // No distance shrinks faster than by the way towards it; between a field's samples by sqrt(3) of it.
            if distance(ball.center.into()) - 2.0 * ball.radius() < clearance {
                clearance = cloth.positions().map(distance).fold(clearance, f32::min);
            }
        }
    }
    watch.clearance = clearance.is_finite().then_some(clearance);
}

/// A ball that holds all of a cloth.
fn ball_around(cloth: &ClothSimulation) -> BoundingSphere {
    let center = cloth.positions().sum::<Vec3>() / cloth.particle_count() as f32;
    let radius = cloth.positions().map(|at| at.distance(center)).fold(0.0, f32::max);
    BoundingSphere::new(center, radius)
}

/// What a run came to.
pub struct Report {
    /// Description of each cloth.
    cloths: Vec<String>,
    ticks: usize,
    median: f64,
    p99: f64,
    /// Largest strain of all ticks, and the mean of the ticks' largest.
    pub peak: f32,
    mean_peak: f32,
    /// Mean strain of all threads at the end.
    mean: f32,
    /// The largest strain allowed.
    pub limit: f32,
    /// How deep a particle has been below a solid's surface [m].
    pub depth: f32,
    clearance: f32,
}

impl Report {
    /// Sums up what has been watched.
    pub(crate) fn new(world: &mut World) -> Self {
        let mut query = world.query::<(&ClothSimulation, &ClothMaterial)>();
        let watch = world.resource::<Watch>();
        let mut times = watch.milliseconds.clone();
        times.sort_by(f64::total_cmp);
        let quantile = |part: f64| times.get((part * times.len() as f64) as usize).copied();
        let cloths: Vec<_> = query.iter(world).collect();
        let count = cloths.len().max(1) as f32;
        let clearance = watch.clearance.unwrap_or(f32::INFINITY);
        Self {
            cloths: cloths.iter().map(|(cloth, _)| describe(cloth)).collect(),
            ticks: times.len(),
            median: quantile(0.5).unwrap_or(f64::NAN),
            p99: quantile(0.99).unwrap_or(f64::NAN),
            peak: watch.peaks.iter().copied().fold(0.0, f32::max),
            mean_peak: watch.peaks.iter().sum::<f32>() / watch.peaks.len().max(1) as f32,
            mean: cloths.iter().map(|(cloth, _)| cloth.strain().mean).sum::<f32>() / count,
            limit: cloths.iter().map(|(_, material)| material.max_strain).fold(0.0, f32::max),
            depth: (-clearance).max(0.0),
            clearance,
        }
    }
}

fn describe(cloth: &ClothSimulation) -> String {
    let (columns, rows) = (cloth.columns(), cloth.rows());
    let grid = if rows > 1 { format!("{columns} x {rows} = ") } else { String::new() };
    let (particles, springs) = (cloth.particle_count(), cloth.spring_count());
    format!("{grid}{particles} particles, {springs} springs\n  {}", cloth.plan())
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for cloth in &self.cloths {
            writeln!(f, "cloth: {cloth}")?;
        }
        let count = self.cloths.len().max(1);
        let (median, p99) = (self.median, self.p99);
        write!(
            f,
            "time: {median:.3} ms a tick (median), {p99:.3} ms (99 %), {} ticks",
            self.ticks
        )?;
        if count > 1 {
            write!(f, "; for each of {count} cloths {:.3} ms", median / count as f64)?;
        }
        let percent = [self.peak, self.mean_peak, self.mean, self.limit].map(|s| 100.0 * s);
        let [peak, mean_peak, mean, limit] = percent;
        writeln!(
            f,
            "\nstrain: peak {peak:.2} % at most, {mean_peak:.2} % in the mean over ticks;"
        )?;
        writeln!(f, "  mean of all threads at the end {mean:.3} %; limit {limit:.1} %")?;
        let (depth, clearance) = (1e3 * self.depth, 1e3 * self.clearance);
        write!(f, "depth: {depth:.4} mm below a surface; nearest to one {clearance:.4} mm")
    }
}
