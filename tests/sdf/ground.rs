//! Height fields. The truth is the surface itself, in `f64`: all triangles, the walls where one
//! side has a triangle and the other has none, and the floor; inside is what has a triangle above it.

use crate::solids::{hold_to, somewhere};
use crate::support::dice::Dice;
use bevy::math::{DVec2, DVec3, Vec2, Vec3};
use bevy_drape::sdf::shapes::{HeightField, HeightFieldCell, HeightFieldError};
use bevy_drape::sdf::{LANES, NearestBlock, PointBlock, SampleBlock, SegmentBlock, SignedDistance};
use std::collections::HashMap;

/// Ground by its triangles, upper side only, as parry's `HeightField::triangles_at` makes them.
struct Truth {
    top: Vec<[DVec3; 3]>,
    all: Vec<[DVec3; 3]>,
    floor: f64,
}

impl Truth {
    fn new(field: &HeightField) -> Self {
        let size = field.size().as_dvec2();
        let floor = f64::from(field.floor());
        let (columns, rows) = (field.columns(), field.rows());
        let vertex = |i: usize, j: usize| {
            let x = (j as f64 / (columns - 1) as f64 - 0.5) * size.x;
            let z = (i as f64 / (rows - 1) as f64 - 0.5) * size.y;
            DVec3::new(x, f64::from(field.heights()[i * columns + j]), z)
        };
        let mut top = Vec::new();
        for i in 0..rows - 1 {
            for j in 0..columns - 1 {
                let cell = field.cell(j, i).unwrap();
                let (p00, p10) = (vertex(i, j), vertex(i + 1, j));
                let (p01, p11) = (vertex(i, j + 1), vertex(i + 1, j + 1));
                let [left, right] = if cell.zigzag {
                    [[p00, p10, p11], [p00, p11, p01]]
                } else {
                    [[p00, p10, p01], [p10, p11, p01]]
                };
                top.extend((!cell.left_removed).then_some(left));
                top.extend((!cell.right_removed).then_some(right));
            }
        }
        let down = |p: DVec3| DVec3::new(p.x, floor, p.z);
        let mut sides: HashMap<[u64; 4], ([DVec3; 2], u32)> = HashMap::new();
        for t in &top {
            for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                let [a, b] = if (a.x, a.z) < (b.x, b.z) { [a, b] } else { [b, a] };
                let key = [a.x, a.z, b.x, b.z].map(f64::to_bits);
                sides.entry(key).or_insert(([a, b], 0)).1 += 1;
            }
        }
        let mut all = top.clone();
        all.extend(top.iter().map(|t| t.map(down)));
        for ([a, b], _) in sides.into_values().filter(|(_, count)| *count == 1) {
            all.extend([[a, b, down(a)], [b, down(b), down(a)]]);
        }
        Self { top, all, floor }
    }

    fn distance(&self, p: DVec3) -> f64 {
        let least = self.all.iter().map(|t| to_triangle(p, t)).fold(f64::INFINITY, f64::min);
        let above = |t: &&[DVec3; 3]| over(DVec2::new(p.x, p.z), t);
        let is_below = self.top.iter().find(above).is_some_and(|[a, b, c]| {
            let n = (*b - *a).cross(*c - *a);
            (p - *a).dot(n) * n.y < 0.0
        });
        if is_below && p.y > self.floor { -least } else { least }
    }
}

/// Whether a triangle has a place of the plane within it, seen from above.
fn over(p: DVec2, triangle: &[DVec3; 3]) -> bool {
    let [a, b, c] = triangle.map(|v| DVec2::new(v.x, v.z) - p);
    let turns = [a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)];
    turns.iter().all(|t| *t >= 0.0) || turns.iter().all(|t| *t <= 0.0)
}

