//! Baked fields, held to analytic distances and to brute force.

use crate::{meshes::*, support::dice::Dice};
use bevy::math::{DVec3, UVec3, Vec3, primitives::*};
use bevy_drape::sdf::{BakeSettings, DistanceField, SignedDistance};

/// Baked fields are as good as exact samples, for smooth and for edged shapes: at most 1.2 times the table.
#[test]
fn baked_fields_err_no_more_than_exact_samples() {
    let table: Vec<(&str, u32, [f64; 3])> = include_str!("../data/sdf_error.csv")
        .lines()
        .filter(|line| !line.starts_with('#') && !line.starts_with("shape"))
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |i: usize| cells[i].parse::<f64>().expect("a number");
            (cells[0], number(1) as u32, [number(2), number(3), number(4)])
        })
        .collect();
    assert_eq!(table.len(), 9);
    let meshes = meshes();
    let mut sphere_rms = Vec::new();
    for (name, n, expected) in table {
        let (_, mesh, truth) = meshes.iter().find(|m| m.0 == name).expect("a shape of the table");
        let h = 2.0 / n as f32;
        let found = band_error(&bake(mesh, h, 2.1 * h), *truth);
        for (one, bound) in found.iter().zip(expected) {
            assert!(*one <= 1.2 * bound, "{name} {n}: {found:?}, table {expected:?}");
        }
        if name == "sphere" {
            sphere_rms.push(found[1] * f64::from(h));
        }
    }
    for pair in sphere_rms.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order >= 1.9, "order {order}");
    }
}

/// Every node has the true distance and sign, to the facets' own error.
#[test]
fn baked_nodes_are_exact() {
    for (name, mesh, truth) in meshes() {
        let field = bake(&mesh, 1.0 / 16.0, 0.3);
        let dims = field.dims();
        let mut values = field.values().iter();
        for z in 0..dims.z {
            for y in 0..dims.y {
                for x in 0..dims.x {
                    let node = field.node(UVec3::new(x, y, z)).as_dvec3();
                    let (distance, _) = truth(node);
                    let found = f64::from(*values.next().expect("a value per node"));
                    let error = (found - distance).abs();
                    assert!(error < 2.5e-4, "{name} at {node}: {found}, not {distance}");
                    if distance.abs() > 0.5 / 16.0 {
                        assert_eq!(found < 0.0, distance < 0.0, "{name} at {node}");
                    }
                }
            }
        }
        assert!(values.next().is_none());
        assert!(field.memory_bytes() >= 4 * dims.element_product() as usize);
    }
}

/// Off the medial axis the interpolated distance rises by 1 m per metre.
#[test]
fn baked_slope_is_one() {
    const STEP: f64 = 1e-3;
    let field = bake(&sphere_mesh(48, 0.5), 1.0 / 32.0, 0.3);
    let mut random = Dice(8);
    for _ in 0..20_000 {
        let p = SHIFT + random.direction() * random.between(0.25, 0.75);
        let distance = |p: DVec3| f64::from(field.distance(p.as_vec3()));
        let slope = DVec3::from_array(core::array::from_fn(|axis| {
            let step = DVec3::AXES[axis] * STEP;
            (distance(p + step) - distance(p - step)) / (2.0 * STEP)
        }));
        assert!((0.9..=1.1).contains(&slope.length()), "{slope} at {p}");
        let normal = field.sample(p.as_vec3()).normal.as_dvec3();
        // A step may straddle two cells, whose gradients differ by a few degrees.
        assert!(normal.angle_between(slope) < 0.15, "{normal} and {slope} at {p}");
    }
}

/// On the bunny the nodes have the least distance to all triangles, and the winding number's sign.
#[test]
fn bunny_nodes_equal_brute_force() {
    let mesh = bunny();
    let settings = BakeSettings::for_mesh(&mesh.positions, 64);
    let field = DistanceField::bake(&mesh.positions, &mesh.indices, &settings).expect("the bunny");
    let dims = field.dims();
    assert!((68..=70).contains(&dims.max_element()), "{dims}");
    let mut random = Dice(9);
    let mut inside = 0;
    for _ in 0..3_000 {
        let index = (DVec3::splat(0.5) + 0.5 * random.in_box(1.0)) * dims.as_dvec3();
        let index = index.as_uvec3();
        let node = field.node(index).as_dvec3();
        let place = index.x + dims.x * (index.y + dims.y * index.z);
        let found = f64::from(field.values()[place as usize]);
        let least = least_distance(&mesh, node);
        assert!((found.abs() - least).abs() < 1e-6, "{found}, not {least}, at {node}");
        if least > 1e-5 {
            let is_inside = winding(&mesh, node) > 0.5;
            assert_eq!(found < 0.0, is_inside, "{found} at {node}");
            inside += u32::from(is_inside);
        }
    }
    assert!(inside > 300, "only {inside} nodes were inside");
}

