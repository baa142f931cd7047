//! Plots of error against milliseconds a frame, substeps or resolution, both in powers of ten, a curve a method.

use std::{error::Error, path::Path};

use plotters::{coord::Shift, prelude::*};

use super::{Against, Outcome, Plot, Point, Results, peers::DRAWN, peers::Level};

const WIDTH: u32 = 1080;
const HEIGHT: u32 = 620;
const LEGEND: u32 = 300;
/// Times that the plots have lines at \[ms\].
const GUIDES: [f64; 3] = [0.1, 0.3, 1.0];
/// Beside them a cloth has no time left in a frame \[ms\].
const LONGEST: f64 = 60.0;

/// For eyes that see colours less well too (Okabe and Ito 2008).
const COLOURS: [RGBColor; 10] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(0, 0, 0),
    RGBColor(86, 180, 233),
    RGBColor(140, 86, 75),
    RGBColor(180, 160, 0),
    RGBColor(70, 60, 160),
    RGBColor(130, 130, 130),
];
/// Paler than those.
const PEERS: [RGBColor; 8] = [
    RGBColor(110, 160, 60),
    RGBColor(170, 200, 130),
    RGBColor(110, 110, 170),
    RGBColor(170, 170, 215),
    RGBColor(70, 70, 110),
    RGBColor(200, 150, 90),
    RGBColor(200, 110, 130),
    RGBColor(120, 120, 120),
];

/// A named curve: the points that succeeded, and the times of those that failed.
struct Curve {
    name: String,
    colour: RGBColor,
    own: bool,
    points: Vec<(f64, f64)>,
    /// What was set at each of the points, in short.
    labels: Vec<String>,
    failed: Vec<f64>,
}

fn own_curves(results: &Results<'_>, plot: &Plot) -> Vec<Curve> {
    let drawn = |point: &&Point| plot.n.is_none_or(|n| n == point.n);
    let mut curves: Vec<Curve> = Vec::new();
    for point in results.points.iter().filter(drawn) {
        let place = plot.against.place(point);
        if place.is_nan() {
            continue;
        }
        let by_size = is_by_size(results, point);
        let name = if plot.against == Against::Resolution {
            format!("{}, {}", point.method, point.knob)
        } else if plot.n.is_some() || by_size {
            point.method.clone()
        } else {
            format!("{}, n = {}", point.method, point.n)
        };
        let at = curves.iter().position(|curve| curve.name == name).unwrap_or_else(|| {
            let colour = COLOURS[curves.len() % COLOURS.len()];
            curves.push(Curve {
                name,
                colour,
                own: true,
                points: Vec::new(),
                labels: Vec::new(),
                failed: Vec::new(),
            });
            curves.len() - 1
        });
        let error = point.errors.get(plot.metric).copied().unwrap_or(f64::NAN);
        if point.failed.is_some() || error.is_nan() {
            curves[at].failed.push(place);
        } else {
            curves[at].points.push((place, error));
            let label = point.knob.strip_suffix(" substeps").unwrap_or_default();
            let label = if by_size { point.n.to_string() } else { label.to_owned() };
            // Else the axis says it.
            let is_said = plot.against != Against::Time;
            curves[at].labels.push(if is_said { String::new() } else { label });
        }
    }
    curves
}

/// Whether a point's method has one setting at each of several sizes, which then make the curve.
fn is_by_size(results: &Results<'_>, point: &Point) -> bool {
    let same = || results.points.iter().filter(|other| other.method == point.method);
    let here = same().filter(|other| other.n == point.n).count();
    here == 1 && same().count() > 1
}

fn peers_curves(results: &Results<'_>, plot: &Plot, levels: &[Level], factor: f64) -> Vec<Curve> {
    let Some(error) = plot.peers else { return Vec::new() };
    let n = plot.n.unwrap_or(64);
    let curve = |((peer, name), colour): (&(&str, &str), &RGBColor)| {
        let here = |level: &&Level| {
            level.peer == *peer && level.scene == results.scene.name && level.n == n
        };
        let levels: Vec<&Level> = levels.iter().filter(here).collect();
        let (bad, good): (Vec<&Level>, Vec<&Level>) =
            levels.into_iter().partition(|level| level.failed);
        let mut points: Vec<_> =
            good.iter().map(|level| (level.time * factor, level.error(error))).collect();
        points.retain(|(time, error)| time.is_finite() && error.is_finite() && *time < LONGEST);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let failed = bad.iter().map(|level| level.time * factor).filter(|&t| t < LONGEST).collect();
        let name = (*name).into();
        Curve { name, colour: *colour, own: false, points, labels: Vec::new(), failed }
    };
    DRAWN.iter().zip(&PEERS).map(curve).filter(|curve| !curve.points.is_empty()).collect()
}

