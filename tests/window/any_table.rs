//! Counts the presses that users need with typical files: from dropping a file on the window to a loop on screen, and to an
//! exported calibration matrix.

use std::fmt::Write as _;

use super::*;

/// Window in which each press is counted.
struct Counted {
    window: Window,
    files: Files,
    n: usize,
}

impl Counted {
    /// Returns an empty window on which this file was dropped.
    fn dropped(name: &str, text: &str) -> Self {
        let files = Files::new();
        let mut window = window(Vec::new());
        let path = files.write(name, text);
        window.input_mut().dropped_files.push(Arc::new(Dropped(path)));
        settle(&mut window);
        assert!(state(&window).importing.is_none(), "no question comes first");
        Self { window, files, n: 0 }
    }

    fn press(&mut self, label: &str) {
        self.n += 1;
        let found: Vec<_> = self.window.query_all_by_label(label).collect();
        let last = found.last().unwrap_or_else(|| panic!("no {label}"));
        last.click();
        settle(&mut self.window);
    }

    fn role(&mut self, channel: &str, steps: &[&str]) {
        let label = format!("Role of {channel}: ");
        self.n += 1;
        self.window.get_by_label_contains(&label).click();
        settle(&mut self.window);
        for step in steps {
            self.press(step);
        }
    }

    /// Opens the pane with the loops, and checks that a loop is on screen after at most this number of presses.
    #[track_caller]
    fn assert_loop(&mut self, most: usize, of: [&str; 2]) {
        self.press("Loops");
        let [up, across] = of;
        let title = format!("{up} against {across}");
        assert!(self.window.query_by_label(&title).is_some(), "no {title}");
        assert!(self.n <= most, "{} presses", self.n);
    }

    /// Exports the matrix, and checks the number of all presses until then.
    #[track_caller]
    fn assert_exported(&mut self, most: usize) {
        assert!(state(&self.window).analysis().is_some(), "{:?}", state(&self.window).problem());
        self.press("Export");
        let path = self.files.path("sensor.csv");
        type_into(&mut self.window, "Export to", path.to_str().unwrap());
        self.n += 1;
        settle(&mut self.window);
        self.press("Write 1 file");
        until(&mut self.window, |_| path.exists());
        assert!(self.n <= most, "{} presses", self.n);
    }
}

/// Load that rises and falls, and a reading that lags behind it.
fn cycles(n: usize) -> impl Iterator<Item = (usize, f64, f64)> {
    let load = |k: usize| 50.0 * (1.0 - (k as f64 * 0.05).cos());
    (0..n).map(move |k| (k, load(k), 0.02 * load(k.saturating_sub(2))))
}

#[test]
fn a_catman_export_opens_with_its_roles() {
    let mut text = "Time  1 - default sample rate [s]\tForce_ref [N]\tStrain_1 [mV/V]\n".to_owned();
    for (k, load, reading) in cycles(400) {
        writeln!(text, "{:.2}\t{load:.4}\t{reading:.6}", k as f64 / 50.0).unwrap();
    }
    let mut drop = Counted::dropped("catman.txt", &text);
    assert_eq!(state(&drop.window).project().missing(), None);
    drop.press("Loops");
    assert!(drop.n <= 4 && has(&drop.window, "Fz"));
    drop.assert_exported(10);
}

/// Beside a calibration, the pane of the channels crosses every channel of the file.
#[test]
fn a_channel_without_a_use_is_crossed_beside_a_calibration() {
    let mut text = "time [s],Force [N],Strain_1 [mV/V],Displacement [mm]\n".to_owned();
    for (k, load, reading) in cycles(400) {
        let t = k as f64 / 50.0;
        writeln!(text, "{t:.2},{load:.4},{reading:.6},{:.4}", 0.1 * load).unwrap();
    }
    let mut drop = Counted::dropped("pull.csv", &text);
    assert_eq!(state(&drop.window).project().missing(), None);
    show(&mut drop.window, "channels");
    click(&mut drop.window, Role::ComboBox, "across");
    // The list of the choice comes before the list of the channels.
    let item = drop.window.get_all_by_role_and_label(Role::Button, "Fz [N]").next();
    item.expect("the list is open").click();
    settle(&mut drop.window);
    drop.window.get_by_role_and_label(Role::Button, "Displacement [mm]").click();
    settle(&mut drop.window);
    assert!(has(&drop.window, "Displacement [mm] against Fz [N]"));
}

