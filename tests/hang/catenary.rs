//! The curve, held to its closed form `y = c cosh(x / c)`, to `data/catenary_inextensible.csv`, and to what
//! a hanging line is: of the length given, in a vertical plane, and lowest where nothing pulls at it.

use bevy::math::DVec3;
use bevy_drape::hang::{Catenary, CatenaryError};

use crate::support::solver::*;

const DOWN: DVec3 = DVec3::NEG_Y;

fn line(from: DVec3, to: DVec3, length: f64) -> Catenary {
    Catenary::new(from, to, length, DOWN).unwrap()
}

/// Length of a fine polygon through a line's places; of a smooth arc, corrected for its chords.
fn measured_length(line: &Catenary) -> f64 {
    let along = |count: usize| {
        let points: Vec<_> = line.points(count + 1).collect();
        points.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>()
    };
    // The polygon's defect falls with the square of the chords (Richardson's extrapolation).
    let (coarse, fine) = (along(20_000), along(40_000));
    fine + (fine - coarse) / 3.0
}

/// Ends, lengths: level, sloping, steep, long, nearly taut, nearly vertical.
fn lines() -> Vec<(DVec3, DVec3, f64)> {
    let to = DVec3::new;
    vec![
        (DVec3::ZERO, to(0.8, 0.0, 0.0), 1.0),
        (to(5.0, 1.0, -3.0), to(4.0, 1.7, -3.4), 2.0),
        (DVec3::ZERO, to(0.3, -1.5, 0.2), 1.6),
        (DVec3::ZERO, to(0.01, 0.0, 0.0), 3.0),
        (DVec3::ZERO, to(0.0, 0.3, 1.0), 200.0),
        (DVec3::ZERO, to(1.0, 0.5, 0.0), 1.25_f64.sqrt() * (1.0 + 1e-4)),
        (DVec3::ZERO, to(1.0, 0.5, 0.0), 1.25_f64.sqrt() * (1.0 + 1e-9)),
        (DVec3::ZERO, to(1e-6, 0.9, 0.0), 1.0),
        (to(1e3, 2e3, 3e3), to(2e3, 2e3, 3e3), 1.5e3),
        (DVec3::ZERO, to(2e-4, 1e-4, 0.0), 1e-3),
    ]
}

#[test]
fn it_is_as_long_as_asked_and_begins_and_ends_where_asked() {
    for (from, to, length) in lines() {
        let line = line(from, to, length);
        assert!(line.at(0.0).distance(from) <= 1e-9 * length, "{from} {to} {length}");
        assert!(line.at(length).distance(to) <= 1e-9 * length, "{from} {to} {length}");
        check("length / L", measured_length(&line) / length, 1.0, 1e-6);
    }
}

#[test]
fn its_points_are_evenly_spaced_along_it() {
    for (from, to, length) in lines() {
        let line = line(from, to, length);
        for part in [0.0, 0.2, 0.51, 0.9] {
            // A part of a line hangs as a line of that length between its ends: all of its length is
            // where it is said to be.
            let (a, b) = (line.at(part * length), line.at((part + 0.1) * length));
            let cut = Catenary::new(a, b, 0.1 * length, DOWN).unwrap();
            for inside in [0.03, 0.05, 0.08] {
                let (whole, cut) = (line.at((part + inside) * length), cut.at(inside * length));
                assert!(whole.distance(cut) <= 1e-6 * length, "{from} {to} {length} {part}");
            }
            let steps: Vec<_> =
                (0..1001).map(|i| line.at((part + 1e-4 * f64::from(i)) * length)).collect();
            let sum: f64 = steps.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
            assert!((sum - 0.1 * length).abs() <= 1e-6 * length, "{sum} of {length} at {part}");
        }
    }
}

#[test]
fn it_is_the_cosh_curve() {
    for (from, to, length) in lines() {
        let line = line(from, to, length);
        let c = line.parameter();
        assert!(c.is_finite() && c > 0.0, "{c}");
        if length > 1.1 * from.distance(to) && c > 1e-3 * length {
            // Where the line is lowest, from it alone: slopes are differences of places.
            let (mut low, mut high) = (0.0, length);
            let rises = |way: f64| line.at(way + 1e-6 * length).y > line.at(way - 1e-6 * length).y;
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                (low, high) = if rises(middle) { (low, middle) } else { (middle, high) };
            }
            let lowest = line.at(low);
            if low < 0.01 * length || low > 0.99 * length {
                continue;
            }
            for point in line.points(33) {
                let x = (point - lowest).with_y(0.0).length();
                let y = c * ((x / c).cosh() - 1.0);
                let error = (point.y - lowest.y - y).abs();
                assert!(error <= 1e-5 * length, "{from} {to} {length}: {error} at {x}");
            }
        }
    }
}

