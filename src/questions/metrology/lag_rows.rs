//! Metrology rows that distinguish a time lag from hysteresis.

use crate::questions::metrology::figures::{Found, Result};
use crate::questions::metrology::measured::AxisView;
use crate::questions::metrology::reason::Reason;
use crate::scoring::lag::{LagRun, WORTH_REMOVING, widths};

/// Returns the lag of one output on one axis, its hysteresis without the lag, and the lag's share of the mean width.
pub(crate) fn figures(
    view: &AxisView<'_>,
    place: usize,
    output: usize,
) -> ([Result<Found>; 2], Option<f64>) {
    let axis = view.axis;
    let lag = match &view.measured.lags()[output][place] {
        Ok(lag) => lag,
        Err(reason) => {
            let none = Err(Reason::NoLag { axis, reason: *reason });
            return ([none.clone(), none], None);
        }
    };
    let found = Ok(Found::everywhere(lag.seconds));
    if !lag.is_significant() {
        return ([found, Err(Reason::LagExplainsLittle { axis, share: 0.0 })], Some(0.0));
    }
    let own: Vec<LagRun<'_>> = view.measured.lag_runs(output).collect();
    let Some(widths) = widths(lag, place, &own, view.reversal_threshold) else {
        return ([found, Err(Reason::NoCycle { axis })], None);
    };
    let share = widths.explained_share();
    let without = match share > WORTH_REMOVING {
        true if widths.is_uncertain(view.full_scale) => {
            Err(Reason::LagTooUncertain { axis, uncertainty: widths.uncertainty })
        }
        true => Ok(Found::everywhere(widths.largest[1])),
        false => Err(Reason::LagExplainsLittle { axis, share }),
    };
    ([found, without], Some(share))
}
