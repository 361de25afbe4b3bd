//! Metrology rows that distinguish a time lag from hysteresis.

use crate::questions::metrology::figures::{Figure, Value};
use crate::questions::metrology::measured::{AxisView, Lags};
use crate::questions::metrology::quantity::Quantity;
use crate::questions::metrology::reason::Reason;
use crate::scoring::lag::{WORTH_REMOVING, widths};

type Rows = [(Quantity, Figure); 2];

/// Returns two rows of one output (uncompensated or compensated load): its time lag, and its hysteresis without the lag. Also
/// returns the share of the loop's mean width that the lag explains. `place` is the position of the axis.
pub(crate) fn lag_figures(
    view: &AxisView<'_>,
    lags: &Lags,
    place: usize,
    output: usize,
) -> (Rows, Option<f64>) {
    let axis = view.axis;
    let rows = |lag, without| [(Quantity::TimeLag, lag), (Quantity::HysteresisWithoutLag, without)];
    let lag = match &lags[output][place] {
        Ok(lag) => lag,
        Err(reason) => {
            let none = Err(Reason::NoLag { axis, reason: *reason });
            return (rows(none.clone(), none), None);
        }
    };
    let found = Ok(Value::everywhere(lag.seconds));
    if !lag.is_significant() {
        return (rows(found, Err(Reason::LagExplainsLittle { axis, share: 0.0 })), Some(0.0));
    }
    let runs = view.measured.lag_runs(output);
    let Some(widths) = widths(lag, place, &runs, view.reversal_threshold) else {
        return (rows(found, Err(Reason::NoCycle { axis })), None);
    };
    let share = widths.explained_share();
    let without = match share > WORTH_REMOVING {
        true if widths.is_uncertain(view.full_scale) => {
            Err(Reason::LagTooUncertain { axis, uncertainty: widths.uncertainty })
        }
        true => Ok(Value::everywhere(widths.largest[1])),
        false => Err(Reason::LagExplainsLittle { axis, share }),
    };
    (rows(found, without), Some(share))
}