/// Draws one plot of a scene to an SVG.
pub fn draw(
    path: &Path,
    results: &Results<'_>,
    plot: &Plot,
    levels: &[Level],
    factor: f64,
) -> Outcome<()> {
    let mut curves = peers_curves(results, plot, levels, factor);
    curves.extend(own_curves(results, plot));
    let root = SVGBackend::new(path, (WIDTH, HEIGHT)).into_drawing_area();
    root.fill(&WHITE).map_err(told)?;
    let (chart, legend) = root.split_horizontally(WIDTH - LEGEND);
    let range = Range::around(&curves, plot);
    draw_chart(&chart, results, plot, &curves, &range).map_err(told)?;
    draw_legend(&legend, results, plot, &curves).map_err(told)?;
    root.present().map_err(told)
}

fn told(error: impl Error) -> Box<dyn Error> {
    error.to_string().into()
}

struct Range {
    time: (f64, f64),
    error: (f64, f64),
}

impl Range {
    fn around(curves: &[Curve], plot: &Plot) -> Self {
        let positive = |value: &f64| value.is_finite() && *value > 0.0;
        let points = || curves.iter().flat_map(|curve| &curve.points);
        // A peer that fails in no time stretches no axis.
        let own = curves.iter().filter(|curve| curve.own);
        let failed = own.flat_map(|curve| &curve.failed).copied();
        let span = |values: &mut dyn Iterator<Item = f64>| {
            values.filter(positive).fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
                (low.min(value), high.max(value))
            })
        };
        let mut time = span(&mut points().map(|p| p.0).chain(failed));
        let marks = plot.floor.into_iter().chain(plot.chaos);
        let mut error = span(&mut points().map(|p| p.1).chain(marks));
        for range in [&mut time, &mut error] {
            if range.0 > range.1 {
                *range = (0.1, 1.0);
            }
        }
        // Nobody is interested in what is a thousand times too long.
        let most = error.1.min(error.0 * 1e7);
        Self { time: (time.0 / 1.4, time.1 * 1.4), error: (error.0 / 1.6, most * 2.5) }
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn draw_chart(
    area: &Area<'_>,
    results: &Results<'_>,
    plot: &Plot,
    curves: &[Curve],
    range: &Range,
) -> Drawn {
    let metric = &results.scene.errors[plot.metric];
    let (left, right) = range.time;
    let (bottom, top) = range.error;
    let caption = match plot.n {
        Some(n) => format!("{}, n = {n}", results.scene.title),
        None => results.scene.title.to_owned(),
    };
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .caption(caption, ("sans-serif", 19))
        .x_label_area_size(44)
        .y_label_area_size(72)
        .build_cartesian_2d((left..right).log_scale(), (bottom..top).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(plot.against.names().1)
        .y_desc(metric.label())
        .axis_desc_style(("sans-serif", 16))
        .label_style(("sans-serif", 14))
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .max_light_lines(8)
        .light_line_style(RGBColor(242, 242, 242))
        .bold_line_style(RGBColor(215, 215, 215))
        .draw()?;
    if let Some(chaos) = plot.chaos {
        let fill = RGBColor(255, 214, 140).mix(0.4).filled();
        chart.draw_series([Rectangle::new([(left, bottom), (right, chaos)], fill)])?;
    }
    if let Some(floor) = plot.floor {
        let dashes =
            DashedLineSeries::new([(left, floor), (right, floor)], 6, 4, BLACK.stroke_width(1));
        chart.draw_series(dashes)?;
    }
    let guides = if plot.against == Against::Time { &GUIDES[..] } else { &[] };
    for &guide in guides.iter().filter(|guide| (left..right).contains(*guide)) {
        let line = RGBColor(120, 120, 120).stroke_width(1);
        chart.draw_series(DashedLineSeries::new([(guide, bottom), (guide, top)], 2, 3, line))?;
        let style = ("sans-serif", 13).into_font().color(&RGBColor(90, 90, 90));
        chart.draw_series([Text::new(
            format!("{guide} ms"),
            (guide * 1.03, bottom * 1.25),
            style,
        )])?;
    }
    for curve in curves {
        let inside: Vec<_> = curve
            .points
            .iter()
            .filter(|(_, error)| *error <= top)
            .map(|&(time, error)| (time, error.max(bottom)))
            .collect();
        let (width, size) = if curve.own { (3, 5) } else { (1, 3) };
        let line = curve.colour.stroke_width(width);
        // A single setting is a mark of its own.
        if curve.own && inside.len() == 1 {
            let mark = |&at| TriangleMarker::new(at, 9, curve.colour.filled());
            chart.draw_series(inside.iter().map(mark))?;
        } else {
            chart.draw_series(LineSeries::new(inside.clone(), line))?;
            let mark = |&at| Circle::new(at, size, curve.colour.filled());
            chart.draw_series(inside.iter().map(mark))?;
        }
        for (&(time, error), label) in curve.points.iter().zip(&curve.labels) {
            let style = ("sans-serif", 12).into_font().color(&curve.colour);
            let place = (time * 1.07, error.max(bottom) * 1.1);
            if error <= top {
                chart.draw_series([Text::new(label.clone(), place, style)])?;
            }
        }
        let beyond = curve.points.iter().filter(|(_, error)| *error > top).map(|point| point.0);
        let cross = |time| Cross::new((time, top / 1.25), size, curve.colour.stroke_width(2));
        chart.draw_series(curve.failed.iter().copied().chain(beyond).map(cross))?;
    }
    Ok(())
}

/// As few digits as tell one, two or five times a power of ten; nothing elsewhere, where there is no room.
fn number(value: &f64) -> String {
    let power = value.log10().floor();
    let leading = value / 10.0_f64.powf(power);
    if ![1.0, 2.0, 5.0, 10.0].iter().any(|round| (leading / round - 1.0).abs() < 1e-6) {
        String::new()
    } else if (1e-3..1e4).contains(value) {
        let digits = (-power).max(0.0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.0e}")
    }
}

fn draw_legend(area: &Area<'_>, results: &Results<'_>, plot: &Plot, curves: &[Curve]) -> Drawn {
    let mut line = 60;
    let mut write = |text: &str, draw: &dyn Fn(i32) -> Drawn| -> Drawn {
        draw(line)?;
        let style = ("sans-serif", 14).into_font().color(&RGBColor(40, 40, 40));
        area.draw(&Text::new(text.to_owned(), (40, line - 7), style))?;
        line += 22;
        Ok(())
    };
    let nothing = |_| Ok(());
    for (head, own) in [("bevy_drape", true), ("peers, as recorded, times scaled", false)] {
        if !curves.iter().any(|curve| curve.own == own) {
            continue;
        }
        write(head, &nothing)?;
        for curve in curves.iter().filter(|curve| curve.own == own) {
            let width = if own { 3 } else { 1 };
            let style = curve.colour.stroke_width(width);
            write(&curve.name, &|y| {
                if own && curve.points.len() == 1 {
                    area.draw(&TriangleMarker::new((20, y), 8, curve.colour.filled()))
                } else {
                    area.draw(&PathElement::new([(6, y), (34, y)], style))
                }
            })?;
        }
        write("", &nothing)?;
    }
    if plot.against == Against::Time
        && curves.iter().any(|curve| curve.own && !curve.labels.is_empty())
    {
        let by_size = results.points.iter().all(|point| is_by_size(results, point));
        let numbers = if by_size { "numbers: n" } else { "numbers: substeps a frame" };
        write(numbers, &nothing)?;
    }
    write("a failure", &|y| area.draw(&Cross::new((20, y), 5, BLACK.stroke_width(2))))?;
    if plot.floor.is_some() {
        write("rounding of f32", &|y| {
            area.draw(&PathElement::new([(6, y), (18, y)], BLACK.stroke_width(1)))?;
            area.draw(&PathElement::new([(22, y), (34, y)], BLACK.stroke_width(1)))
        })?;
    }
    if plot.chaos.is_some() {
        let fill = RGBColor(255, 214, 140).mix(0.4).filled();
        write("chance: differences below are none", &|y| {
            area.draw(&Rectangle::new([(6, y - 6), (34, y + 6)], fill))
        })?;
    }
    Ok(())
}
