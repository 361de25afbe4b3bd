//! Follows a growing file that a logger writes, and computes the loads of its newest minute by the present calibration.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::{
    calibration::{Calibration, Estimator, measured_pauses},
    import::live::{GrowingFile, Grown, LiveHead, LiveRow, LiveSource, LiveTable, Places},
    panicked::locked,
    progress::Progress,
    questions::{
        question::{Query, Unanswered, Work},
        training,
    },
    recording::{Axis, RecordingSet},
    same::same_where,
    scoring::series::Series,
};

const SHOWN_SECS: f64 = 60.0;
const PERIOD: Duration = Duration::from_millis(100);
const COLUMNS: f64 = 1000.0;
/// Maximum number of kept samples, even if the newest minute has more at a high sample rate.
const MAX_SAMPLES: usize = 1 << 20;

/// Calibration that computes the loads of the followed file, and the recordings to which it was fitted; `None` for an opened
/// calibration. It changes with each new fit, such as during the drag of a slider.
pub type CurrentFit = (Arc<Calibration>, Option<Arc<RecordingSet>>);
pub type Current = Arc<Mutex<Option<CurrentFit>>>;

#[derive(Clone, Debug)]
pub struct Follow {
    pub path: PathBuf,
    pub calibration: Current,
}

same_where!(Follow: shared(calibration) value(path) besides());

/// Loads of the newest minute of the followed file.
#[derive(Clone, Debug, Default)]
pub struct Followed {
    pub axes: Vec<(Axis, LiveTraces)>,
    /// Times of the first and last sample of the newest minute, on the clock of the file (s).
    pub span: (f64, f64),
    /// Number of samples read so far, and number of lines that are not samples.
    pub counts: (u64, u64),
    /// Status flags of the newest sample, in words.
    pub status: String,
    pub notes: Vec<String>,
}

/// Traces of one axis in the newest minute, as pairs of time (s) and load. A rejected sample has no pair.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LiveTraces {
    pub conventional: Vec<[f64; 2]>,
    pub compensated: Vec<[f64; 2]>,
    /// Reference load; empty if the file has no reference for this axis.
    pub reference: Vec<[f64; 2]>,
    /// Root mean square errors of the uncompensated and of the compensated load; `None` without a reference load.
    pub rms_errors: Option<[f64; 2]>,
}

impl Query for Follow {
    type Answer = Followed;
    type Cache = ();
    // The default interval of one second between partial results is too long for a moving plot.
    const PARTS_INTERVAL: Duration = Duration::from_millis(90);

    fn title(&self) -> String {
        "Following".to_owned()
    }

    fn compute(&self, Work { progress, show, .. }: Work<'_, Self>) -> Result<Followed, Unanswered> {
        let unreadable = |error| Unanswered::Because(format!("{}: {error}", self.path.display()));
        let mut file = GrowingFile::open(&self.path).map_err(unreadable)?;
        let mut minute = Minute::default();
        loop {
            let current = self.current();
            let mut calibration = current.as_ref().map(|(calibration, _)| Arc::clone(calibration));
            if let Some((fitted, Some(recordings))) = &current
                && minute.has_pause(fitted, usize::MAX)
            {
                let keep_secs = measured_pauses(fitted, training(recordings), progress)?;
                calibration = Some(Arc::new(Calibration { keep_secs, ..(**fitted).clone() }));
            }
            minute.run(calibration.as_ref(), current.as_ref(), &mut file, progress, show, self)?;
        }
    }
}

impl Follow {
    fn current(&self) -> Option<CurrentFit> {
        locked(&self.calibration).clone()
    }

    fn is_current(&self, fit: Option<&CurrentFit>) -> bool {
        let place = |fit: &CurrentFit| Arc::as_ptr(&fit.0);
        self.current().as_ref().map(place) == fit.map(place)
    }
}

/// Samples of the newest minute, and the earlier samples to which the calibration looks back.
#[derive(Default)]
struct Minute {
    head: LiveHead,
    table: Option<LiveTable>,
    rows: VecDeque<LiveRow>,
    kept_secs: f64,
    counts: (u64, u64),
    notes: Vec<String>,
    /// Reason why the file cannot be used. The reason remains until another file replaces the file.
    refused: Option<String>,
    /// Sample interval of the calibration (s) from which the unit of the times in the file was guessed.
    step_secs: Option<f64>,
    /// Names of the gauges of the calibration, and of the auxiliary channels that it needs.
    channels: [Vec<String>; 2],
    changed: bool,
}