#[test]
fn its_sag_and_slope_are_those_of_the_table() {
    for row in table(include_str!("../data/catenary_inextensible.csv")) {
        let value = |column: usize| row[column].parse::<f64>().unwrap();
        let line = line(DVec3::ZERO, DVec3::X * value(0), 1.0);
        check("c / L", line.parameter(), value(1), 1e-11);
        check("sag / L", -line.at(0.5).y, value(2), 1e-11);
        let way = 1e-7;
        let slope = -(line.at(way).y / line.at(way).x).atan().to_degrees();
        check("slope at the support [degrees]", slope, value(4), 1e-3);
    }
}

#[test]
fn supports_at_different_heights_share_one_curve() {
    // A piece of a known curve, cut anywhere.
    let c: f64 = 0.37;
    let point = |x: f64| DVec3::new(x, c * (x / c).cosh(), 0.0);
    let way = |x: f64| c * (x / c).sinh();
    for (a, b) in [(-0.2, 0.9), (0.1, 1.3), (-1.0, 0.05), (0.5, 0.6), (-2.0, 4.0)] {
        let length = way(b) - way(a);
        let line = line(point(a), point(b), length);
        check("c", line.parameter() / c, 1.0, 1e-9);
        for i in 0..=20 {
            let x = a + (b - a) * f64::from(i) / 20.0;
            let error = line.at(way(x) - way(a)).distance(point(x));
            assert!(error <= 1e-10 * length, "{error} at {x} of {a} to {b}");
        }
    }
}

#[test]
fn a_vertical_chord_folds_the_line() {
    for height in [0.0_f64, 0.4, -0.7] {
        // No support at one place: that is refused. Ever nearer to it, the fold is the limit.
        for span in [0.0, 1e-12, 1e-8, 1e-6] {
            let to = DVec3::new(span, height, 0.0);
            let Ok(line) = Catenary::new(DVec3::ZERO, to, 1.0, DOWN) else {
                assert!(height == 0.0 && span <= 1e-6);
                continue;
            };
            let lowest = 0.5 * (1.0 - height);
            // Near the bottom a span of d makes a bow some d wide.
            check("depth", -line.at(lowest).y, lowest, 2.0 * span);
            for way in [0.1, 0.5 * lowest, lowest + 0.1] {
                let y = if way < lowest { -way } else { way - 2.0 * lowest };
                assert!((line.at(way).y - y).abs() <= 2.0 * span + 1e-12);
                assert!(line.at(way).x.abs() <= span + 1e-12);
            }
        }
    }
}

#[test]
fn a_taut_line_is_straight() {
    let (from, to) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 2.5, 2.0));
    let chord = from.distance(to);
    // Longer by less than nothing is rounding; an excess of e sags some sqrt(3 e / 8) of the chord.
    for excess in [-5e-7, 0.0, 1e-15, 1e-12, 1e-9, 1e-6] {
        let line = line(from, to, chord * (1.0 + excess));
        let sag = f64::max(excess, 1e-12).sqrt();
        for (i, point) in line.points(9).enumerate() {
            let off = point.distance(from.lerp(to, i as f64 / 8.0));
            assert!(
                point.is_finite() && off <= 0.7 * sag * chord + 1e-6 * chord,
                "{off} at {excess}"
            );
        }
        if excess >= 1e-9 {
            let off = line.at(0.5 * line.length()).distance(from.midpoint(to));
            // Across the chord the weight counts by its cosine: the sag downwards is the same.
            check("sag / chord", off / chord, (0.375 * excess).sqrt(), 0.3 * excess.sqrt());
        }
    }
}

#[test]
fn gravity_pulls_in_any_direction() {
    let turn = bevy::math::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.1);
    let (a, b) = (DVec3::new(0.2, 0.1, 0.0), DVec3::new(1.1, 0.4, 0.3));
    let upright = line(a, b, 1.4);
    let turned = Catenary::new(turn * a, turn * b, 1.4, turn * DOWN * 9.81).unwrap();
    for (one, other) in upright.points(17).zip(turned.points(17)) {
        assert!((turn * one).distance(other) < 1e-12);
    }
}

#[test]
fn what_no_line_can_do_is_refused() {
    let (o, x) = (DVec3::ZERO, DVec3::X);
    let refused = |from, to, length, down| Catenary::new(from, to, length, down).unwrap_err();
    assert_eq!(refused(o, x, 0.9, DOWN), CatenaryError::TooFar { chord: 1.0, length: 0.9 });
    assert_eq!(refused(x, x, 0.9, DOWN), CatenaryError::Coincident);
    assert_eq!(refused(o, x * f64::NAN, 2.0, DOWN), CatenaryError::NonFinite);
    assert_eq!(refused(o * f64::INFINITY, x, 2.0, DOWN), CatenaryError::NonFinite);
    assert_eq!(refused(o, x, 2.0, DVec3::NAN), CatenaryError::NonFinite);
    assert_eq!(refused(o, x, 2.0, o), CatenaryError::NoGravity);
    for length in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(refused(o, x, length, DOWN), CatenaryError::Length(length));
    }
    assert!(matches!(refused(o, x, f64::NAN, DOWN), CatenaryError::Length(_)));
}
