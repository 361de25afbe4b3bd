//! Computes the plot and the figures of one channel.

use std::sync::Arc;

use crate::{
    min_max::MinMax,
    progress::Progress,
    questions::{
        channels::{
            figures::{ChannelFigures, Signal},
            spectrum::Spectrum,
        },
        loops::{Strokes, drawn, frame_around},
        question::{Answered, Query, Unanswered, Work},
    },
    recording::{Channel, Recording, RecordingSet},
    same::same_where,
    scoring::{
        loops::{Frame, Loop, Loops, default_reversal_threshold},
        straight_lines::Line,
    },
};

/// Maximum reversal threshold, as a share of the range of the horizontal channel. The noise of a table with few rows is not
/// known.
const LARGEST_SHARE: f64 = 0.25;

/// Request for the plot and the figures of one channel of a recording.
#[derive(Clone, Debug)]
pub struct ChannelQuestion {
    pub recordings: Arc<RecordingSet>,
    /// Index of the recording. Of a load case, all load cases of its table are plotted.
    pub at: usize,
    /// Channel on the horizontal axis.
    pub across: Channel,
    /// Channel on the vertical axis, whose figures are computed.
    pub up: Channel,
    /// Visible range of the plot after zooming; `None` shows all points. Over time, the figures are those of the visible
    /// samples.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

same_where!(ChannelQuestion: shared(recordings) value(at, across, up, frame, pixels) besides());

/// Plot and figures of one channel.
#[derive(Debug)]
pub struct ChannelPlot {
    /// Labels of the horizontal and the vertical axis.
    pub labels: [String; 2],
    /// Unit of the channel, and that of its horizontal axis in a rate.
    pub(super) units: [String; 2],
    /// Visible range that shows all points.
    pub whole: Frame,
    pub(super) drawn: Strokes,
    /// Noise and drift; `None` without a value.
    pub(super) figures: Option<ChannelFigures>,
    /// Spectrum; `None` if there are too few samples.
    pub(super) spectrum: Option<Spectrum>,
    /// Loop of the cycle with the widest range; of cycles with equal ranges, the widest loop. `None` over time, and if the
    /// horizontal channel never turns back.
    pub(super) widest_loop: Option<Loop>,
    /// Unit of the horizontal channel.
    pub(super) unit_across: String,
    /// Slope of the least-squares line over the horizontal channel, and the correlation; `None` over time.
    pub(super) trend: Option<[f64; 2]>,
    /// True if the samples are rows of a table with loads.
    pub(super) is_table_of_loads: bool,
}

impl ChannelQuestion {
    /// Returns the recording to be plotted, with the rows in the order of the file. The recording must exist.
    fn recording(&self) -> Arc<Recording> {
        let asked = &self.recordings.entries()[self.at].recording;
        if !asked.is_load_case() {
            return Arc::clone(asked);
        }
        let all = self.recordings.entries().iter().map(|entry| &*entry.recording);
        let of_table = all.filter(|case| case.is_load_case() && case.source() == asked.source());
        Arc::new(Recording::in_file_order(&of_table.collect::<Vec<_>>()))
    }

    pub fn plot(&self, progress: &Progress) -> Result<ChannelPlot, Unanswered> {
        let recording = self.recording();
        if ![self.across, self.up].iter().all(|channel| channel.is_in(&recording)) {
            return Err(Unanswered::Because("the recording does not have this channel".to_owned()));
        }
        let [across, up] = [self.across, self.up].map(|channel| channel.values(&recording));
        progress.check()?;
        let is_over_time = self.across == Channel::Time;
        let mut widest_loop = None;
        let mut branches = vec![Vec::new()];
        if !is_over_time && across.iter().all(|value| value.is_finite()) {
            let range: MinMax = across.iter().collect();
            let threshold = default_reversal_threshold([&across[..]]);
            let loops = Loops::of([&across[..]], threshold.min(LARGEST_SHARE * range.span()));
            progress.check()?;
            let all = loops.largest_cycles();
            let shapes = all.iter().map(|cycle| Loop::of(cycle, &across, |k| up[k]));
            widest_loop = shapes.max_by(|a, b| a.largest_width().total_cmp(&b.largest_width()));
            branches = loops.branches().to_vec();
        }
        let points: Vec<(f64, f64)> = (across.iter().copied().zip(up.iter().copied()))
            .filter(|(across, up)| across.is_finite() && up.is_finite())
            .collect();
        let line = Line::best_fit(&points).filter(|_| !is_over_time);
        let finite = |values: &[f64]| values.iter().filter(|value| value.is_finite()).collect();
        let whole = frame_around(finite(&across), finite(&up));
        let canvas = (self.frame.unwrap_or(whole), self.pixels);
        let drawn = drawn(&[across], std::slice::from_ref(&up), &branches, canvas, progress)?;
        let times = recording.times();
        let visible = match self.frame.filter(|_| is_over_time) {
            Some(Frame { loads: (from, to), .. }) => {
                let start = times.partition_point(|time| *time < from);
                start..times.partition_point(|time| *time <= to).max(start)
            }
            None => 0..up.len(),
        };
        let loads: Vec<Vec<f64>> = (0..recording.axes().len())
            .map(|at| Channel::Load(at).values(&recording)[visible.clone()].to_vec())
            .collect();
        progress.check()?;
        let signal =
            Signal { times: &times[visible.clone()], values: &up[visible.clone()], loads: &loads };
        let rate_hz = if recording.is_static() { Some(1.0) } else { recording.rate_hz() };
        let spectrum = match rate_hz {
            Some(rate_hz) => Spectrum::of(signal.values, rate_hz, progress)?,
            None => None,
        };
        Ok(ChannelPlot {
            labels: [self.across, self.up].map(|channel| channel.label(&recording)),
            units: [
                self.up.unit(&recording).to_owned(),
                if recording.is_static() { "row" } else { "s" }.to_owned(),
            ],
            figures: ChannelFigures::of(signal),
            whole,
            drawn,
            spectrum,
            widest_loop,
            unit_across: self.across.unit(&recording).to_owned(),
            trend: line.map(|line| [line.slope, line.correlation(&points)]),
            is_table_of_loads: recording.is_table() && recording.has_reference(),
        })
    }
}

impl Query for ChannelQuestion {
    type Answer = Arc<ChannelPlot>;
    type Cache = ();

    fn title(&self) -> String {
        "Drawing a channel".to_owned()
    }

    fn is_akin(&self, other: &Self) -> bool {
        let shown = |asked: &Self| (asked.at, asked.across, asked.up);
        Arc::ptr_eq(&self.recordings, &other.recordings) && shown(self) == shown(other)
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        Ok(Arc::new(self.plot(work.progress)?))
    }
}