struct Taken {
    time: f64,
    loads: [Vec<f64>; 3],
}

/// Passes a sample to the estimator, and returns the status of the sample and its loads.
fn taken_of(
    calibration: &Calibration,
    estimator: &mut Estimator<'_>,
    table: &LiveTable,
    places: &Places,
    row: &LiveRow,
) -> (String, Taken) {
    let (gauges, auxiliary) = (places.gauges(row), places.auxiliary(row));
    let is_held = places.is_held(row, calibration.gap_secs);
    let (status, compensated) = estimator.update_or_nan(row.time, &gauges, &auxiliary, is_held);
    let reference = calibration.axes.iter().map(|axis| {
        let place = table.axes().iter().position(|known| known == axis);
        place.map_or(f64::NAN, |place| row.loads[place])
    });
    let loads = [estimator.conventional().to_vec(), compensated, reference.collect()];
    (status.to_string(), Taken { time: row.time, loads })
}

impl Minute {
    /// Returns true if a time step between these newest rows is a pause for this calibration.
    fn has_pause(&self, calibration: &Calibration, newest: usize) -> bool {
        let newest = self.rows.len() - newest.min(self.rows.len())..;
        let times = || self.rows.range(newest.clone()).map(|row| row.time);
        times().zip(times().skip(1)).any(|(time, next)| next - time > calibration.gap_secs)
    }

    /// Forgets all samples of the file.
    fn restart(&mut self, notes: Vec<String>) {
        *self = Self {
            kept_secs: self.kept_secs,
            counts: self.counts,
            notes,
            step_secs: self.step_secs,
            channels: std::mem::take(&mut self.channels),
            ..Self::default()
        };
    }

    /// Reads the next line of the file, if there is one. Returns the number of new samples; `None` if the file was replaced.
    fn read(&mut self, file: &mut GrowingFile, path: &Path) -> Result<Option<usize>, Unanswered> {
        let grown = file.look().map_err(|error| Unanswered::Because(error.to_string()))?;
        let line = match grown {
            Grown::Line(line) => line,
            Grown::Nothing => return Ok(Some(0)),
            Grown::Replaced => {
                let note =
                    "the file was replaced or shortened, so reading started again at its beginning";
                self.restart(vec![note.to_owned()]);
                return Ok(None);
            }
        };
        self.changed = true;
        let [gauges, auxiliary] = self.channels.clone();
        let source = LiveSource {
            path,
            map: None,
            step_secs: self.step_secs,
            gauges: &gauges,
            auxiliary: &auxiliary,
            form: None,
            header: None,
            time_unit: None,
            rate_hz: None,
        };
        let Some(rows) = self.take(line, source) else {
            return Ok(None);
        };
        self.counts.0 += rows.len() as u64;
        let n = rows.len();
        self.rows.extend(rows);
        let newest_secs = self.rows.back().map_or(0.0, |row| row.time);
        let is_old = |row: &LiveRow| newest_secs - row.time > self.kept_secs;
        while self.rows.len() > MAX_SAMPLES || self.rows.front().is_some_and(is_old) {
            self.rows.pop_front();
        }
        Ok(Some(n.min(self.rows.len())))
    }

    /// Returns the rows that a line completes; `None` if it is the header of other columns. The first lines of the file are
    /// collected until the columns are known.
    fn take(&mut self, line: String, source: LiveSource<'_>) -> Option<Vec<LiveRow>> {
        if let Some(table) = &mut self.table {
            let row = table.row(&line);
            match row.is_err().then(|| table.new_header(&line, source)).flatten() {
                Some(names) if !names.is_empty() => {
                    let columns = format!("a header with other columns: {}", names.join(", "));
                    self.restart(vec![columns]);
                    self.refused =
                        self.head.push(line, source).err().map(|error| error.to_string());
                    return None;
                }
                header => self.counts.1 += u64::from(row.is_err() && header.is_none()),
            }
            return Some(Vec::from_iter(row));
        }
        if self.refused.is_some() {
            return Some(Vec::new());
        }
        let mut table = match self.head.push(line, source) {
            Ok(Some(table)) => table,
            Ok(None) => return Some(Vec::new()),
            Err(error) => {
                self.refused = Some(error.to_string());
                return Some(Vec::new());
            }
        };
        let unit = table.assumed_unit();
        self.notes.extend(unit.map(|unit| format!("the times have no unit; {unit} is assumed")));
        self.notes.extend(table.device());
        let kept = std::mem::take(&mut self.head).into_kept();
        let rows: Vec<_> = kept.map(|kept| table.row_at(&kept.line, kept.secs)).collect();
        self.counts.1 += rows.iter().filter(|row| row.is_err()).count() as u64;
        self.table = Some(table);
        Some(rows.into_iter().flatten().collect())
    }

