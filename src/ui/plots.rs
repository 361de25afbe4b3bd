//! Functions that all plots share: grid lines at round numbers, zoom by wheel and drag, and the drawing of lines with many
//! points or dashes.

use std::sync::Arc;

use egui::{
    AsIdSalt, Color32, ColorImage, EventFilter, Key, Mesh, Modifiers, Pos2, Rect, Response, Shape,
    Stroke, TextureFilter, TextureHandle, TextureOptions, Ui,
};
use egui_plot::{
    AxisHints, CoordinatesFormatter, Corner, GridInput, GridMark, Plot, PlotBounds, PlotGeometry,
    PlotImage, PlotItem, PlotItemBase, PlotPoint, PlotResponse, PlotTransform, PlotUi,
};

use crate::{
    questions::loops::Inks,
    report::figure::{Cloud, CloudPicture, Figure, part_inside},
    scoring::{
        loops::Frame,
        numbers::{three_ticks, tick_text},
    },
    ui::{
        command::Out,
        controls::named,
        numbers::significant,
        palette::{self, rgb},
        picture,
    },
};

/// Distance of grid lines on screen (points) that is passed to egui_plot. egui_plot converts it to `base_step_size`, in units
/// of the axis.
pub const GRID_BASE_POINTS: f64 = 8.0;
/// Distance of grid lines (points) at which the grid would be as dark as text. Closer grid lines are fainter, so that the data
/// stand out.
const GRID_FULL_POINTS: f32 = 900.0;
/// Natural logarithm of the zoom factor for one point of scrolling by the wheel.
const ZOOM_PER_POINT: f64 = 0.004;
/// Minimum horizontal and vertical distance between two numbers at the axes (points).
const MIN_STEP_POINTS: (f64, f64) = (64.0, 26.0);
/// Smaller minimum distance (points) for axes on which three numbers would not fit otherwise.
const CLOSEST_POINTS: (f64, f64) = (40.0, 12.0);
const LABEL_SIZE: f32 = 11.0;
const TICK_SIZE: f32 = 10.0;
/// Share of the visible range by which an arrow key moves a plot.
const KEY_SHARE: f64 = 0.1;
/// Factor by which a key zooms a plot.
const KEY_ZOOM: f64 = 0.8;
/// Width of the labels of the value axis (points).
pub const VALUE_AXIS_WIDTH: f32 = 52.0;

/// Returns grid lines at least `least_points` apart on screen, or `closest_points` if fewer than three would fit otherwise.
pub fn grid(input: GridInput, least_points: f64, closest_points: f64) -> Vec<GridMark> {
    let point = input.base_step_size / GRID_BASE_POINTS;
    let (least, closest) = (point * least_points, point * closest_points);
    let (step_size, values) = three_ticks(input.bounds, least, closest);
    let marks = values.into_iter().map(|value| GridMark { value, step_size });
    marks.collect()
}

/// Returns the number at a grid line, with enough decimals to distinguish neighbouring grid lines.
pub fn tick_label(mark: GridMark) -> String {
    tick_text(mark.value, mark.step_size)
}

/// Adds axes to a plot: labels with units, and round numbers, at least three even on a small plot. If `across` is `None`, the
/// horizontal axis is omitted.
pub fn scales<'a>(plot: Plot<'a>, across: Option<&str>, up: &str) -> Plot<'a> {
    let hints = |hints: AxisHints<'a>, label: &str| {
        hints
            .label(egui::RichText::new(label).size(LABEL_SIZE))
            .formatter(|mark, _| tick_label(mark))
            .tick_label_font(egui::FontId::proportional(TICK_SIZE))
            // The grid lines already have the minimum distance for numbers, so every grid line gets a number.
            .label_spacing(egui::Rangef::new(0.0, 1.0))
    };
    plot.show_axes([across.is_some(), true])
        .custom_x_axes(vec![hints(AxisHints::new_x(), across.unwrap_or(""))])
        .custom_y_axes(vec![hints(AxisHints::new_y(), up)])
        .y_axis_min_width(VALUE_AXIS_WIDTH)
        .grid_spacing(egui::Rangef::new(GRID_BASE_POINTS as f32, GRID_FULL_POINTS))
        .x_grid_spacer(|input| grid(input, MIN_STEP_POINTS.0, CLOSEST_POINTS.0))
        .y_grid_spacer(|input| grid(input, MIN_STEP_POINTS.1, CLOSEST_POINTS.1))
}

