//! The plots.

use bevy_egui::egui::Ui;
use egui_plot::{Legend, Line, Plot, PlotPoints};

use crate::panel::history::{PanelHistory, PanelSample};

type Curve = (&'static str, fn(&PanelSample) -> f64);

/// The plots: their titles, and what is in them.
const PLOTS: [(&str, &[Curve]); 4] = [
    (
        "strain [%]",
        &[("largest", |it| 100.0 * it.max_strain), ("mean", |it| 100.0 * it.mean_strain)],
    ),
    (
        "energy [J]",
        &[
            ("motion", |it| it.kinetic),
            ("height", |it| it.height),
            ("both", |it| it.kinetic + it.height),
        ],
    ),
    ("depth in colliders [mm]", &[("deepest", |it| 1e3 * it.depth)]),
    ("a tick of all cloths [ms]", &[("tick", |it| it.milliseconds)]),
];

/// Draws all of them.
pub(super) fn draw_plots(ui: &mut Ui, history: &PanelHistory) {
    for (title, curves) in PLOTS {
        ui.label(title);
        Plot::new(title)
            .height(100.0)
            .include_y(0.0)
            .allow_drag(false)
            .allow_scroll(false)
            .allow_zoom(false)
            .show_x(false)
            .legend(Legend::default())
            .show(ui, |plot| {
                for (name, value) in curves {
                    let points: PlotPoints<'_> =
                        history.samples().map(|sample| [sample.time, value(sample)]).collect();
                    plot.line(Line::new(*name, points));
                }
            });
    }
}
