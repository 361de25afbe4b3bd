//! Cross-plots: one channel (time, gauge or load) plotted against another.

use crate::{
    progress::Progress,
    questions::{
        loops::{
            frame::frame_around,
            picture::{Drawn, drawn},
            request::{Channel, CrossQuestion, LookError, column_of},
            source::{Part, Source},
        },
        metrology::check_numbers,
    },
    report::Trace,
    scoring::loops::Frame,
};

/// A cross-plot, ready to be drawn.
#[derive(Debug)]
pub struct CrossPlot {
    /// Request that the plot answers.
    pub question: CrossQuestion,
    /// Number of plotted samples.
    pub n_samples: usize,
    /// Visible range that shows all points.
    pub whole: Frame,
    /// Curves, one or more for each recording.
    pub drawn: Drawn,
}

pub fn picture(
    source: &Source,
    parts: &[Part],
    question: &CrossQuestion,
    progress: &Progress,
) -> Result<CrossPlot, LookError> {
    let across = columns(source, parts, question.across)?;
    let up = columns(source, parts, question.up)?;
    let whole = frame_around(across.iter().flatten().collect(), up.iter().flatten().collect());
    let none = vec![Vec::new(); parts.len()];
    let canvas = (question.frame.unwrap_or(whole), question.pixels);
    Ok(CrossPlot {
        question: question.clone(),
        n_samples: across.iter().map(Vec::len).sum(),
        drawn: drawn(&across, &up, &none, canvas, progress)?,
        whole,
    })
}

fn columns(source: &Source, parts: &[Part], channel: Channel) -> Result<Vec<Vec<f64>>, LookError> {
    let column = |part: &Part| -> Result<Vec<f64>, LookError> {
        let recording = &source.recordings()[part.recording];
        let found = match channel {
            Channel::Time => Some(recording.times()[part.samples.clone()].to_vec()),
            Channel::Gauge(gauge) => source.gauge(part, gauge),
            Channel::Load(Trace::Calculated, axis) => source.loads(part, axis),
            Channel::Load(Trace::Factory, _) => None,
            Channel::Load(output, axis) => {
                let (at, _) = column_of(source.calibration(), axis)?;
                Some(source.output(part, at, output))
            }
        };
        let values = found.ok_or(LookError::NoChannel)?;
        if let Channel::Load(_, axis) = channel {
            check_numbers(axis, recording.name(), &values)?;
        }
        Ok(values)
    };
    parts.iter().map(column).collect()
}