/// Outside the grid the distance never exceeds the true one, joins the grid without a step, and grows.
#[test]
fn far_field_is_a_growing_lower_bound() {
    let mesh = bunny();
    let field = bake(&mesh, 1.0 / 32.0, 0.05);
    let grid = field.grid_bounds();
    let (low, high) = (Vec3::from(grid.min).as_dvec3(), Vec3::from(grid.max).as_dvec3());
    let mut random = Dice(10);
    let mut at_best = 0.0_f64;
    for _ in 0..1_500 {
        let scale = 10.0_f64.powf(random.between(-1.0, 1.5));
        let p = 0.5 * (low + high) + random.in_box(1.0) * (0.6 + scale);
        let gap = p.distance(p.clamp(low, high));
        let found = field.sample(p.as_vec3());
        let least = least_distance(&mesh, p);
        if gap > 0.03 {
            assert!(f64::from(found.distance) <= least, "{} > {least} at {p}", found.distance);
            at_best = at_best.max(f64::from(found.distance) / least);
            // Along the normal one gets away from the mesh, half as fast as possible at least.
            let further = least_distance(&mesh, p + 1e-3 * found.normal.as_dvec3());
            let outward = (further - least) / 1e-3;
            assert!(outward > 0.5, "{found:?} at {p}");
        }
    }
    assert!(at_best > 0.99, "the bound is never close: {at_best}");

    for _ in 0..500 {
        // From a point of the box's surface straight out: along one, two or three axes.
        let mut start = low + (high - low) * (DVec3::splat(0.5) + 0.5 * random.in_box(1.0));
        let mut out = DVec3::ZERO;
        for axis in 0..3 {
            match (3.0 * random.unit()) as u32 {
                0 => (out[axis], start[axis]) = (-random.unit(), low[axis]),
                1 => (out[axis], start[axis]) = (random.unit(), high[axis]),
                _ => {}
            }
        }
        let mut last = field.distance(start.clamp(low, high).as_vec3());
        let step = field.distance((start + 1e-5 * out).as_vec3()) - last;
        assert!(step.abs() < 5e-5, "a step of {step} at {start}");
        for k in 1..60 {
            let next = field.distance((start + out * (1e-3 * 1.3_f64.powi(k))).as_vec3());
            assert!(next >= last - 2e-6, "{next} after {last} from {start} along {out}");
            last = next;
        }
    }
}

/// The stated margin is a bound, and not a vain one: an edge comes to half of it.
#[test]
fn overestimate_bounds_the_error() {
    let bunny = bunny();
    let field = bake(&bunny, 1.0 / 24.0, 0.1);
    let mut random = Dice(11);
    for _ in 0..3_000 {
        let p = (DVec3::new(0.0, 0.5, 0.0) + random.in_box(0.8)).as_vec3();
        let least = least_distance(&bunny, p.as_dvec3());
        let least = if winding(&bunny, p.as_dvec3()) > 0.5 { -least } else { least };
        let excess = f64::from(field.distance(p)) - least;
        assert!(excess <= f64::from(field.overestimate()), "{excess} at {p}");
    }

    let (_, mesh, truth) = &meshes()[2];
    let field = bake(mesh, 1.0 / 16.0, 0.2);
    let mut most = 0.0_f64;
    for _ in 0..100_000 {
        let p = random.in_box(1.0).as_vec3();
        most = most.max(f64::from(field.distance(p)) - truth(p.as_dvec3()).0);
    }
    let stated = f64::from(field.overestimate());
    assert!(most <= stated && most > 0.4 * stated, "{most} of {stated}");
    assert_eq!(Sphere::default().overestimate(), 0.0);
}

/// The same mesh gives the same bits: twice, with vertices of its own per triangle, and moved by whole cells.
#[test]
fn baking_is_repeatable() {
    let mesh = bunny();
    let field = bake(&mesh, 1.0 / 24.0, 0.1);
    let bits =
        |field: &DistanceField| field.values().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&field), bits(&bake(&mesh, 1.0 / 24.0, 0.1)));
    assert_eq!(bits(&field), bits(&bake(&mesh.unwelded(), 1.0 / 24.0, 0.1)));

    let coarse = bake(&sphere_mesh(8, 0.5), 0.125, 0.25);
    let mut moved = sphere_mesh(8, 0.5);
    for p in &mut moved.positions {
        *p = (*p * 4096.0).round() / 4096.0;
    }
    let rounded = bake(&moved, 0.125, 0.25);
    for p in &mut moved.positions {
        *p += Vec3::new(1.0, -0.5, 2.25);
    }
    assert_eq!(bits(&rounded), bits(&bake(&moved, 0.125, 0.25)));
    assert_ne!(bits(&coarse), bits(&rounded));

    let mut shares = Vec::new();
    let settings = BakeSettings { cell_size: 0.1, margin: 0.1 };
    let mut note = |share| shares.push(share);
    DistanceField::bake_with_progress(&mesh.positions, &mesh.indices, &settings, &mut note)
        .expect("the bunny");
    assert!(shares.is_sorted() && shares[0] == 0.0 && shares.last() == Some(&1.0), "{shares:?}");
}
