//! Curves over one number.

use std::io;

use super::Labels;
use super::frame::{Anchor, BOTTOM, LEFT, Page, RIGHT, Scale, TOP};
use crate::recording::write_csv::CsvWriter;

/// Colours that people with any sight can tell apart (Okabe and Ito).
const COLOURS: [&str; 6] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9",
];
/// What tells lines apart that are not marked as dashed, where there is no colour.
const DASHES: [&str; 3] = ["", "2 4", "12 3 2 3"];
/// Room above and below the curves, as a share of their range.
const ROOM: f64 = 0.06;

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// What the legend calls it.
    pub label: String,
    /// Its points, in the order in which they are joined.
    pub points: Vec<(f64, f64)>,
    /// Whether it is dashed.
    pub dashed: bool,
}

/// Some curves, with what matters along x.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvePlot {
    /// Title and axes.
    pub labels: Labels,
    /// The curves.
    pub lines: Vec<Line>,
    /// A range of x that is shaded.
    pub shaded: Option<(f64, f64)>,
    /// An x that is marked by an upright line.
    pub marked: Option<f64>,
}

/// Draws the curves.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_curves_svg(plot: &CurvePlot, out: &mut dyn io::Write) -> io::Result<()> {
    let mut page = Page::new(&plot.labels);
    let points = || {
        plot.lines
            .iter()
            .flat_map(|line| line.points.iter().copied())
    };
    let x = Scale::spanning(points().map(|(x, _)| x), 0.0, LEFT, RIGHT);
    let y = Scale::spanning(points().map(|(_, y)| y), ROOM, BOTTOM, TOP);
    if let Some((from, to)) = plot.shaded {
        let [from, to] = [from, to].map(|edge| x.place(edge).clamp(LEFT, RIGHT));
        let (width, height) = ((to - from).max(1.0), BOTTOM - TOP);
        page.element(format_args!(
            "<rect x=\"{from:.1}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height}\" fill=\"#e4e4e4\"/>"
        ));
    }
    for (tick, text) in x.ticks() {
        page.tick_x(x.place(tick), &text);
    }
    for (tick, text) in y.ticks() {
        page.tick_y(y.place(tick), &text);
    }
    if let Some(marked) = plot.marked.map(|marked| x.place(marked))
        && (LEFT..=RIGHT).contains(&marked)
    {
        page.element(format_args!(
            "<path d=\"M{marked:.1} {TOP}V{BOTTOM}\" stroke=\"#666666\" stroke-dasharray=\"2 3\"/>"
        ));
    }
    let mut n_solid = 0;
    for (at, line) in plot.lines.iter().enumerate() {
        let colour = COLOURS[at % COLOURS.len()];
        let pattern = if line.dashed {
            "6 4"
        } else {
            n_solid += 1;
            DASHES[(n_solid - 1) % DASHES.len()]
        };
        let dash = match pattern {
            "" => String::new(),
            pattern => format!(" stroke-dasharray=\"{pattern}\""),
        };
        let finite = line
            .points
            .iter()
            .filter(|(x, y)| x.is_finite() && y.is_finite());
        let places: Vec<String> = finite
            .map(|&(px, py)| format!("{:.2},{:.2}", x.place(px), y.place(py)))
            .collect();
        let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"{dash}");
        page.element(format_args!(
            "<polyline points=\"{}\" {style}/>",
            places.join(" ")
        ));
        let row = TOP + 14.0 + 20.0 * at as f64;
        let (start, end) = (RIGHT + 12.0, RIGHT + 36.0);
        page.element(format_args!(
            "<path d=\"M{start} {:.1}H{end}\" {style}/>",
            row - 4.0
        ));
        page.text(end + 6.0, row, Anchor::Start, &line.label);
    }
    out.write_all(page.finish().as_bytes())
}

/// Writes the curves as a long table: one row per point, with its curve's name.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_curves_csv(plot: &CurvePlot, out: &mut dyn io::Write) -> io::Result<()> {
    let mut csv = CsvWriter::new(out);
    csv.row(["curve", &plot.labels.x, &plot.labels.y])?;
    for line in &plot.lines {
        for (x, y) in &line.points {
            csv.row([&line.label, &x.to_string(), &y.to_string()])?;
        }
    }
    csv.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> CurvePlot {
        let line = |label: &str, points: &[(f64, f64)]| Line {
            label: label.to_owned(),
            points: points.to_vec(),
            dashed: false,
        };
        CurvePlot {
            labels: Labels {
                title: "RMSE of <forces> & more".to_owned(),
                x: "F_th [N]".to_owned(),
                y: "RMSE [N]".to_owned(),
            },
            lines: vec![
                line("train", &[(0.0, 2.0), (10.0, 1.0)]),
                line("test \"x\"", &[(0.0, 3.0), (5.0, f64::NAN), (10.0, 2.0)]),
            ],
            shaded: Some((2.0, 4.0)),
            marked: Some(3.0),
        }
    }

    /// From (0, 2) at the left edge to (10, 1) at the right; y spans 1 to 3 with 0.12 of room, so 1 stands at
    /// `384 − 340 · 0.12 / 2.24` and 2 in the middle.
    #[test]
    fn points_stand_where_their_numbers_say() {
        let mut out = Vec::new();
        write_curves_svg(&plot(), &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(
            text.contains("points=\"76.00,214.00 570.00,365.79\""),
            "{text}"
        );
        assert_eq!(text.matches("<polyline").count(), 2);
        assert!(!text.contains("NaN") && !text.contains("<forces>"));
        assert!(text.contains("RMSE of &lt;forces&gt; &amp; more"));
        assert!(text.starts_with("<svg ") && text.ends_with("</svg>\n"));
    }

    #[test]
    fn no_curves_make_an_empty_plot() {
        let mut out = Vec::new();
        write_curves_svg(&CurvePlot::default(), &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }

    #[test]
    fn the_table_has_a_row_for_every_point() {
        let mut out = Vec::new();
        write_curves_csv(&plot(), &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text.lines().count(), 6);
        assert_eq!(text.lines().next().unwrap(), "curve,F_th [N],RMSE [N]");
        assert_eq!(text.lines().nth(1).unwrap(), "train,0,2");
        assert!(text.contains("\"test \"\"x\"\"\",10,2"));
    }
}
