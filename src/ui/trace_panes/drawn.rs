//! Draws the lines of the traces. The shapes of a line are kept until its samples, range or style change, because in most
//! frames only the pointer moves.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

use egui::epaint::Tessellator;
use egui::{Mesh, Shape, Stroke};
use egui_plot::{PlotBounds, PlotItem, PlotTransform};

use crate::{
    recording::Axis,
    scoring::{Series, series::Columns},
    ui::{
        palette::Trace,
        plots::{Shapes, piece_shapes},
        time_view::Kind,
    },
};

/// The lines that were drawn in the last frame, by axis, kind of plot (loads or errors) and load.
pub type DrawnLines = RefCell<HashMap<(Axis, Kind, Trace), Drawn>>;

/// A drawn line, and the inputs from which it was drawn. Weak references to the inputs do not keep old samples in memory.
#[derive(Debug)]
pub struct Drawn {
    series: Weak<Series>,
    columns: Weak<Vec<Columns>>,
    look: Look,
    mesh: Arc<Mesh>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    bounds: PlotBounds,
    frame: egui::Rect,
    style: (Stroke, Option<[f32; 2]>),
    pixels_per_point: f32,
}

pub fn trace_line<'a>(
    at @ (.., trace): (Axis, Kind, Trace),
    (series, columns, times): (&'a Arc<Series>, &'a Arc<Vec<Columns>>, &'a [f64]),
    style: (Stroke, Option<[f32; 2]>),
    drawn: &'a DrawnLines,
) -> impl PlotItem + use<'a> {
    Shapes::new(trace.label(), style.0.color, move |ui, transform, shapes| {
        let look = Look {
            bounds: *transform.bounds(),
            frame: *transform.frame(),
            style,
            pixels_per_point: ui.pixels_per_point(),
        };
        let is_same = |drawn: &Drawn| {
            std::ptr::eq(drawn.series.as_ptr(), Arc::as_ptr(series))
                && std::ptr::eq(drawn.columns.as_ptr(), Arc::as_ptr(columns))
                && drawn.look == look
        };
        let mut drawn = drawn.borrow_mut();
        if !drawn.get(&at).is_some_and(is_same) {
            let pieces = columns.iter().map(|columns| piece(series, times, columns));
            let mesh = Arc::new(mesh(ui, transform, look, pieces));
            let (series, columns) = (Arc::downgrade(series), Arc::downgrade(columns));
            drawn.insert(at, Drawn { series, columns, look, mesh });
        }
        shapes.push(Shape::Mesh(Arc::clone(&drawn[&at].mesh)));
    })
}

fn mesh(
    ui: &egui::Ui,
    transform: &PlotTransform,
    look: Look,
    pieces: impl Iterator<Item = Vec<[f64; 2]>>,
) -> Mesh {
    let pixel = look.pixels_per_point.recip();
    let mut shapes = Vec::new();
    for piece in pieces {
        piece_shapes(&piece, look.style, transform, pixel, &mut shapes);
    }
    let options = ui.ctx().tessellation_options(|options| *options);
    // The shapes contain neither text nor discs, so the tessellator needs no textures.
    let mut tessellator = Tessellator::new(look.pixels_per_point, options, [1, 1], Vec::new());
    tessellator.set_clip_rect(look.frame);
    let mut mesh = Mesh::default();
    for shape in shapes {
        tessellator.tessellate_shape(shape, &mut mesh);
    }
    mesh
}

pub fn piece(series: &Series, times: &[f64], columns: &Columns) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    series.draw_in(columns, times, |time, value| points.push([time, value]));
    points
}