#[test]
fn weights_in_a_spreadsheet_show_their_branches() {
    let mut text = "Mass_kg,Reading\n".to_owned();
    for (step, mass) in [0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0].into_iter().enumerate() {
        let back = if step > 5 { 3.0 } else { 0.0 };
        writeln!(text, "{mass},{}", 100.0 * f64::from(mass) + back).unwrap();
    }
    let mut drop = Counted::dropped("weights.csv", &text);
    let recordings = &state(&drop.window).project().recordings;
    if recordings.layout().gauge_names.is_empty() {
        drop.role("Reading", &["Gauge"]);
    }
    if state(&drop.window).project().missing() == Some(Missing::Load) {
        drop.role("Mass_kg", &["Fz", "kgf"]);
    }
    let (n, mut others) = (drop.n, drop);
    others.n = 0;
    others.assert_loop(4, ["Reading", "Fz [N]"]);
    others.n += n;
    others.assert_exported(10);
}

#[test]
fn a_log_of_loads_alone_shows_traces_loops_and_what_is_missing() {
    let mut text = "time [s],Force [N],Displacement [mm]\n".to_owned();
    for (k, load, reading) in cycles(400) {
        writeln!(text, "{:.2},{load:.4},{reading:.6}", k as f64 / 50.0).unwrap();
    }
    let mut drop = Counted::dropped("pull.csv", &text);
    let missing = state(&drop.window).project().missing();
    assert!(missing.is_some());
    assert!(has(&drop.window, &missing.unwrap().to_string()));
    drop.press("Loops");
    assert!(has(&drop.window, " against "), "a loop of the channels is drawn");
    assert!(has(&drop.window, "Loop width"));
    assert!(drop.n <= 4);
}

#[test]
fn roles_of_a_file_without_a_header_are_chosen_on_what_one_sees() {
    let mut text = String::new();
    for (k, load, reading) in cycles(600) {
        let t = k as f64 / 100.0;
        writeln!(
            text,
            "{};{:.3};{};{reading:.6};{:.6};{load:.4}",
            1_700_000_000.0 + t,
            t,
            10 * k,
            0.5 * (t * 3.0).sin()
        )
        .unwrap();
    }
    let mut drop = Counted::dropped("clocks.dat", &text);
    let before = state(&drop.window).project().maps.clone();
    let load = state(&drop.window).project().recordings.entries()[0].recording.clone();
    let name = recording::Channel::all(&load)
        .find(|channel| {
            *channel != recording::Channel::Time
                && channel.values(&load)[100] == text_value(&text, 100)
        })
        .unwrap();
    let name = name.name(&load).to_owned();
    drop.role(&name, &["Fx", "N"]);
    assert_eq!(state(&drop.window).project().axes(), [Axis::Fx]);
    assert!(train_rmse(&drop.window)[0][0].is_finite());
    drop.press("Loops");
    assert!(drop.n <= 4 && has(&drop.window, "Fx"), "{} presses", drop.n);
    drop.assert_exported(10);
    let shell = drop.window.state_mut().as_mut().unwrap();
    shell.send(Action::Undo);
    settle(&mut drop.window);
    assert_eq!(state(&drop.window).project().axes(), []);
    assert_eq!(state(&drop.window).project().maps, before);
    let shell = drop.window.state_mut().as_mut().unwrap();
    shell.send(Action::Redo);
    settle(&mut drop.window);
    assert_eq!(state(&drop.window).project().axes(), [Axis::Fx]);
}

/// Returns the last number in this line.
fn text_value(text: &str, line: usize) -> f64 {
    text.lines().nth(line).unwrap().rsplit(';').next().unwrap().parse().unwrap()
}
