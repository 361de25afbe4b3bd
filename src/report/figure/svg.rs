//! SVG 1.1 image of a figure, in a single file. Text is escaped. Numbers that are not finite are omitted. The same figure
//! gives the same file.

use std::fmt::{self, Write as _};

use crate::{
    report::figure::{
        cloud::{CloudPicture, base64},
        color,
        parts::{Figure, HeatMap, Line, Scale},
    },
    scoring::{
        loops::{Frame, inside},
        numbers::{tick_text, ticks},
    },
    shown::for_xml,
};

/// Margins around the plot (SVG units): left, top, right, bottom.
const ROOM: [f64; 4] = [80.0, 50.0, 24.0, 60.0];
/// Right margin of a plot with a colour scale (SVG units).
const ROOM_FOR_SHADES: f64 = 120.0;
/// Approximate minimum distance between ticks of the horizontal and of the vertical scale (SVG units).
const APART: (f64, f64) = (80.0, 45.0);
/// Maximum number of labelled cells along a scale.
const MAX_NAMED_CELLS: usize = 12;
/// Distance outside the plot up to which lines are drawn (SVG units), so that no line ends are visible at the plot's edge.
const BEYOND: f64 = 40.0;

impl Figure<'_> {
    /// Returns the figure as SVG of this width and height, with ticks, labels and a legend.
    pub fn svg(&self, (width, height): (f64, f64)) -> String {
        let [left, top, mut right, bottom] = ROOM;
        if self.heat_map.is_some() {
            right = ROOM_FOR_SHADES;
        }
        let (plot, size) = ([left, top, width - right, height - bottom], (width, height));
        let mut svg = String::new();
        Svg { figure: self, size, plot }
            .write(&mut svg)
            .expect("writing to a text in memory never fails");
        svg
    }
}

/// Returns several figures of this size below one another as one SVG image; a single figure as itself.
pub fn stacked_svg(figures: &[Figure<'_>], size: (f64, f64)) -> String {
    if let [figure] = figures {
        return figure.svg(size);
    }
    let (width, height) = size;
    let total = height * figures.len() as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {total}\" width=\"{width}\" height=\"{total}\">\n"
    );
    for (at, figure) in figures.iter().enumerate() {
        let down = height * at as f64;
        let part = figure.svg(size);
        svg += &part.replacen("<svg ", &format!("<svg y=\"{down}\" "), 1);
    }
    svg + "</svg>\n"
}

struct Svg<'a> {
    figure: &'a Figure<'a>,
    size: (f64, f64),
    plot: [f64; 4],
}