    /// Computes the loads of existing and new samples until the fit changes, the file is replaced, or the first pause comes, after
    /// which the pauses are measured through which the fit keeps its states. Without a calibration, only the number of samples
    /// is shown.
    fn run(
        &mut self,
        calibration: Option<&Arc<Calibration>>,
        fit: Option<&CurrentFit>,
        file: &mut GrowingFile,
        progress: &Progress,
        show: &(dyn Fn(Followed) + Sync),
        of: &Follow,
    ) -> Result<(), Unanswered> {
        let because = |error: &dyn ToString| Unanswered::Because(error.to_string());
        let design = calibration.map(|calibration| calibration.design());
        let (mut estimator, mut status) = (None, "no calibration yet".to_owned());
        self.kept_secs = SHOWN_SECS;
        if let Some((calibration, design)) = calibration.zip(design.as_ref()) {
            estimator = Some(Estimator::new(calibration, design).map_err(|error| because(&error))?);
            "no row yet".clone_into(&mut status);
            self.kept_secs += calibration.features.window_secs().min(10.0 * SHOWN_SECS);
            let channels = [calibration.gauges.clone(), calibration.features.auxiliary_names()];
            if self.step_secs != calibration.step_secs() || self.channels != channels {
                self.step_secs = calibration.step_secs();
                self.channels = channels;
                // The unit of the times was guessed from the sample interval of another calibration, so the file is read
                // again.
                *file = GrowingFile::open(&of.path).map_err(|error| because(&error))?;
                self.restart(Vec::new());
                self.counts = (0, 0);
            }
        }
        let mut taken: VecDeque<Taken> = VecDeque::new();
        let mut places: Option<Result<Places, String>> = None;
        let mut waiting = self.rows.len();
        let had_pause =
            fit.is_none_or(|(fitted, to)| to.is_none() || self.has_pause(fitted, usize::MAX));
        let mut shown: Option<Instant> = None;
        self.changed = true;
        loop {
            progress.check()?;
            if let (Some(table), Some((calibration, estimator))) =
                (&self.table, calibration.zip(estimator.as_mut()))
            {
                let [gauges, auxiliary] = &self.channels;
                let places = places.get_or_insert_with(|| {
                    let unfit =
                        |why| format!("{why}; the file is not used until another one replaces it");
                    table.places(gauges, auxiliary).map_err(unfit)
                });
                if places.is_err() {
                    "not used".clone_into(&mut status);
                }
                if let Ok(places) = places {
                    let new = self.rows.len() - waiting..self.rows.len();
                    for row in self.rows.range(new) {
                        let sample;
                        (status, sample) = taken_of(calibration, estimator, table, places, row);
                        taken.push_back(sample);
                    }
                }
                waiting = 0;
                let newest_secs = taken.back().map_or(0.0, |taken| taken.time);
                let is_old = |taken: &Taken| (newest_secs - taken.time).abs() > SHOWN_SECS;
                while taken.len() > MAX_SAMPLES || taken.front().is_some_and(is_old) {
                    taken.pop_front();
                }
            }
            if self.changed && shown.is_none_or(|shown| shown.elapsed() >= PERIOD) {
                self.changed = false;
                shown = Some(Instant::now());
                show(self.followed(calibration, &taken, &status, places.as_ref()));
            }
            if !of.is_current(fit) {
                return Ok(());
            }
            match self.read(file, &of.path)? {
                Some(n) => {
                    waiting += n;
                    if !had_pause && fit.is_some_and(|(fitted, _)| self.has_pause(fitted, n + 1)) {
                        return Ok(());
                    }
                }
                None => return Ok(()),
            }
        }
    }