/// Returns a plot whose visible range always covers all data. The caller handles press and drag.
pub fn still<'a>(id: impl AsIdSalt, [width, height]: [f32; 2]) -> Plot<'a> {
    Plot::new(id)
        .width(width)
        .height(height)
        .allow_scroll(false)
        .allow_zoom(false)
        .allow_drag(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .show_y(false)
}

/// Returns a plot whose visible range is set by the caller and moved by dragging.
pub fn moving(plot: Plot<'_>, height: f32) -> Plot<'_> {
    plot.height(height)
        .allow_scroll(false)
        .allow_axis_zoom_drag(true)
        .allow_double_click_reset(false)
        .show_x(false)
        .show_y(false)
        .show_crosshair(false)
        .set_margin_fraction(egui::Vec2::ZERO)
}

/// Visible range that the user chose; `None` shows all data.
pub type Zoom = Option<Frame>;

/// Draws a plot that moves and zooms. Wheel, drag and double click change `zoom`. `figure` returns the figure in the colours
/// of the screen or of an SVG file. The plot's name for screen readers is `name`, or else the figure's title.
pub fn plot<'a>(
    ui: &mut Ui,
    (id, name): (&str, Option<String>),
    height: f32,
    figure: impl Fn(&Inks) -> Figure<'a>,
    zoom: &mut Zoom,
    out: &mut Out,
) -> Drawn {
    let drawing = figure(&palette::inks(ui.visuals()));
    let whole = Frame { loads: drawing.across.range, outputs: drawing.up.range };
    let Frame { loads: across, outputs: up } = zoom.unwrap_or(whole);
    let textures = textures(ui, id, &drawing.clouds);
    let bounds = PlotBounds::from_min_max([across.0, up.0], [across.1, up.1]);
    let scaled = scales(Plot::new(id), Some(&drawing.across.label), &drawing.up.label);
    let PlotResponse { response, transform, .. } = moving(scaled, height)
        .allow_zoom(true)
        .allow_drag(true)
        .coordinates_formatter(
            Corner::LeftBottom,
            CoordinatesFormatter::new(|point, _| coordinates(&drawing, point)),
        )
        .show(ui, |plot| {
            plot.set_plot_bounds(bounds);
            for (frame, texture) in &textures {
                let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
                let size = |(low, high): (f64, f64)| (high - low) as f32;
                let centre = PlotPoint::new(middle(frame.loads), middle(frame.outputs));
                let size = [size(frame.loads), size(frame.outputs)];
                plot.image(PlotImage::new("", texture, centre, size).allow_hover(false));
            }
            lines(plot, &drawing);
        });
    let drawn = Drawn { response, transform };
    for arrow in &drawing.arrows {
        let corners = arrow.corners(|point| {
            let at = drawn.place(point);
            [at.x, at.y].map(f64::from)
        });
        if let Some(corners) = corners {
            let corners = corners.map(|[x, y]| egui::pos2(x as f32, y as f32));
            let shape = Shape::convex_polygon(corners.to_vec(), rgb(arrow.color), Stroke::NONE);
            drawn.painter(ui).add(shape);
        }
    }
    match gestures(ui, &drawn, bounds, true) {
        Some(Asked::All) => *zoom = None,
        Some(Asked::Part(min, max)) => {
            let is_wide = |i: usize| {
                let wide = max[i] - min[i];
                wide.is_finite() && wide > 1e-9 * min[i].abs().max(max[i].abs())
            };
            if is_wide(0) && is_wide(1) {
                *zoom = Some(Frame { loads: (min[0], max[0]), outputs: (min[1], max[1]) });
            }
        }
        None => {}
    }
    let print = || figure(&Inks::PRINT);
    finish(&drawn.response, name.as_ref().unwrap_or(&drawing.title), Some(&print), out);
    say(&drawn.response, || match drawn.response.hover_pos() {
        Some(at) => coordinates(&drawing, &drawn.transform.value_from_position(at)),
        None => {
            format!("{}, {}", range(across, &drawing.across.label), range(up, &drawing.up.label))
        }
    });
    drawn
}

fn lines<'a>(plot: &mut PlotUi<'a>, figure: &'a Figure<'_>) {
    for line in &figure.lines {
        let color = rgb(line.color).gamma_multiply(line.opacity);
        let style = (Stroke::new(line.width, color), line.dash);
        plot.add(Shapes::new(&line.name, color, move |ui, transform, shapes| {
            let pixel = ui.pixels_per_point().recip();
            for piece in &line.pieces {
                piece_shapes(piece, style, transform, pixel, shapes);
            }
        }));
    }
}

