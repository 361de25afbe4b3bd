//! A plot of lines over two scales, and how it becomes a picture that stays sharp at any size (SVG 1.1).

use std::borrow::Cow;
use std::io;

use crate::evaluation::numbers::{mark_label, mark_step};

/// Width and height of a picture that stands alone, in its own units.
pub const PICTURE_SIZE: (f64, f64) = (800.0, 600.0);
/// What is left free around the plot: left, top, right, bottom.
const ROOM: [f64; 4] = [80.0, 44.0, 20.0, 60.0];
/// About so far apart marks stand at least, along and up.
const MARKS: (f64, f64) = (80.0, 45.0);

/// One of the two scales.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// What is measured, with its unit.
    pub label: String,
    /// Least and greatest value on the picture.
    pub range: (f64, f64),
}

/// A line in one or more pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnLine<'a> {
    /// What it is; lines with an empty name are not in the legend.
    pub name: String,
    /// Red, green, blue.
    pub color: [u8; 3],
    /// From 0, invisible, to 1.
    pub opacity: f32,
    /// In points of the screen.
    pub width: f32,
    /// Whether it is broken into dashes.
    pub dashed: bool,
    /// Points `[across, up]`; pieces are not joined.
    pub pieces: Vec<Cow<'a, [[f64; 2]]>>,
}

/// A plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing<'a> {
    /// What it shows.
    pub title: String,
    /// What goes across.
    pub across: Scale,
    /// What goes up.
    pub up: Scale,
    /// In the order of drawing.
    pub lines: Vec<DrawnLine<'a>>,
}

/// Writes a plot as SVG of this width and height, with marks, labels and a legend.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_drawing_svg(
    drawing: &Drawing<'_>,
    (width, height): (f64, f64),
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let plot = [ROOM[0], ROOM[1], width - ROOM[2], height - ROOM[3]];
    let placed = Placed { drawing, plot };
    let [left, top, right, bottom] = plot;
    writeln!(
        out,
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="sans-serif" font-size="13">"#
    )?;
    writeln!(out, r#"<rect width="100%" height="100%" fill="white"/>"#)?;
    placed.grid(out)?;
    for line in &drawing.lines {
        placed.write_line(line, out)?;
    }
    // What runs out of the plot is covered rather than clipped: every reader of SVG can do that.
    writeln!(
        out,
        r#"<path fill="white" fill-rule="evenodd" d="M0 0H{width}V{height}H0ZM{left} {top}H{right}V{bottom}H{left}Z"/>"#
    )?;
    text(out, ((left + right) / 2.0, 20.0), "middle", &drawing.title)?;
    placed.mark_labels(out)?;
    writeln!(
        out,
        r##"<rect x="{left}" y="{top}" width="{}" height="{}" fill="none" stroke="#444"/>"##,
        right - left,
        bottom - top
    )?;
    text(
        out,
        ((left + right) / 2.0, height - 16.0),
        "middle",
        &drawing.across.label,
    )?;
    writeln!(
        out,
        r#"<text transform="translate(20 {}) rotate(-90)" text-anchor="middle">{}</text>"#,
        (top + bottom) / 2.0,
        escaped(&drawing.up.label)
    )?;
    placed.legend(out)?;
    writeln!(out, "</svg>")
}

/// A value's place on the picture; kept where a reader of SVG still computes well.
fn place(value: f64, (low, high): (f64, f64), start: f64, end: f64) -> f64 {
    let share = if high > low {
        (value - low) / (high - low)
    } else {
        0.5
    };
    (start + (end - start) * share).clamp(-1e4, 1e4)
}

/// A drawing with the place of its plot: left, top, right, bottom.
struct Placed<'a> {
    drawing: &'a Drawing<'a>,
    plot: [f64; 4],
}