    fn followed(
        &self,
        calibration: Option<&Arc<Calibration>>,
        taken: &VecDeque<Taken>,
        status: &str,
        places: Option<&Result<Places, String>>,
    ) -> Followed {
        let times: Vec<f64> = taken.iter().map(|taken| taken.time).collect();
        // If the clock of the file was reset, only the samples since the reset are shown.
        let back = (1..times.len()).rev().find(|at| times[*at] < times[at - 1]);
        let shown = back.unwrap_or(0)..times.len();
        let times = &times[shown.clone()];
        let span = times.first().copied().zip(times.last().copied()).unwrap_or_default();
        let column_secs = (span.1 - span.0) / COLUMNS;
        let axes = calibration.map_or(&[][..], |calibration| &calibration.axes).iter().enumerate();
        let axes = axes.map(|(at, axis)| {
            let [conventional, compensated, reference] = [0, 1, 2].map(|kind| {
                let values = taken.range(shown.clone()).map(|taken| taken.loads[kind][at]);
                Series::new(values.collect())
            });
            let points = |series: &Series| {
                let mut points = Vec::new();
                let all = 0..series.len();
                series.draw(times, all, column_secs, |time, load| points.push([time, load]));
                points
            };
            let traces = LiveTraces {
                rms_errors: rms_errors([&conventional, &compensated], &reference),
                conventional: points(&conventional),
                compensated: points(&compensated),
                reference: points(&reference),
            };
            (*axis, traces)
        });
        let unfit = places.and_then(|places| places.as_ref().err());
        let notes = self.notes.iter().chain(&self.refused).chain(unfit);
        Followed {
            axes: axes.collect(),
            span,
            counts: self.counts,
            status: status.to_owned(),
            notes: notes.cloned().collect(),
        }
    }
}

fn rms_errors(loads: [&Series; 2], reference: &Series) -> Option<[f64; 2]> {
    let mut n = 0;
    let mut squares = [0.0; 2];
    for k in 0..reference.len() {
        let errors = loads.map(|loads| loads.value(k) - reference.value(k));
        if errors.iter().all(|error| error.is_finite()) {
            n += 1;
            squares = [0, 1].map(|i| squares[i] + errors[i] * errors[i]);
        }
    }
    (n > 0).then(|| squares.map(|sum: f64| (sum / f64::from(n)).sqrt()))
}

#[cfg(test)]
mod tests {
    use std::fs::{self, OpenOptions};
    use std::io::Write as _;
    use std::sync::mpsc::channel;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::formats::csv::write_csv;
    use crate::questions::{Request, train};
    use crate::recording::{Entry, Recording, RecordingSet, Role, simulated};