/// A plot that was drawn in this frame, for callers that draw over the plot or convert the place of the pointer to values.
pub struct Drawn {
    pub response: Response,
    pub transform: PlotTransform,
}

impl Drawn {
    pub fn place(&self, [x, y]: [f64; 2]) -> Pos2 {
        self.transform.position_from_point(&PlotPoint::new(x, y))
    }

    pub fn painter(&self, ui: &Ui) -> egui::Painter {
        ui.painter_at(self.response.rect)
    }
}

type Textures = Vec<(Frame, TextureHandle)>;

/// Returns the textures that show the density of the points. They are made again only if the densities changed since the last
/// frame.
fn textures(ui: &Ui, id: &str, clouds: &[Cloud]) -> Textures {
    let key = ui.scope_id().with(("clouds", id));
    let kept = ui.data(|data| data.get_temp::<(Vec<Cloud>, Textures)>(key));
    let (of, kept) = kept.unwrap_or_default();
    let is_same = |(one, other): (&Cloud, &Cloud)| {
        Arc::ptr_eq(&one.density, &other.density) && one.color == other.color
    };
    if of.len() == clouds.len() && of.iter().zip(clouds).all(is_same) {
        return kept;
    }
    let most = ui.input(|input| input.max_texture_side);
    let widest = clouds.iter().flat_map(|cloud| cloud.density.cells).max();
    // A pixel of the texture covers two cells of the density in each direction, or more if the texture would exceed the
    // maximum size.
    let cells_per_pixel = widest.unwrap_or(0).div_ceil(most.max(1)).max(2);
    let textures = CloudPicture::of(clouds, cells_per_pixel).into_iter().map(|picture| {
        let image = ColorImage::from_rgba_unmultiplied(picture.size, &picture.rgba);
        let sampled =
            TextureOptions { magnification: TextureFilter::Nearest, ..TextureOptions::LINEAR };
        (picture.frame, ui.ctx().load_texture("clouds", image, sampled))
    });
    let made: Textures = textures.collect();
    ui.data_mut(|data| data.insert_temp(key, (clouds.to_vec(), made.clone())));
    made
}

/// Names a plot for screen readers and adds the menu that copies or saves it. `print` returns the figure of the SVG file.
pub fn finish<'a>(
    plot: &Response,
    name: &str,
    print: Option<&dyn Fn() -> Figure<'a>>,
    out: &mut Out,
) {
    named(plot, egui::Role::GraphicsObject, name);
    picture::menu(plot, with_labels(plot.rect), print, out);
}

/// Sets the text that screen readers read for a plot, such as the values at the present sample.
pub fn say(plot: &Response, value: impl FnOnce() -> String) {
    if plot.ctx.has_accesskit_node(plot.id) {
        let value = value();
        plot.ctx.accesskit_node_builder(plot.id, |node| node.set_value(value));
    }
}

pub fn range((from, to): (f64, f64), label: &str) -> String {
    format!("{label}: {} to {}", significant(from, 4), significant(to, 4))
}

fn coordinates(drawing: &Figure<'_>, point: &PlotPoint) -> String {
    let (x, y) = (significant(point.x, 4), significant(point.y, 4));
    format!("{}: {x}   {}: {y}", drawing.across.label, drawing.up.label)
}

fn with_labels(plot: Rect) -> Rect {
    let mut part = plot.expand(4.0);
    part.min.x -= VALUE_AXIS_WIDTH + 18.0;
    part.max.y += 30.0;
    part
}

/// Change of the visible range that the user requests: all data, or the range from the first to the second corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    All,
    Part([f64; 2], [f64; 2]),
}

/// Returns the change of the visible range that the user requests by drag, double click, wheel or keys; `set` is the present
/// range. The wheel and the keys zoom horizontally, and also vertically if `both`.
pub fn gestures(ui: &Ui, drawn: &Drawn, set: PlotBounds, both: bool) -> Option<Asked> {
    let axes: &[usize] = if both { &[0, 1] } else { &[0] };
    let keys = keys(ui, &drawn.response, set, axes);
    if drawn.response.double_clicked() || keys == Some(Asked::All) {
        return Some(Asked::All);
    }
    let now = drawn.transform.bounds();
    let (mut min, mut max) = match keys {
        Some(Asked::Part(min, max)) => (min, max),
        _ => (now.min(), now.max()),
    };
    if let Some(pointer) = drawn.response.hover_pos() {
        let at = drawn.transform.value_from_position(pointer);
        let wheel = f64::from(ui.input(|input| input.smooth_scroll_delta.y));
        let factor = (-ZOOM_PER_POINT * wheel).exp();
        for axis in axes.iter().filter(|_| wheel != 0.0) {
            for end in [&mut min[*axis], &mut max[*axis]] {
                let at = [at.x, at.y][*axis];
                *end = at + (*end - at) * factor;
            }
        }
    }
    ((min, max) != (set.min(), set.max())).then_some(Asked::Part(min, max))
}