impl Svg<'_> {
    fn write(&self, out: &mut String) -> fmt::Result {
        let ((width, height), [left, top, right, bottom]) = (self.size, self.plot);
        let (across, up) = ((left + right) / 2.0, (top + bottom) / 2.0);
        let figure = self.figure;
        writeln!(
            out,
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="sans-serif" font-size="13" role="img" aria-label="{}">"#,
            for_xml(&figure.described())
        )?;
        writeln!(out, r#"<rect width="100%" height="100%" fill="white"/>"#)?;
        if let Some((from, to)) = figure.shaded {
            let from = self.x(from);
            let width = (self.x(to) - from).max(1.0);
            rect(out, [from, top, width, bottom - top], r##"fill="#e8e8e8""##)?;
        }
        match &figure.heat_map {
            Some(map) => self.cells(map, out)?,
            None => self.grid(out)?,
        }
        self.clouds(out)?;
        if let Some(marked) = figure.marked.map(|marked| self.x(marked)) {
            let style = r##"stroke="#666" stroke-dasharray="2 3""##;
            writeln!(out, r#"<path d="M{marked:.1} {top}V{bottom}" {style}/>"#)?;
        }
        for line in &figure.lines {
            self.line(line, out)?;
        }
        self.arrows(out)?;
        // Lines outside the plot are covered, because not every SVG viewer supports clipping.
        writeln!(
            out,
            r#"<path fill="white" fill-rule="evenodd" d="M0 0H{width}V{height}H0ZM{left} {top}H{right}V{bottom}H{left}Z"/>"#
        )?;
        writeln!(out, r#"<g font-size="15">"#)?;
        text(out, (across, 20.0), "middle", &figure.title)?;
        writeln!(out, "</g>")?;
        self.ticks(out)?;
        let frame = [left, top, right - left, bottom - top];
        rect(out, frame, r##"fill="none" stroke="#444""##)?;
        text(out, (across, height - 16.0), "middle", &figure.across.label)?;
        upright(out, (20.0, up), &figure.up.label)?;
        if let Some(map) = &figure.heat_map {
            self.shades(&map.shades, out)?;
        }
        self.legend(out)?;
        writeln!(out, "</svg>")
    }

    fn x(&self, value: f64) -> f64 {
        limited(self.far_x(value))
    }

    fn y(&self, value: f64) -> f64 {
        limited(self.far_y(value))
    }

    fn far_x(&self, value: f64) -> f64 {
        far(value, self.figure.across.range, self.plot[0], self.plot[2])
    }

    fn far_y(&self, value: f64) -> f64 {
        far(value, self.figure.up.range, self.plot[3], self.plot[1])
    }

    fn named(&self) -> [Vec<(f64, String)>; 2] {
        let [left, top, right, bottom] = self.plot;
        let across = named(&self.figure.across, (right - left) / APART.0).into_iter();
        let up = named(&self.figure.up, (bottom - top) / APART.1).into_iter();
        [
            across.map(|(value, name)| (self.x(value), name)).collect(),
            up.map(|(value, name)| (self.y(value), name)).collect(),
        ]
    }

    fn grid(&self, out: &mut String) -> fmt::Result {
        let [left, top, right, bottom] = self.plot;
        let [across, up] = self.named();
        let across = across.iter().map(|(x, _)| format!("M{x:.1} {top}V{bottom}"));
        let up = up.iter().map(|(y, _)| format!("M{left} {y:.1}H{right}"));
        let lines: String = across.chain(up).collect();
        writeln!(out, r##"<path d="{lines}" stroke="#ddd"/>"##)
    }

    fn ticks(&self, out: &mut String) -> fmt::Result {
        let [left, _, _, bottom] = self.plot;
        let [across, up] = self.named();
        for (x, name) in across {
            writeln!(out, r##"<path d="M{x:.1} {bottom}v4" stroke="#444"/>"##)?;
            text(out, (x, bottom + 18.0), "middle", &name)?;
        }
        for (y, name) in up {
            writeln!(out, r##"<path d="M{left} {y:.1}h-4" stroke="#444"/>"##)?;
            text(out, (left - 8.0, y + 4.0), "end", &name)?;
        }
        Ok(())
    }

    fn clouds(&self, out: &mut String) -> fmt::Result {
        for picture in CloudPicture::of(&self.figure.clouds, 1) {
            let Frame { loads, outputs } = picture.frame;
            let (left, right) = (self.x(loads.0), self.x(loads.1));
            let (top, bottom) = (self.y(outputs.1), self.y(outputs.0));
            let Ok(png) = picture.png() else {
                continue;
            };
            writeln!(
                out,
                r#"<image x="{left:.2}" y="{top:.2}" width="{:.2}" height="{:.2}" preserveAspectRatio="none" href="data:image/png;base64,{}"/>"#,
                right - left,
                bottom - top,
                base64(&png)
            )?;
        }
        Ok(())
    }

    fn line(&self, line: &Line<'_>, out: &mut String) -> fmt::Result {
        write!(out, r#"<path {} d=""#, style(line))?;
        for piece in &line.pieces {
            let finite = piece.iter().filter(|[x, y]| x.is_finite() && y.is_finite());
            let mut places = finite.map(|[across, up]| [self.far_x(*across), self.far_y(*up)]);
            let Some(mut from) = places.next() else {
                continue;
            };
            // End of the last line segment that was drawn; `None` before the first.
            let mut pen = None;
            for to in places {
                if let Some([start, end]) = self.on_paper(from, to) {
                    if pen != Some(start) {
                        write!(out, "M{:.1} {:.1}", start[0], start[1])?;
                    }
                    write!(out, "L{:.1} {:.1}", end[0], end[1])?;
                    pen = Some(end);
                }
                from = to;
            }
        }
        writeln!(out, r#""/>"#)
    }

    fn arrows(&self, out: &mut String) -> fmt::Result {
        for arrow in &self.figure.arrows {
            let corners = arrow.corners(|[across, up]| [self.x(across), self.y(up)]);
            if let Some([tip, one, other]) = corners {
                writeln!(
                    out,
                    r#"<path class="arrow" fill="{}" d="M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z"/>"#,
                    hex(arrow.color),
                    tip[0],
                    tip[1],
                    one[0],
                    one[1],
                    other[0],
                    other[1]
                )?;
            }
        }
        Ok(())
    }

    /// Returns the part of a line segment that is inside or near the plot; `None` if the segment is outside. This part keeps
    /// its exact place even if the segment ends far outside.
    fn on_paper(&self, from: [f64; 2], to: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let [left, top, right, bottom] = self.plot;
        part_inside([left - BEYOND, top - BEYOND, right + BEYOND, bottom + BEYOND], from, to)
    }

    fn legend(&self, out: &mut String) -> fmt::Result {
        let lines = self.figure.lines.iter();
        let named: Vec<_> = lines.filter(|line| !line.name.is_empty()).collect();
        let [left, top, right, _] = self.plot;
        let room = (right - left) / named.len().max(1) as f64;
        for (at, line) in named.into_iter().enumerate() {
            let (start, row) = (left + room * at as f64, top - 10.0);
            writeln!(out, r#"<path {} d="M{start:.1} {row}h26"/>"#, style(line))?;
            text(out, (start + 32.0, row + 4.0), "start", &line.name)?;
        }
        Ok(())
    }

    fn cells(&self, map: &HeatMap, out: &mut String) -> fmt::Result {
        let n_up = self.figure.up.cells.len().max(1);
        let (width, height) = (self.x(1.0) - self.x(0.0), self.y(0.0) - self.y(1.0));
        let cell = |(across, up): (usize, usize)| {
            [self.x(across as f64), self.y((up + 1) as f64), width, height]
        };
        writeln!(out, r#"<g shape-rendering="crispEdges">"#)?;
        for (at, value) in map.values.iter().enumerate() {
            let fill = match value.filter(|value| value.is_finite()) {
                Some(value) => hex(color::shade(far(value, map.shades.range, 0.0, 1.0), false)),
                None => "#d0d0d0".to_owned(),
            };
            rect(out, cell((at / n_up, at % n_up)), &format!(r#"fill="{fill}""#))?;
        }
        writeln!(out, "</g>")?;
        let Some(marked) = map.marked.map(cell) else {
            return Ok(());
        };
        rect(out, marked, r#"fill="none" stroke="white" stroke-width="4""#)?;
        rect(out, marked, r#"fill="none" stroke="black" stroke-width="2""#)
    }

    fn shades(&self, scale: &Scale, out: &mut String) -> fmt::Result {
        let [_, top, right, bottom] = self.plot;
        let (left, width) = (right + 22.0, 18.0);
        let height = (bottom - top) / color::SHADES as f64;
        for at in 0..color::SHADES {
            let y = bottom - (at + 1) as f64 * height;
            let fill = hex(color::shade((at as f64 + 0.5) / color::SHADES as f64, false));
            // The steps of the colour scale overlap slightly, so that no gaps are visible between them.
            rect(out, [left, y, width, height + 0.5], &format!(r#"fill="{fill}""#))?;
        }
        for (value, name) in named(scale, (bottom - top) / APART.1) {
            let y = limited(far(value, scale.range, bottom, top));
            text(out, (left + width + 6.0, y + 4.0), "start", &name)?;
        }
        upright(out, (self.size.0 - 10.0, (top + bottom) / 2.0), &scale.label)
    }
}

/// Returns the positions and labels of a scale's ticks: the values of the cells, or about `most` round numbers.
fn named(scale: &Scale, most: f64) -> Vec<(f64, String)> {
    let (low, high) = scale.range;
    let (step, ticks) = ticks((low, high), (high - low) / most);
    if scale.cells.is_empty() {
        let texts = ticks.iter().map(|tick| (*tick, tick_text(*tick, step)));
        return texts.collect();
    }
    let every = scale.cells.len().div_ceil(MAX_NAMED_CELLS);
    let cells = scale.cells.iter().enumerate().step_by(every);
    cells.map(|(at, value)| (at as f64 + 0.5, value.to_string())).collect()
}

/// Returns the position of a value along a scale of the image (SVG units), which may be far outside the plot.
fn far(value: f64, (low, high): (f64, f64), start: f64, end: f64) -> f64 {
    let share = if high > low { (value - low) / (high - low) } else { 0.5 };
    // The limit keeps the product below the largest floating-point number.
    start + (end - start) * share.clamp(-1e100, 1e100)
}

/// Returns the nearest position that SVG viewers can draw.
fn limited(position: f64) -> f64 {
    position.clamp(-1e4, 1e4)
}

fn rect(out: &mut String, [x, y, width, height]: [f64; 4], style: &str) -> fmt::Result {
    writeln!(
        out,
        r#"<rect x="{x:.2}" y="{y:.2}" width="{width:.2}" height="{height:.2}" {style}/>"#
    )
}

fn text(out: &mut String, at: (f64, f64), anchor: &str, words: &str) -> fmt::Result {
    writeln!(
        out,
        r#"<text x="{:.1}" y="{:.1}" text-anchor="{anchor}">{}</text>"#,
        at.0,
        at.1,
        for_xml(words)
    )
}

fn upright(out: &mut String, (x, y): (f64, f64), words: &str) -> fmt::Result {
    writeln!(
        out,
        r#"<text transform="translate({x} {y}) rotate(-90)" text-anchor="middle">{}</text>"#,
        for_xml(words)
    )
}

fn style(line: &Line<'_>) -> String {
    let dash = line
        .dash
        .map_or_else(String::new, |[dash, gap]| format!(r#" stroke-dasharray="{dash} {gap}""#));
    format!(
        r#"fill="none" stroke="{}" stroke-opacity="{}" stroke-width="{}" stroke-linejoin="round"{dash}"#,
        hex(line.color),
        line.opacity,
        line.width
    )
}

fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Returns the part of a line inside the rectangle of these limits (left, top, right, bottom); `None` if the line is outside. An end inside the rectangle stays exactly where it is.
pub fn part_inside(
    [left, top, right, bottom]: [f64; 4],
    from: [f64; 2],
    to: [f64; 2],
) -> Option<[[f64; 2]; 2]> {
    let (start, end) = inside([[left, top], [right, bottom]], from, to)?;
    let at = |share: f64| match share {
        0.0 => from,
        1.0 => to,
        _ => [0, 1].map(|i| from[i] + share * (to[i] - from[i])),
    };
    Some([at(start), at(end)])
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::report::figure::DASHED;
    use crate::report::figure::cloud::Cloud;
    use crate::scoring::loops::{Outline, outline};

    const SIZE: (f64, f64) = (800.0, 600.0);

    fn figure(title: &str, range: (f64, f64)) -> Figure<'static> {
        let points = vec![[0.0, 0.0], [5.0, f64::NAN], [10.0, 1.0]];
        Figure {
            title: title.to_owned(),
            across: Scale::new("Fx [N]", range),
            up: Scale::new("error [N]", range),
            lines: vec![Line {
                dash: Some(DASHED),
                ..Line::new("Uncompensated", [213, 94, 0], [points])
            }],
            ..Figure::default()
        }
    }

    /// 0 to 10 maps to 80 to 776 horizontally and 540 to 50 vertically, so the point (10, 1) is at (776, 491).
    #[test]
    fn points_are_placed_by_the_scales() {
        let svg = figure("Loops", (0.0, 10.0)).svg(SIZE);
        assert!(svg.contains(r#"d="M80.0 540.0L776.0 491.0""#), "{svg}");
        assert!(svg.contains("#d55e00") && svg.contains("stroke-dasharray"));
        assert!(svg.contains(">Fx [N]</text>") && svg.contains(">Uncompensated</text>"));
        assert!(svg.contains(">10</text>") && !svg.contains("NaN"));
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    }

    #[test]
    fn every_point_is_drawn() {
        let points: Vec<[f64; 2]> = (0..500)
            .map(|k| [0.02 * f64::from(k), 5.0 + 4.9 * (f64::from(k) * 1.3).sin()])
            .collect();
        let svg = Figure {
            lines: vec![Line::new("", [0; 3], [points.clone()])],
            ..figure("", (0.0, 10.0))
        }
        .svg(SIZE);
        let line = svg.lines().find(|line| line.contains("L")).unwrap();
        let drawn = line.split(" d=\"M").nth(1).unwrap().split('"').next().unwrap();
        let drawn: Vec<&str> = drawn.split('L').collect();
        assert_eq!(drawn.len(), points.len());
        for (place, [x, y]) in drawn.iter().zip(points) {
            let (across, up) = place.split_once(' ').unwrap();
            let off = |text: &str, expected: f64| (text.parse::<f64>().unwrap() - expected).abs();
            assert!(off(across, 80.0 + 69.6 * x) < 0.1 && off(up, 540.0 - 49.0 * y) < 0.1);
        }
    }

    #[test]
    fn a_density_covers_its_frame() {
        let frame = Frame { loads: (0.0, 5.0), outputs: (0.0, 10.0) };
        let path = [[0.0, 0.0], [5.0, 10.0]];
        let Outline::Density(density) = outline([path], frame, [40.0, 30.0], 0) else {
            panic!("no point is allowed")
        };
        let svg = Figure {
            clouds: vec![Cloud { density: Arc::new(density), color: [9, 9, 9] }],
            ..figure("", (0.0, 10.0))
        }
        .svg(SIZE);
        let start = r#"<image x="80.00" y="50.00" width="348.00" height="490.00""#;
        assert!(svg.contains(start) && svg.contains("data:image/png;base64,iVBOR"), "{svg}");
    }

    /// A line from (0, 0) to far above the right end keeps its direction inside the plot.
    #[test]
    fn a_line_that_leaves_the_picture_keeps_its_way() {
        let points = vec![[0.0, 0.0], [1e7, 5e6], [5.0, -1e9], [5.0, 5.0]];
        let svg =
            Figure { lines: vec![Line::new("", [0; 3], [points])], ..figure("", (0.0, 10.0)) }
                .svg(SIZE);
        // 10 horizontally is 5 vertically: the middle of the right edge. The line goes on by the part that is drawn beside
        // the plot.
        let (x, y) = (776.0 + BEYOND, 540.0 - 245.0 * (1.0 + BEYOND / 696.0));
        assert!(svg.contains(&format!("M80.0 540.0L{x:.1} {y:.1}")), "{svg}");
        assert!(svg.contains(&format!("M428.0 {:.1}L428.0 295.0", 540.0 + BEYOND)), "{svg}");
    }

    /// The scale is as above: 2 is at 219.2, 4 at 358.4 horizontally.
    #[test]
    fn an_interval_is_shaded_and_a_place_marked() {
        let svg = Figure { shaded: Some((2.0, 4.0)), marked: Some(2.0), ..figure("", (0.0, 10.0)) }
            .svg(SIZE);
        assert!(svg.contains(r#"<rect x="219.20" y="50.00" width="139.20" height="490.00""#));
        assert!(svg.contains(r#"<path d="M219.2 50V540""#), "{svg}");
    }

    #[test]
    fn names_cannot_break_the_picture() {
        let svg = figure("a<b>&\"c\"\u{1}", (0.0, 1.0)).svg(SIZE);
        let safe = r"a&lt;b&gt;&amp;&quot;c&quot;\u{1}</text>";
        assert!(svg.contains(safe), "{svg}");
    }

    #[test]
    fn an_empty_scale_gives_a_picture_without_numbers_that_are_none() {
        let empty = Figure { heat_map: Some(HeatMap::default()), ..Figure::default() };
        for figure in [figure("", (1.0, 1.0)), Figure::default(), empty] {
            let svg = figure.svg(SIZE);
            assert!(!svg.contains("inf") && !svg.contains("NaN"), "{svg}");
            assert!(svg.ends_with("</svg>\n"));
        }
    }

    /// Two by two cells between 80 and 680 horizontally and between 540 and 50 vertically.
    #[test]
    fn least_and_greatest_have_the_ends_of_the_colours_and_gaps_are_grey() {
        let values = vec![Some(1.0), Some(3.0), None, Some(f64::NAN)];
        let known = values.iter().copied().flatten();
        let svg = Figure {
            across: Scale::of_cells("F_th [N]", &[0.0, 1.5]),
            up: Scale::of_cells("t_th [s]", &[1.0, 2.0]),
            heat_map: Some(HeatMap {
                shades: Scale::spanning("N & <m>", known, 0.0),
                values,
                marked: Some((0, 0)),
            }),
            ..Figure::default()
        }
        .svg(SIZE);
        // The first pair is at the lower left, the second above it.
        let cell = r#"width="300.00" height="245.00""#;
        let below = format!(r##"x="80.00" y="295.00" {cell} fill="#084083""##);
        let above = format!(r##"x="80.00" y="50.00" {cell} fill="#eaf3fb""##);
        assert!(svg.contains(&below) && svg.contains(&above), "{svg}");
        assert_eq!(svg.matches("fill=\"#d0d0d0\"").count(), 2);
        assert!(svg.contains(">1.5</text>") && svg.contains("N &amp; &lt;m&gt;"));
        assert!(!svg.contains("NaN"));
    }
}