    /// Follows a file. `check` gets a function that waits until a condition on the shown minute holds.
    fn following(
        path: &Path,
        calibration: &Arc<Calibration>,
        check: impl FnOnce(&Follow, &dyn Fn(&dyn Fn(&Followed) -> bool) -> Followed),
    ) {
        let follow = Follow {
            path: path.to_owned(),
            calibration: Arc::new(Mutex::new(Some((Arc::clone(calibration), None)))),
        };
        let progress = Progress::default();
        let (sender, receiver) = channel();
        // The file is not followed for ever, even if an assertion fails.
        struct Ends<'a>(&'a Progress);
        impl Drop for Ends<'_> {
            fn drop(&mut self) {
                self.0.cancel();
            }
        }
        std::thread::scope(|scope| {
            let _ends = Ends(&progress);
            scope.spawn(|| {
                let sender = Mutex::new(sender);
                let show = |followed| {
                    let _ = sender.lock().unwrap().send(followed);
                };
                let work = Work { cache: &mut (), progress: &progress, show: &show };
                let end = follow.compute(work).unwrap_err();
                assert_eq!(end, Unanswered::Cancelled);
            });
            check(&follow, &|until| receiver.iter().find(|followed| until(followed)).unwrap());
        });
    }

    fn fitted(recording: &Recording, f_th: f64) -> Arc<Calibration> {
        let mut set = RecordingSet::default();
        set.push(Entry::new(recording.clone(), Role::Train)).unwrap();
        let mut settings = FitSettings::default();
        settings.features.look_backs[0].f_th = f_th;
        let request = Request::fit(Arc::new(set), settings);
        Arc::new(train(&request, &Progress::default(), &mut |_| {}).unwrap())
    }

    #[test]
    fn a_log_with_other_columns_is_noted_and_the_right_one_in_its_place_is_followed() {
        let recording = simulated::recordings(3).entries()[0].recording.decimated(2);
        let calibration = fitted(&recording, 2.0);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        fs::write(&path, "t [s],S1,S2\n0,1,2\n0.1,1,2\n").unwrap();
        let mut text = Vec::new();
        write_csv(&recording, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let (head, rows) = text.split_once('\n').unwrap();
        let milliseconds = |row: &str| {
            let (time, rest) = row.split_once(',').unwrap();
            let time = 1e3 * (time.parse::<f64>().unwrap() - recording.times()[0]);
            format!("{},{rest}\n", time.round())
        };
        let head = ["time", head.split_once(',').unwrap().1].join(",");
        let text =
            format!("\u{feff}{head}\n{}", rows.lines().map(milliseconds).collect::<String>());
        let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        following(&path, &calibration, |_, seen| {
            let other = seen(&|followed| followed.counts.0 == 2);
            assert!(other.notes[0].contains("the gauges S1 S2,"), "{:?}", other.notes);
            let new = folder.path().join("new.csv");
            fs::write(&new, utf16).unwrap();
            fs::rename(&new, &path).unwrap();
            let n = 2 + recording.n_samples() as u64;
            let right = seen(&|followed| followed.counts.0 == n);
            assert_eq!(right.status, "ok");
            let notes = right.notes.join("; ");
            assert!(notes.contains("; ms is assumed") && !notes.contains("the gauges"), "{notes}");
            assert!((right.span.1 - recording.duration_secs()).abs() < 2e-3);
        });
    }

    /// Rows without a header have the gauges in the order of the calibration, and the clock of this computer.
    #[test]
    fn a_log_of_numbers_as_a_device_prints_them_is_followed() {
        let recording = simulated::recordings(3).entries()[0].recording.decimated(2);
        let calibration = fitted(&recording, 2.0);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.txt");
        let row = |k: usize| {
            let gauges = recording.gauges_at(k).iter().map(f64::to_string);
            gauges.collect::<Vec<_>>().join(" ") + "\r\n"
        };
        fs::write(&path, (0..20).map(row).collect::<String>()).unwrap();
        following(&path, &calibration, |_, seen| {
            let followed = seen(&|followed| followed.counts == (20, 0));
            assert!(
                followed.notes.iter().any(|note| note.contains("clock")),
                "{:?}",
                followed.notes
            );
            let expected = calibration.apply(&recording).unwrap().conventional;
            for (at, (_, traces)) in followed.axes.iter().enumerate() {
                let first = traces.conventional[0][1];
                assert!((first - expected[at]).abs() < 1e-9, "{first} {}", expected[at]);
            }
        });
    }

    /// A growing file shows the loads of the calibration. Another calibration starts again with the existing rows.
    #[test]
    fn a_growing_file_is_shown_with_the_present_calibration() {
        let recording = simulated::recordings(3).entries()[0].recording.decimated(2);
        let (first, second) = (fitted(&recording, 2.0), fitted(&recording, 5.0));
        let mut text = Vec::new();
        write_csv(&recording, &mut text).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let half = text.len() / 2;
        fs::write(&path, &text[..half]).unwrap();
        following(&path, &first, |follow, seen| {
            seen(&|followed| followed.counts.0 > 10);
            let mut log = OpenOptions::new().append(true).open(&path).unwrap();
            log.write_all(&text[half..]).unwrap();
            let n = recording.n_samples() as u64;
            let newest = |calibration: &Calibration| {
                let applied = calibration.apply(&recording).unwrap().compensated;
                applied[applied.len() - 4]
            };
            let shows = |followed: &Followed, calibration: &Calibration| {
                let (axis, traces) = &followed.axes[2];
                assert_eq!(*axis, Axis::Fz);
                assert!(traces.rms_errors.is_some() && !traces.reference.is_empty());
                let last = traces.compensated.last().unwrap();
                last[0] == recording.times()[n as usize - 1]
                    && (last[1] - newest(calibration)).abs() < 1e-9
            };
            let whole = seen(&|followed| followed.counts.0 == n);
            assert!(shows(&whole, &first) && !shows(&whole, &second));
            *follow.calibration.lock().unwrap() = Some((Arc::clone(&second), None));
            seen(&|followed| shows(followed, &second));
        });
    }
}