/// Returns the change of the visible range that the user requests by keys, if the plot has the focus; `set` is the present
/// range. Arrows move the range, and Backspace shows all data. Plus and minus zoom the axes in `axes`, and with Alt the
/// vertical axis.
fn keys(ui: &Ui, response: &Response, set: PlotBounds, axes: &[usize]) -> Option<Asked> {
    if !response.has_focus() {
        return None;
    }
    let arrows =
        EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    ui.data_mut(|data| data.insert_temp(focused_id(), response.id));
    let pressed = |held, key| ui.input_mut(|input| input.consume_key(held, key));
    if pressed(Modifiers::NONE, Key::Backspace) {
        return Some(Asked::All);
    }
    let (mut min, mut max) = (set.min(), set.max());
    let mut zoom = |axes: &[usize], factor: f64| {
        for axis in axes {
            let (middle, half) = (0.5 * (min[*axis] + max[*axis]), 0.5 * (max[*axis] - min[*axis]));
            (min[*axis], max[*axis]) = (middle - factor * half, middle + factor * half);
        }
    };
    for (held, axes) in [(Modifiers::ALT, &[1][..]), (Modifiers::NONE, axes)] {
        if pressed(held, Key::Plus) || pressed(held, Key::Equals) {
            zoom(axes, KEY_ZOOM);
        } else if pressed(held, Key::Minus) {
            zoom(axes, KEY_ZOOM.recip());
        }
    }
    for (key, axis, share) in [
        (Key::ArrowLeft, 0, -KEY_SHARE),
        (Key::ArrowRight, 0, KEY_SHARE),
        (Key::ArrowDown, 1, -KEY_SHARE),
        (Key::ArrowUp, 1, KEY_SHARE),
    ] {
        if pressed(Modifiers::NONE, key) {
            let by = share * (max[axis] - min[axis]);
            (min[axis], max[axis]) = (min[axis] + by, max[axis] + by);
        }
    }
    ((min, max) != (set.min(), set.max())).then_some(Asked::Part(min, max))
}

/// Returns true if a plot has the keyboard focus. The space key then plays the recording, because a plot cannot be pressed
/// like a button.
pub fn have_focus(context: &egui::Context) -> bool {
    let last = context.data(|data| data.get_temp::<egui::Id>(focused_id()));
    last.is_some() && last == context.memory(|memory| memory.focused())
}

fn focused_id() -> egui::Id {
    egui::Id::unique("the plot that has the focus")
}

/// Returns true if a line goes from left to right with several points for each pixel.
fn is_dense(points: &[Pos2], pixel: f32) -> bool {
    const POINTS_PER_PIXEL: f32 = 1.5;
    const LEAST_POINTS: usize = 16;
    let ends = points.first().zip(points.last());
    ends.is_some_and(|(first, last)| {
        let across = last.x - first.x;
        points.len() >= LEAST_POINTS
            && points.is_sorted_by(|a, b| a.x <= b.x)
            && points.len() as f32 * pixel >= POINTS_PER_PIXEL * across
    })
}