impl Placed<'_> {
    fn x(&self, value: f64) -> f64 {
        place(value, self.drawing.across.range, self.plot[0], self.plot[2])
    }

    fn y(&self, value: f64) -> f64 {
        place(value, self.drawing.up.range, self.plot[3], self.plot[1])
    }

    /// Marks of both scales: value and label.
    fn marks(&self) -> [Vec<(f64, String)>; 2] {
        let [left, top, right, bottom] = self.plot;
        [
            marks_of(self.drawing.across.range, (right - left) / MARKS.0),
            marks_of(self.drawing.up.range, (bottom - top) / MARKS.1),
        ]
    }

    fn grid(&self, out: &mut dyn io::Write) -> io::Result<()> {
        let [left, top, right, bottom] = self.plot;
        let [across, up] = self.marks();
        for (value, _) in across {
            let at = self.x(value);
            grid_line(out, (at, top), (at, bottom))?;
        }
        for (value, _) in up {
            let at = self.y(value);
            grid_line(out, (left, at), (right, at))?;
        }
        Ok(())
    }

    fn mark_labels(&self, out: &mut dyn io::Write) -> io::Result<()> {
        let [left, _, _, bottom] = self.plot;
        let [across, up] = self.marks();
        for (value, label) in across {
            text(out, (self.x(value), bottom + 18.0), "middle", &label)?;
        }
        for (value, label) in up {
            text(out, (left - 6.0, self.y(value) + 4.0), "end", &label)?;
        }
        Ok(())
    }

    fn write_line(&self, line: &DrawnLine<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        write!(out, r#"<path {} d=""#, style(line))?;
        for piece in &line.pieces {
            for (at, [across, up]) in piece.iter().enumerate() {
                let letter = if at == 0 { 'M' } else { 'L' };
                write!(out, "{letter}{:.1} {:.1}", self.x(*across), self.y(*up))?;
            }
        }
        writeln!(out, r#""/>"#)
    }

    /// One row of named lines above the plot.
    fn legend(&self, out: &mut dyn io::Write) -> io::Result<()> {
        let lines = self.drawing.lines.iter();
        let named: Vec<_> = lines.filter(|line| !line.name.is_empty()).collect();
        let [left, _, right, _] = self.plot;
        let room = (right - left) / named.len().max(1) as f64;
        for (at, line) in named.into_iter().enumerate() {
            let start = left + room * at as f64;
            writeln!(out, r#"<path {} d="M{start:.1} 34h26"/>"#, style(line))?;
            text(out, (start + 32.0, 38.0), "start", &line.name)?;
        }
        Ok(())
    }
}

/// At most about `most` marks on a scale.
fn marks_of((low, high): (f64, f64), most: f64) -> Vec<(f64, String)> {
    let Some(step) = mark_step((high - low) / most) else {
        return Vec::new();
    };
    let all = (low / step).ceil() as i64..=(high / step).floor() as i64;
    all.map(|at| at as f64 * step)
        .map(|value| (value, mark_label(value, step)))
        .collect()
}

fn grid_line(out: &mut dyn io::Write, from: (f64, f64), to: (f64, f64)) -> io::Result<()> {
    writeln!(
        out,
        r##"<line x1="{:.1}" y1="{:.1}" x2="{:.1}" y2="{:.1}" stroke="#ddd"/>"##,
        from.0, from.1, to.0, to.1
    )
}

fn text(out: &mut dyn io::Write, at: (f64, f64), anchor: &str, words: &str) -> io::Result<()> {
    writeln!(
        out,
        r#"<text x="{:.1}" y="{:.1}" text-anchor="{anchor}">{}</text>"#,
        at.0,
        at.1,
        escaped(words)
    )
}

fn style(line: &DrawnLine<'_>) -> String {
    let [red, green, blue] = line.color;
    let dashes = if line.dashed {
        r#" stroke-dasharray="7 4""#
    } else {
        ""
    };
    format!(
        r##"fill="none" stroke="#{red:02x}{green:02x}{blue:02x}" stroke-opacity="{}" stroke-width="{}" stroke-linejoin="round"{dashes}"##,
        line.opacity, line.width
    )
}

/// Text that cannot be taken for markup.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            // XML has no place for these at all.
            control if control.is_control() => safe.push(' '),
            other => safe.push(other),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    fn svg(title: &str, range: (f64, f64)) -> String {
        let points = [[0.0, 0.0], [10.0, 1.0]];
        let scale = |label: &str| Scale {
            label: label.to_owned(),
            range,
        };
        let drawing = Drawing {
            title: title.to_owned(),
            across: scale("Fx [N]"),
            up: scale("error [N]"),
            lines: vec![DrawnLine {
                name: "Conv.".to_owned(),
                color: [213, 94, 0],
                opacity: 1.0,
                width: 1.5,
                dashed: true,
                pieces: vec![points[..].into()],
            }],
        };
        let mut out = Vec::new();
        write_drawing_svg(&drawing, PICTURE_SIZE, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    /// 0 to 10 goes from 80 to 780 across and from 540 to 44 up, so the point (10, 1) stands at (780, 490.4).
    #[test]
    fn points_stand_where_the_scales_say() {
        let svg = svg("Loops", (0.0, 10.0));
        assert!(svg.contains(r#"d="M80.0 540.0L780.0 490.4""#), "{svg}");
        assert!(svg.contains("#d55e00") && svg.contains("stroke-dasharray"));
        assert!(svg.contains(">Fx [N]</text>") && svg.contains(">Conv.</text>"));
        assert!(svg.contains(">10</text>"));
    }

    #[test]
    fn names_cannot_break_the_picture() {
        let svg = svg("a<b>&\"c\"\u{1}", (0.0, 1.0));
        assert!(
            svg.contains("a&lt;b&gt;&amp;&quot;c&quot; </text>"),
            "{svg}"
        );
    }

    #[test]
    fn an_empty_scale_gives_a_picture_without_numbers_that_are_none() {
        let svg = svg("", (1.0, 1.0));
        assert!(!svg.contains("inf") && !svg.contains("NaN"), "{svg}");
    }
}
