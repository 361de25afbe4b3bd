//! What every picture has: a white page, a plot area with ticks, labels, and text that cannot break out.

use std::fmt::{self, Write as _};

use super::Labels;
use crate::evaluation::numbers::{round_step, significant};

/// The page (pixels).
pub(super) const WIDTH: f64 = 720.0;
pub(super) const HEIGHT: f64 = 440.0;
/// The plot area: left, top, right, bottom.
pub(super) const LEFT: f64 = 76.0;
pub(super) const TOP: f64 = 44.0;
pub(super) const RIGHT: f64 = 570.0;
pub(super) const BOTTOM: f64 = 384.0;
/// About so many steps between ticks.
const STEPS: f64 = 6.0;

/// A picture that is being drawn.
pub(super) struct Page(String);

/// Where a line of text hangs on its point.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Page {
    /// An empty page with labels around the plot area.
    pub fn new(labels: &Labels) -> Self {
        let mut page = Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
             viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"12\">\n"
        ));
        page.element(format_args!(
            "<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>"
        ));
        let (middle, centre) = ((LEFT + RIGHT) / 2.0, (TOP + BOTTOM) / 2.0);
        page.element(format_args!("<g font-size=\"15\">"));
        page.text(middle, TOP - 18.0, Anchor::Middle, &labels.title);
        page.element(format_args!("</g>"));
        page.text(middle, BOTTOM + 42.0, Anchor::Middle, &labels.x);
        page.element(format_args!("<g transform=\"rotate(-90 18 {centre})\">"));
        page.text(18.0, centre, Anchor::Middle, &labels.y);
        page.element(format_args!("</g>"));
        page
    }

    /// Adds an element; text in it must have been [`escaped`].
    pub fn element(&mut self, element: fmt::Arguments<'_>) {
        writeln!(self.0, "{element}").expect("a String takes all");
    }

    /// Adds a line of text.
    pub fn text(&mut self, x: f64, y: f64, anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.element(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escaped(text)
        ));
    }

    /// Adds a tick below the plot area.
    pub fn tick_x(&mut self, x: f64, text: &str) {
        let end = BOTTOM + 5.0;
        self.element(format_args!(
            "<path d=\"M{x:.1} {BOTTOM}V{end}\" stroke=\"black\"/>"
        ));
        self.text(x, BOTTOM + 19.0, Anchor::Middle, text);
    }

    /// Adds a tick beside the plot area.
    pub fn tick_y(&mut self, y: f64, text: &str) {
        let end = LEFT - 5.0;
        self.element(format_args!(
            "<path d=\"M{LEFT} {y:.1}H{end}\" stroke=\"black\"/>"
        ));
        self.text(LEFT - 9.0, y + 4.0, Anchor::End, text);
    }

    /// Frames the plot area and ends the picture.
    pub fn finish(mut self) -> String {
        let (width, height) = (RIGHT - LEFT, BOTTOM - TOP);
        self.element(format_args!(
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"black\"/>"
        ));
        self.0.push_str("</svg>\n");
        self.0
    }
}

/// Text that stays text: no markup, and nothing that XML does not allow.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&apos;"),
            '\u{fffe}' | '\u{ffff}' => safe.push('\u{fffd}'),
            control if control.is_control() => safe.push(' '),
            other => safe.push(other),
        }
    }
    safe
}

/// A range of numbers along an edge of the plot area.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Scale {
    /// Spans the finite numbers, a little room added on both sides; an empty or single range becomes one of width one.
    pub fn spanning(numbers: impl Iterator<Item = f64>, room: f64, from: f64, to: f64) -> Self {
        let finite = numbers.filter(|number| number.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| {
            (low.min(number), high.max(number))
        });
        let (low, high) = match high - low {
            span if span > 0.0 && span.is_finite() => (low - room * span, high + room * span),
            _ if low == high => {
                let half = 0.5_f64.max(0.01 * low.abs());
                (low - half, low + half)
            }
            _ => (0.0, 1.0),
        };
        Self {
            low,
            high,
            from,
            to,
        }
    }

    /// Where a number stands on the page; what cannot be placed stands at the beginning.
    pub fn place(&self, number: f64) -> f64 {
        let share = (number - self.low) / (self.high - self.low);
        let place = self.from + share * (self.to - self.from);
        if place.is_finite() { place } else { self.from }
    }

    /// Round numbers within the range.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let step = round_step((self.high - self.low) / STEPS);
        let first = (self.low / step).ceil();
        (0..=2 * STEPS as usize)
            .map(|at| (first + at as f64) * step)
            .take_while(|tick| *tick <= self.high)
            .map(|tick| (tick, tick_text(tick, step)))
            .collect()
    }
}

/// A multiple of `step` with as many decimals as that needs.
fn tick_text(tick: f64, step: f64) -> String {
    if !(1e-6..1e7).contains(&step) {
        return significant(tick, 3);
    }
    let text = step.to_string();
    let decimals = text
        .split_once('.')
        .map_or(0, |(_, decimals)| decimals.len());
    // Rounded to the step, zero is zero and not a remainder of the last digit.
    let tick = if tick.abs() < step / 2.0 { 0.0 } else { tick };
    format!("{tick:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(
            escaped("a<b> & \"c\" 'd'\u{7}\u{ffff}N·m"),
            "a&lt;b&gt; &amp; &quot;c&quot; &apos;d&apos; \u{fffd}N·m"
        );
    }

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let texts = |numbers: &[f64]| -> Vec<String> {
            let scale = Scale::spanning(numbers.iter().copied(), 0.0, 0.0, 1.0);
            scale.ticks().into_iter().map(|(_, text)| text).collect()
        };
        assert_eq!(
            texts(&[0.0, 14.0]),
            ["0.0", "2.5", "5.0", "7.5", "10.0", "12.5"]
        );
        assert_eq!(texts(&[-0.1, 0.1, f64::NAN]).len(), 5);
        assert!(texts(&[-0.1, 0.1]).contains(&"0.00".to_owned()));
        assert_eq!(texts(&[]).first().unwrap(), "0.0");
        assert!(texts(&[3.0, 3.0]).contains(&"3.0".to_owned()));
        assert!(texts(&[1e300, -1e300]).len() > 2);
    }
}