/// The least of the distances to the sides, and to the plane if the foot is between them.
pub fn to_triangle(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> f64 {
    let side = |a: DVec3, b: DVec3| {
        let t = (p - a).dot(b - a) / (b - a).length_squared();
        p.distance(a + t.clamp(0.0, 1.0) * (b - a))
    };
    let n = (b - a).cross(c - a).normalize();
    let within = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(n) >= 0.0;
    let least = side(a, b).min(side(b, c)).min(side(c, a));
    let is_over = within(a, b) && within(b, c) && within(c, a);
    if is_over { least.min((p - a).dot(n).abs()) } else { least }
}

/// Hills of several lengths, and a cliff.
fn hills(columns: usize, rows: usize, height: f32) -> Vec<f32> {
    let mut dice = Dice(60);
    let place = |i: usize, count: usize| i as f32 / (count - 1) as f32;
    (0..columns * rows)
        .map(|i| {
            let (u, v) = (place(i % columns, columns), place(i / columns, rows));
            let waves = (6.0 * u).sin() * (5.0 * v + 1.0).cos() + 0.3 * (23.0 * u + 11.0 * v).sin();
            let cliff = if u + 0.3 * v > 0.7 { 0.8 } else { 0.0 };
            height * (waves + cliff + 0.05 * dice.roll())
        })
        .collect()
}

fn ground(columns: usize, rows: usize, height: f32) -> HeightField {
    let size = Vec2::new(2.0, 1.6);
    HeightField::new(columns, rows, hills(columns, rows, height), size).unwrap()
}

fn hold(field: &HeightField, seed: u64) {
    let truth = Truth::new(field);
    hold_to(field, 1.0, seed, |p| truth.distance(p), |_| true);
    // Close to the ground, where what is solved is a small difference, and next to walls.
    let mut dice = Dice(seed + 7);
    let mut worst = 0_f64;
    for _ in 0..3_000 {
        let [a, b, c] = truth.all[dice.below(truth.all.len())];
        let (u, v) = (dice.unit(), dice.unit());
        let half = [1e-5, 1e-3, 0.05][dice.below(3)];
        let near = dice.in_box(half);
        let p = (a + u * (b - a) + (1.0 - u) * v * (c - a) + near).as_vec3();
        let off = (f64::from(field.distance(p)) - truth.distance(p.as_dvec3())).abs();
        worst = worst.max(off);
        assert!(off < 1e-6 * (1.0 + p.as_dvec3().length()), "{p}: off by {off}");
    }
    println!("{field:?}: off by {worst:.1e} m at most, near its surface");
}

/// The distance is that to the nearest place of the surface; see [`hold_to`].
#[test]
fn ground_is_as_near_as_its_nearest_triangle() {
    // Gentle, steep, and with few cells along one axis.
    hold(&ground(24, 17, 0.1), 61);
    hold(&ground(33, 30, 0.7), 62);
    hold(&ground(2, 9, 0.3), 63);
    hold(&ground(2, 2, 0.3), 64);
    hold(&ground(20, 14, 0.2).with_floor(-0.6).unwrap(), 65);
}

/// Diagonals either way.
#[test]
fn cells_are_divided_as_they_say() {
    let zigzag = |column: usize, row: usize| HeightFieldCell {
        zigzag: (column + row).is_multiple_of(2) || column == 5,
        ..HeightFieldCell::default()
    };
    hold(&ground(20, 14, 0.4).with_cells(zigzag).unwrap(), 66);
}

/// Where triangles are missing there is a shaft.
#[test]
fn holes_are_shafts() {
    let mut dice = Dice(67);
    let odd = |_: usize, _: usize| HeightFieldCell {
        zigzag: dice.unit() < 0.5,
        left_removed: dice.unit() < 0.2,
        right_removed: dice.unit() < 0.2,
    };
    hold(&ground(18, 14, 0.4).with_cells(odd).unwrap(), 68);

    let pit = |column: usize, row: usize| {
        let gone = (4..9).contains(&column) && (3..8).contains(&row);
        HeightFieldCell { zigzag: false, left_removed: gone, right_removed: gone }
    };
    let field = ground(18, 14, 0.1).with_cells(pit).unwrap().with_floor(-0.7).unwrap();
    hold(&field, 69);
    assert_eq!(field.height_at(-0.25, -0.1), None);

    let nothing = |_: usize, _: usize| HeightFieldCell {
        left_removed: true,
        right_removed: true,
        zigzag: false,
    };
    let error = ground(5, 5, 0.1).with_cells(nothing).unwrap_err();
    assert_eq!(error, HeightFieldError::NothingLeft);
}

/// Normals at the faces, as near as `f32` can be told from them, and heights.
#[test]
fn normals_are_those_of_the_faces() {
    let mut dice = Dice(70);
    let field = ground(24, 17, 0.3);
    let truth = Truth::new(&field);
    for _ in 0..5_000 {
        let [a, b, c] = truth.top[dice.below(truth.top.len())];
        let (u, v) = (dice.between(0.05, 0.45), dice.between(0.05, 0.45));
        let on = a + u * (b - a) + v * (c - a);
        let normal = (b - a).cross(c - a).normalize();
        let normal = normal * normal.y.signum();
        let p = (on + normal * dice.between(1e-6, 1e-4)).as_vec3();
        let found = field.sample(p).normal.as_dvec3();
        assert!((found - normal).length() < 1e-5, "{p}: {found}, not {normal}");
        let height = field.height_at(on.x as f32, on.z as f32).unwrap();
        assert!((f64::from(height) - on.y).abs() < 1e-5, "{on}: {height}");
    }
    assert_eq!(field.height_at(1.01, 0.0), None);
    assert_eq!(field.height_at(f32::NAN, 0.0), None);
}

/// On a slope of one in one exactly, out is across it: on a face, a side, a corner, and at the border.
#[test]
fn on_the_ground_out_is_across_it() {
    let heights: Vec<f32> = (0..81).map(|i| 0.25 * (i % 9) as f32).collect();
    let field = HeightField::new(9, 9, heights, Vec2::splat(2.0)).unwrap();
    let across = Vec3::new(-1.0, 1.0, 0.0).normalize();
    for x in [-1.0, -0.875, -0.25, 0.0, 0.0625, 0.5] {
        for z in [-1.0, -0.8, -0.5, 0.0, 0.03, 0.25] {
            let found = field.sample(Vec3::new(x, x + 1.0, z));
            assert_eq!(found.distance.abs(), 0.0, "{x}, {z}");
            assert!((found.normal - across).length() < 1e-6, "{x}, {z}: {}", found.normal);
        }
    }
}

/// Where a block is close to the ground, it finds in lanes what each point finds alone: on flat ground, where many places are
/// as near, on hills, with diagonals either way, with holes, at corners and sides of cells, across the border, far up and nowhere.
#[test]
fn blocks_find_what_points_find() {
    let flat = HeightField::new(9, 9, vec![0.25; 81], Vec2::splat(2.0)).unwrap();
    let zigzag = |column: usize, row: usize| HeightFieldCell {
        zigzag: (column * 3 + row * 5) % 7 < 3,
        ..HeightFieldCell::default()
    };
    let fields = [
        flat,
        ground(24, 17, 0.1),
        ground(33, 30, 0.7),
        ground(2, 2, 0.3),
        ground(20, 14, 0.4).with_cells(zigzag).unwrap(),
        ground(20, 14, 0.2).with_floor(-0.6).unwrap(),
        ground(20, 14, 0.2)
            .with_cells(|column, row| HeightFieldCell {
                left_removed: column == 7 && row > 4,
                ..HeightFieldCell::default()
            })
            .unwrap(),
    ];
    let odd = [-0.0, 1e-25, 3e4, 1e30, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    let mut dice = Dice(74);
    for field in &fields {
        let cell =
            field.size() / Vec2::new(field.columns() as f32 - 1.0, field.rows() as f32 - 1.0);
        for round in 0..4_000 {
            let spread = f64::from(cell.x) * [0.1, 0.5, 3.0][dice.below(3)];
            let off = [0.0, 1e-4, 0.01, 0.05, 0.5][dice.below(5)];
            let middle = dice.in_box(1.05);
            let mut points = PointBlock::default();
            for lane in 0..LANES {
                let at = (middle + dice.in_box(spread)).as_vec3();
                let [mut x, mut z] = [at.x, at.z];
                if round % 3 == 0 {
                    x = (x / cell.x).round() * cell.x;
                    z = if round % 2 == 0 { (z / cell.y).round() * cell.y } else { z };
                }
                let on = field.height_at(x, z).unwrap_or(0.0);
                let mut point = Vec3::new(x, on + dice.between(-off, off) as f32, z);
                if round % 5 == 0 && lane % 7 == 3 {
                    point[dice.below(3)] = odd[dice.below(odd.len())];
                }
                points.set(lane, point);
            }
            let (mut samples, mut distances) = (SampleBlock::default(), [0.0; LANES]);
            let mut inlined = SampleBlock::default();
            field.sample_block(&points, &mut samples);
            field.distance_block(&points, &mut distances);
            field.known().unwrap().sample_block(&points, &mut inlined);
            let bits =
                |of: &SampleBlock| [of.distance, of.nx, of.ny, of.nz].map(|of| of.map(bits_of));
            assert_eq!(bits(&inlined), bits(&samples));
            for (lane, distance) in distances.into_iter().enumerate() {
                let (point, one) = (points.point(lane), field.sample(points.point(lane)));
                let bits =
                    |distance: f32, normal: [f32; 3]| (bits_of(distance), normal.map(bits_of));
                let found = [samples.nx[lane], samples.ny[lane], samples.nz[lane]];
                let of_block = bits(samples.distance[lane], found);
                let of_point = bits(one.distance, one.normal.to_array());
                assert_eq!(of_block, of_point, "{field:?}, {point}: {found:?}, {one:?}");
                assert_eq!(bits_of(distance), bits_of(one.distance), "{point}");
            }
            let (from, to) = (points, PointBlock { y: points.y.map(|y| y + 0.01), ..points });
            let segments = SegmentBlock::between(&from, &to);
            let (mut found, mut inlined) = (NearestBlock::default(), NearestBlock::default());
            field.nearest_on_segments(&segments, &mut found);
            field.known().unwrap().nearest_on_segments(&segments, &mut inlined);
            let bits = |of: &NearestBlock| [of.at, of.distance, of.least].map(|of| of.map(bits_of));
            assert_eq!(bits(&inlined), bits(&found));
        }
    }
}

/// A number's bits; all that are none are the same.
fn bits_of(number: f32) -> u32 {
    if number.is_nan() { f32::NAN.to_bits() } else { number.to_bits() }
}

/// What is no ground is told, and what the solver takes on trust is there.
#[test]
fn ground_is_checked() {
    let flat = |columns, rows, count: usize, size| {
        HeightField::new(columns, rows, vec![1.0; count], size).unwrap_err()
    };
    use HeightFieldError::*;
    assert_eq!(flat(1, 3, 3, Vec2::ONE), Counts { columns: 1, rows: 3 });
    let many = usize::MAX / 2;
    assert_eq!(flat(many, 3, 3, Vec2::ONE), Counts { columns: many, rows: 3 });
    assert_eq!(flat(3, 3, 8, Vec2::ONE), HeightCount { expected: 9, found: 8 });
    for bad in [0.0, -1.0, 1e9] {
        assert_eq!(flat(3, 3, 9, Vec2::new(1.0, bad)), Size { x: 1.0, z: bad });
    }
    assert!(matches!(flat(3, 3, 9, Vec2::NAN), Size { .. }));
    for bad in [f32::NAN, f32::INFINITY, -1e8] {
        let mut heights = vec![0.0; 12];
        heights[7] = bad;
        let error = HeightField::new(4, 3, heights, Vec2::ONE).unwrap_err();
        assert!(matches!(error, Height { column: 3, row: 1, .. }), "{error}");
    }
    let field = || HeightField::new(3, 3, vec![1.0; 9], Vec2::new(4.0, 2.0)).unwrap();
    for bad in [f32::NAN, f32::NEG_INFINITY, 1.0, 2.0] {
        assert!(matches!(field().with_floor(bad), Err(Floor { lowest: 1.0, .. })));
    }
    let bounds = field().bounds().unwrap();
    assert_eq!(Vec3::from(bounds.min), Vec3::new(-2.0, -3.0, -1.0));
    assert_eq!(Vec3::from(bounds.max), Vec3::new(2.0, 1.0, 1.0));
    // A cell is one by two; the floor half a metre down is nearer than that.
    assert_eq!(field().core_depth(), 1.0);
    assert_eq!(field().with_floor(0.5).unwrap().core_depth(), 0.25);
    assert_eq!((field().least_radius(), field().overestimate()), (0.0, 0.0));
}

/// Far away, huge and tiny: nothing overflows, and nothing is overestimated.
#[test]
fn any_size_will_do() {
    for (size, height) in [(1e-3_f64, 1e-4_f64), (1e5, 2e3), (1.0, 1e5)] {
        let heights = hills(9, 9, height as f32);
        let field = HeightField::new(9, 9, heights, Vec2::splat(size as f32)).unwrap();
        let truth = Truth::new(&field);
        let mut dice = Dice(71);
        for _ in 0..3_000 {
            let p = somewhere(&mut dice, size.max(height));
            let (found, true_distance) =
                (f64::from(field.distance(p)), truth.distance(p.as_dvec3()));
            let rounding = 3e-6 * (size + height + p.as_dvec3().length());
            assert!((found - true_distance).abs() < rounding, "{p}: {found}, {true_distance}");
        }
    }
}