/// Returns the area that a dense line covers: in each pixel from its lowest to its highest point. The line itself would need
/// several times more triangles. Returns `None` for a line with few points in most pixels, because the area would be too narrow
/// where the line is steep.
fn strip(points: &[Pos2], stroke: Stroke, pixel: f32) -> Option<Mesh> {
    let mut bars: Vec<(f32, f32, f32)> = Vec::new();
    let same_pixel = |a: &Pos2, b: &Pos2| (a.x / pixel).floor() == (b.x / pixel).floor();
    let mut before: Option<Pos2> = None;
    for column in points.chunk_by(same_pixel) {
        let (first, last) = (column[0], column[column.len() - 1]);
        if let Some(before) = before.filter(|before| first.x - before.x > 2.0 * pixel) {
            bars.extend([before, first].map(|end| (end.x, end.y, end.y)));
        }
        let low = column.iter().map(|point| point.y).fold(f32::INFINITY, f32::min);
        let high = column.iter().map(|point| point.y).fold(f32::NEG_INFINITY, f32::max);
        bars.push((0.5 * (first.x + last.x), low, high));
        before = Some(last);
    }
    let middle = |(_, low, high): &(f32, f32, f32)| 0.5 * (low + high);
    let on = bars.windows(2).map(|pair| (middle(&pair[1]) - middle(&pair[0])).abs());
    let up_and_down = bars.iter().map(|(_, low, high)| high - low);
    if up_and_down.sum::<f32>() < 2.0 * on.sum::<f32>() {
        return None;
    }
    // The area extends beyond the points by half the line width, and fades out over one more pixel to smooth the edge.
    let half = 0.5 * (stroke.width - pixel).max(0.0);
    let mut mesh = Mesh::default();
    mesh.reserve_vertices(4 * bars.len());
    mesh.reserve_triangles(6 * bars.len());
    for (at, (x, low, high)) in bars.into_iter().enumerate() {
        let faded = Color32::TRANSPARENT;
        for (y, color) in [
            (low - half - pixel, faded),
            (low - half, stroke.color),
            (high + half, stroke.color),
            (high + half + pixel, faded),
        ] {
            mesh.colored_vertex(Pos2::new(x, y), color);
        }
        if let Some(left) = (4 * at as u32).checked_sub(4) {
            for edge in left..left + 3 {
                mesh.add_triangle(edge, edge + 1, edge + 4);
                mesh.add_triangle(edge + 1, edge + 4, edge + 5);
            }
        }
    }
    Some(mesh)
}

/// Returns the visible dashes of a dashed line. Each dash is a shape, so the dashes outside the frame are omitted: a zoomed
/// line may have millions.
fn dashes(points: &[Pos2], stroke: Stroke, [dash, gap]: [f32; 2], frame: &Rect) -> Vec<Shape> {
    let period = dash + gap;
    let seen = frame.expand(period + stroke.width);
    let mut shapes = Vec::new();
    // Visible part of the line, and the offset of its dash pattern. The length of the hidden line before it counts for the
    // offset.
    let (mut part, mut offset): (Vec<Pos2>, f32) = (Vec::new(), 0.0);
    let mut end = |part: &mut Vec<Pos2>, offset| {
        if part.len() > 1 {
            let dashed = Shape::dashed_line_with_offset(part, stroke, &[dash], &[gap], offset);
            shapes.extend(dashed);
        }
        part.clear();
    };
    let mut length = 0.0;
    for ends in points.windows(2) {
        if let Some([from, to]) = within(seen, [ends[0], ends[1]]) {
            if part.is_empty() || from != ends[0] {
                end(&mut part, offset);
                let before = length + f64::from(ends[0].distance(from));
                offset = (-before).rem_euclid(f64::from(period)) as f32;
                part.push(from);
            }
            part.push(to);
            if to != ends[1] {
                end(&mut part, offset);
            }
        } else {
            end(&mut part, offset);
        }
        length += f64::from(ends[0].distance(ends[1]));
    }
    end(&mut part, offset);
    shapes
}

/// Returns the part of a line inside a rectangle. It is computed in double precision, because the line may end far outside.
fn within(rect: Rect, ends: [Pos2; 2]) -> Option<[Pos2; 2]> {
    let limits = [rect.left(), rect.top(), rect.right(), rect.bottom()].map(f64::from);
    let [from, to] = ends.map(|end| [f64::from(end.x), f64::from(end.y)]);
    Some(part_inside(limits, from, to)?.map(|[x, y]| Pos2::new(x as f32, y as f32)))
}

/// Plot item that consists of many shapes, because a plot with thousands of items is slow.
pub struct Shapes<F> {
    base: PlotItemBase,
    color: Color32,
    draw: F,
}

impl<F: Fn(&Ui, &PlotTransform, &mut Vec<Shape>)> Shapes<F> {
    /// Returns a plot item whose shapes are appended by `draw`.
    pub fn new(name: &str, color: Color32, draw: F) -> Self {
        Self { base: PlotItemBase::new(name.to_owned()), color, draw }
    }
}

