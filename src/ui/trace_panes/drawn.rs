//! The shapes of a trace, which are kept while nothing about them changes, because most frames only follow the pointer.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::RangeInclusive;
use std::sync::{Arc, Weak};

use egui::epaint::Tessellator;
use egui::{Color32, Mesh, Shape, Stroke, Ui};
use egui_plot::{PlotBounds, PlotGeometry, PlotItem, PlotItemBase, PlotTransform};

use crate::recording::Axis;
use crate::scoring::Series;
use crate::scoring::series::Columns;
use crate::ui::palette::Trace;
use crate::ui::plots;
use crate::ui::time_view::Kind;

/// The lines of the last frame, by pane and trace.
pub type DrawnLines = RefCell<HashMap<(Axis, Kind, Trace), Drawn>>;

/// A drawn line with the inputs it was drawn from. The inputs are held by weak references.
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
    stroke: Stroke,
    dash: Option<[f32; 2]>,
    pixels_per_point: f32,
}

pub struct TraceLine<'a> {
    pub base: PlotItemBase,
    pub at: (Axis, Kind, Trace),
    pub series: &'a Arc<Series>,
    pub columns: &'a Arc<Vec<Columns>>,
    pub times: &'a [f64],
    pub stroke: Stroke,
    pub dash: Option<[f32; 2]>,
    pub drawn: &'a DrawnLines,
}

impl TraceLine<'_> {
    fn mesh(&self, ui: &Ui, transform: &PlotTransform, look: Look) -> Mesh {
        let pixel = look.pixels_per_point.recip();
        let mut shapes = Vec::new();
        for columns in &**self.columns {
            let piece = piece(self.series, self.times, columns);
            let style = (self.stroke, self.dash);
            plots::piece_shapes(&piece, style, transform, pixel, &mut shapes);
        }
        let options = ui.ctx().tessellation_options(|options| *options);
        // The shapes contain neither text nor discs.
        let mut tessellator = Tessellator::new(look.pixels_per_point, options, [1, 1], Vec::new());
        tessellator.set_clip_rect(look.frame);
        let mut mesh = Mesh::default();
        for shape in shapes {
            tessellator.tessellate_shape(shape, &mut mesh);
        }
        mesh
    }
}

pub fn piece(series: &Series, times: &[f64], columns: &Columns) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    series.draw_in(columns, times, |time, value| points.push([time, value]));
    points
}

impl PlotItem for TraceLine<'_> {
    fn shapes(&self, ui: &Ui, transform: &PlotTransform, shapes: &mut Vec<Shape>) {
        let look = Look {
            bounds: *transform.bounds(),
            frame: *transform.frame(),
            stroke: self.stroke,
            dash: self.dash,
            pixels_per_point: ui.pixels_per_point(),
        };
        let is_same = |drawn: &Drawn| {
            std::ptr::eq(drawn.series.as_ptr(), Arc::as_ptr(self.series))
                && std::ptr::eq(drawn.columns.as_ptr(), Arc::as_ptr(self.columns))
                && drawn.look == look
        };
        let mut drawn = self.drawn.borrow_mut();
        if !drawn.get(&self.at).is_some_and(is_same) {
            let now = Drawn {
                series: Arc::downgrade(self.series),
                columns: Arc::downgrade(self.columns),
                look,
                mesh: Arc::new(self.mesh(ui, transform, look)),
            };
            drawn.insert(self.at, now);
        }
        shapes.push(Shape::Mesh(Arc::clone(&drawn[&self.at].mesh)));
    }

    fn initialize(&mut self, _x_range: RangeInclusive<f64>) {}

    fn color(&self) -> Color32 {
        self.stroke.color
    }

    fn allow_hover(&self) -> bool {
        false
    }

    fn geometry(&self) -> PlotGeometry<'_> {
        PlotGeometry::None
    }

    fn bounds(&self) -> PlotBounds {
        PlotBounds::NOTHING
    }

    fn base(&self) -> &PlotItemBase {
        &self.base
    }

    fn base_mut(&mut self) -> &mut PlotItemBase {
        &mut self.base
    }
}