pub fn piece_shapes(
    piece: &[[f64; 2]],
    (stroke, dash): (Stroke, Option<[f32; 2]>),
    transform: &PlotTransform,
    pixel: f32,
    shapes: &mut Vec<Shape>,
) {
    let points: Vec<Pos2> = (piece.iter())
        .map(|[x, y]| transform.position_from_point(&PlotPoint::new(*x, *y)))
        .collect();
    match dash {
        Some(dash) => shapes.extend(dashes(&points, stroke, dash, transform.frame())),
        None => {
            let dense = is_dense(&points, pixel);
            let strip = dense.then(|| strip(&points, stroke, pixel)).flatten();
            let line = || Shape::line(points, stroke);
            shapes.push(strip.map_or_else(line, Shape::mesh));
        }
    }
}

impl<F: Fn(&Ui, &PlotTransform, &mut Vec<Shape>)> PlotItem for Shapes<F> {
    fn shapes(&self, ui: &Ui, transform: &PlotTransform, shapes: &mut Vec<Shape>) {
        (self.draw)(ui, transform, shapes);
    }

    fn initialize(&mut self, _x_range: std::ops::RangeInclusive<f64>) {}

    fn color(&self) -> Color32 {
        self.color
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

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn a_dense_line_covers_what_its_points_do_and_narrows_over_a_pause() {
        let wave = |k: i32| pos2(0.25 * k as f32, 50.0 + 20.0 * ((k * 7) % 5) as f32);
        let mut points: Vec<Pos2> = (0..400).map(wave).collect();
        // Nothing for a hundred pixels, then more.
        points.extend((800..1000).map(wave));
        assert!(is_dense(&points, 1.0));
        assert!(!is_dense(&points[..12], 1.0), "few points stay a line");
        let slope = |k: i32| pos2(0.25 * k as f32, 2.0 * k as f32);
        let slope: Vec<Pos2> = (0..400).map(slope).collect();
        let white = Stroke::new(2.0, Color32::WHITE);
        assert_eq!(strip(&slope, white, 1.0), None);
        let mesh = strip(&points, white, 1.0).unwrap();
        assert!(mesh.is_valid());
        let solid = mesh.vertices.iter().filter(|vertex| vertex.color == Color32::WHITE);
        let solid: Vec<Pos2> = solid.map(|vertex| vertex.pos).collect();
        for point in &points {
            let near = solid.iter().filter(|place| (place.x - point.x).abs() <= 1.0);
            let (low, high) = near
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), place| {
                    (low.min(place.y), high.max(place.y))
                });
            assert!(low < point.y && point.y < high, "{point:?}");
            assert!(low >= 49.0 && high <= 131.0, "half a line beyond the points at most");
        }
        let last = points[399];
        let narrow: Vec<f32> = (solid.iter())
            .filter(|place| place.x == last.x)
            .map(|place| place.y - last.y)
            .collect();
        assert_eq!(narrow, [-0.5, 0.5]);
        assert!(solid.len() < 2 * 160);
    }

    #[test]
    fn a_dashed_line_is_cut_to_what_is_seen_and_no_further() {
        let (stroke, dash) = (Stroke::new(1.0, Color32::WHITE), [6.0, 4.0]);
        let frame = Rect::from_min_max(pos2(0.0, 0.0), pos2(500.0, 300.0));
        let seen = [pos2(10.0, 10.0), pos2(400.0, 200.0), pos2(90.0, 250.0)];
        let all = Shape::dashed_line(&seen, stroke, dash[0], dash[1]);
        assert_eq!(dashes(&seen, stroke, dash, &frame), all);
        // A zoom of 10⁹.
        let far = [pos2(-1e9, 0.0), pos2(1e9, 200.0), pos2(3.0, 1e12), pos2(-4.0, -1e12)];
        let dashed = dashes(&far, stroke, dash, &frame);
        assert!((20..200).contains(&dashed.len()), "{}", dashed.len());
        // The dashes of the visible part stand as if counted from the beginning of the line.
        let long = [pos2(-1000.0, 50.0), pos2(2000.0, 50.0)];
        let whole = Shape::dashed_line(&long, stroke, dash[0], dash[1]);
        let dashed = dashes(&long, stroke, dash, &frame);
        let is_seen = |shape: &&Shape| frame.intersects(shape.visual_bounding_rect());
        let starts = |shapes: &[Shape]| -> Vec<f32> {
            let seen = shapes.iter().filter(is_seen);
            seen.map(|shape| shape.visual_bounding_rect().left().round()).collect()
        };
        assert_eq!(starts(&dashed), starts(&whole));
        assert!(dashes(&[pos2(-9.0, -99.0), pos2(600.0, -99.0)], stroke, dash, &frame).is_empty());
    }
}
