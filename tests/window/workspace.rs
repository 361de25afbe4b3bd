//! Tests of panes, undo, keys, cursors and playing.

use super::*;
use loopscope::engine::{Preferences, Theme};
use loopscope::ui::{Pane, Workspace};

fn ctrl(window: &mut Window, key: Key) {
    window.key_press_modifiers(Modifiers::COMMAND, key);
    settle(window);
}

pub fn named(key: &str) -> Pane {
    loopscope::ui::pane(key).expect("the pane exists")
}

fn on_screen(window: &Window, pane: Pane) -> bool {
    shell(window).on_screen().contains(&pane)
}

/// Advances the window's clock.
fn wait(window: &mut Window, frames: usize) {
    window.run_steps(frames);
    settle(window);
}

fn f_th(window: &Window) -> f64 {
    state(window).project().settings.features.look_backs[0].f_th
}

#[test]
fn a_pane_is_brought_and_maximised_and_drawers_open_and_close() {
    let files = Files::new();
    let mut window = window(files.three());
    assert!(on_screen(&window, named("traces")) && !on_screen(&window, named("loops")));
    show(&mut window, "loops");
    assert!(on_screen(&window, named("loops")) && !on_screen(&window, named("errors")));
    show(&mut window, "channels");
    assert!(on_screen(&window, named("channels")) && !on_screen(&window, named("traces")));
    show(&mut window, "traces");
    assert!(on_screen(&window, named("traces")) && !on_screen(&window, named("channels")));
    window.key_press(Key::F3);
    settle(&mut window);
    let traces = window.get_by_role_and_label(Role::GraphicsObject, "Fx [N]").rect().center();
    window.hover_at(traces);
    window.step();
    for n_shown in [1, 3] {
        window.key_press(Key::F9);
        settle(&mut window);
        assert_eq!(shell(&window).on_screen().len(), n_shown);
        assert!(on_screen(&window, named("traces")));
    }
    for (key, drawer) in [(Key::B, "recordings"), (Key::Comma, "settings")] {
        ctrl(&mut window, key);
        assert!(on_screen(&window, named(drawer)) && on_screen(&window, named("traces")));
    }
    window.key_press(Key::Escape);
    settle(&mut window);
    assert!(!on_screen(&window, named("settings")) && !on_screen(&window, named("recordings")));
}

#[test]
fn workspaces_are_opened_by_click_and_key() {
    let files = Files::new();
    let mut window = window(files.three());
    window.key_press(Key::F4);
    settle(&mut window);
    assert!(on_screen(&window, named("loops")) && on_screen(&window, named("metrology")));
    click(&mut window, Role::Button, Workspace::ALL[3].1);
    window.check_accessibility();
    for pane in [named("pairs"), named("traces"), named("thresholds")] {
        assert!(on_screen(&window, pane), "{pane:?}");
    }
}

/// Rectangles of all controls, by role and label.
fn places(window: &Window) -> Vec<(Role, String, egui::Rect)> {
    let roles = [Role::Button, Role::CheckBox, Role::ComboBox, Role::Slider, Role::RadioButton];
    let of_role = |role: Role| {
        let nodes = window.query_all_by(move |node| node.role() == role);
        nodes
            .map(move |node| (role, node.accesskit_node().label().unwrap_or_default(), node.rect()))
    };
    roles.into_iter().flat_map(of_role).collect()
}

/// Texts that are shortened, or that reach beyond the sides of their place.
fn cut_texts(window: &Window) -> Vec<String> {
    fn texts(shape: &egui::Shape, clip: egui::Rect, found: &mut Vec<String>) {
        match shape {
            egui::Shape::Vec(all) => all.iter().for_each(|one| texts(one, clip, found)),
            egui::Shape::Text(text) => {
                let rect = text.visual_bounding_rect();
                let is_seen = clip.intersects(rect) && text.galley.text().trim() != "";
                let is_out = rect.left() < clip.left() - 1.0 || rect.right() > clip.right() + 1.0;
                if is_seen && (text.galley.elided || is_out) {
                    found.push(format!("{} {rect:?} in {clip:?}", text.galley.text()));
                }
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    for clipped in &window.output().shapes {
        texts(&clipped.shape, clipped.clip_rect, &mut found);
    }
    found
}

#[test]
fn no_text_is_cut_in_any_workspace_at_any_size() {
    let files = Files::new();
    let mut cut = Vec::new();
    for (size, scale) in [((1600.0, 900.0), 1.0), ((1280.0, 800.0), 1.0), ((1600.0, 900.0), 1.5)] {
        let preferences = Preferences { text_scale: scale, ..Preferences::default() };
        let mut window = window_of(files.three(), Choices::default(), preferences);
        window.set_size(Vec2::new(size.0, size.1) / scale);
        settle(&mut window);
        for (at, key) in
            [Key::F2, Key::F3, Key::F4, Key::F5, Key::F6, Key::F7, Key::F8].into_iter().enumerate()
        {
            window.key_press(key);
            settle(&mut window);
            let of = |text: String| format!("{size:?} × {scale}, {}: {text}", Workspace::ALL[at].1);
            cut.extend(cut_texts(&window).into_iter().map(of));
        }
    }
    assert!(cut.is_empty(), "{}", cut.join("\n"));
}

/// Fits, notices and the answer about the error come and go, and nothing in the window moves.
#[test]
fn no_control_moves_while_results_and_notices_come_and_go() {
    let files = Files::new();
    let mut window = window(files.three());
    // The remedy says what it brings, and the mark of the lowest error is data.
    let is_result = |label: &str| label.contains("% FS") || label.starts_with("Lowest error");
    let before = places(&window);
    let moved = |window: &Window| -> Vec<String> {
        let now = places(window);
        let is_same = |(role, label, rect): &&(Role, String, egui::Rect)| {
            now.iter().any(|(other, name, place)| (other, name, place) == (role, label, rect))
        };
        let moved = before.iter().filter(|place| !is_result(&place.1) && !is_same(place));
        moved.map(|place| format!("{place:?}")).collect()
    };
    for value in [1.0, 2.5, 3.0] {
        window.get_by_role_and_label(Role::Slider, "F_th").set_value_accesskit(value);
        for _ in 0..20 {
            window.step();
            let moved = moved(&window);
            assert!(moved.is_empty(), "{moved:?}");
        }
        settle(&mut window);
    }
    window.state_mut().as_mut().unwrap().send(Command::tell(Level::Info, "a notice"));
    window.run_steps(3);
    let moved = moved(&window);
    assert!(moved.is_empty(), "{moved:?}");
}

/// If preferences are unchanged, they must not overwrite the preferences that another window has stored.
#[test]
fn drawing_alone_changes_no_preferences() {
    let begun = Preferences { text_scale: 1.5, ..Preferences::default() };
    let window = window_of(Vec::new(), Choices::default(), begun.clone());
    assert_eq!(shell(&window).preferences(), begun);
}

/// Three tick labels fit into a plot that is 48 points high, because labels need 12 points.
#[test]
fn six_axes_are_whole_and_high_enough_for_three_ticks_at_every_usual_size() {
    let mut window = window(Vec::new());
    for (width, height) in [(1280.0, 800.0), (1600.0, 900.0), (1920.0, 1080.0)] {
        window.set_size(Vec2::new(width, height));
        window.key_press(Key::F3);
        settle(&mut window);
        let mut n_plots = 0;
        for label in [
            "Fx [N]",
            "Fy [N]",
            "Fz [N]",
            "Mx [N·m]",
            "My [N·m]",
            "Mz [N·m]",
            "error [N]",
            "error [N·m]",
        ] {
            for plot in window.query_all_by_role_and_label(Role::GraphicsObject, label) {
                let rect = plot.rect();
                assert!(rect.height() >= 48.0, "{label}, {width}: {rect:?}");
                assert!(rect.bottom() <= height - 20.0, "{label}, {width}: {rect:?}");
                n_plots += 1;
            }
        }
        assert_eq!(n_plots, 12, "{width}");
    }
}

#[test]
fn settings_and_roles_are_undone_and_made_again() {
    let files = Files::new();
    let mut window = window(files.three());
    wait(&mut window, 10);
    let first = f_th(&window);
    slide(&mut window, "F_th", 1.5);
    wait(&mut window, 10);
    menu(&mut window, "Edit", "Exclude all");
    wait(&mut window, 10);
    ctrl(&mut window, Key::Z);
    assert_eq!(state(&window).problem(), None, "the training recordings are back");
    assert_eq!(f_th(&window), 1.5);
    ctrl(&mut window, Key::Z);
    assert_eq!(f_th(&window), first);
    menu(&mut window, "Edit", "Redo");
    assert_eq!(f_th(&window), 1.5);
    assert_eq!(analysis(&window).calibration.features.look_backs[0].f_th, 1.5);
}

/// Switches of features are separate steps of undo, even if they follow each other immediately.
#[test]
fn each_tick_is_a_step_and_a_drag_is_one() {
    let files = Files::new();
    let mut window = window(files.three());
    let used = |window: &Window| state(window).project().settings.features.blocks.used().count();
    for block in ["Creep", "Fixed lag", "Polynomial"] {
        click(&mut window, Role::Button, block);
    }
    for n in [2, 1, 0] {
        ctrl(&mut window, Key::Z);
        assert_eq!(used(&window), n);
    }
    let first = f_th(&window);
    let slider = window.get_by_role_and_label(Role::Slider, "F_th").rect();
    let at = |share: f32| slider.lerp_inside(egui::vec2(share, 0.5));
    let button = |pressed, at| egui::Event::PointerButton {
        pos: at,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.event(egui::Event::PointerMoved(at(0.2)));
    window.event(button(true, at(0.2)));
    window.step();
    for step in 3..9 {
        window.event(egui::Event::PointerMoved(at(0.1 * step as f32)));
        window.run_steps(2);
    }
    window.event(button(false, at(0.8)));
    window.event(egui::Event::PointerGone);
    settle(&mut window);
    assert_ne!(f_th(&window), first);
    ctrl(&mut window, Key::Z);
    assert_eq!(f_th(&window), first);
}

#[test]
fn settings_before_files_were_opened_can_be_undone() {
    let files = Files::new();
    let mut window = window(files.three());
    let first = f_th(&window);
    slide(&mut window, "F_th", 1.5);
    let other = files.recording("d.csv", 0.5, 300, &FORCES);
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Action::Open(vec![other]));
    settle(&mut window);
    assert_eq!(names(&window).len(), 4);
    ctrl(&mut window, Key::Z);
    assert_eq!((names(&window).len(), f_th(&window)), (3, 1.5));
    ctrl(&mut window, Key::Z);
    assert_eq!((names(&window).len(), f_th(&window)), (3, first));
}

#[test]
fn the_palette_finds_an_action_by_a_part_of_its_name() {
    let files = Files::new();
    let mut window = window(files.three());
    ctrl(&mut window, Key::P);
    window.event(egui::Event::Text("space loops".to_owned()));
    window.run_steps(2);
    assert!(has(&window, "Workspace Loops") && !has(&window, "Larger"));
    window.key_press(Key::Enter);
    settle(&mut window);
    assert!(on_screen(&window, named("loops")));
    assert!(window.query_by_role_and_label(Role::TextInput, "Find an action").is_none());
}

#[test]
fn help_shows_every_page_with_the_glyphs_they_need() {
    let mut window = window_of(Vec::new(), Choices::default(), Preferences::default());
    window.key_press(Key::F1);
    settle(&mut window);
    for (page, part) in [
        ("Glossary", "zooms at the pointer"),
        ("Glossary", "Cross-validation by recording"),
        ("Equations", "Eq. 12"),
        ("Shortcuts", "Undo"),
    ] {
        click(&mut window, Role::Button, page);
        assert!(has(&window, part), "{page}");
        window.check_accessibility();
    }
    for key in [Key::F1, Key::Escape] {
        let shown = "shows all data of the plot that has the focus";
        assert!(has(&window, shown));
        window.key_press(key);
        settle(&mut window);
        assert!(!has(&window, shown), "{key:?} closes it");
        window.key_press(Key::F1);
        settle(&mut window);
    }
}

#[test]
fn a_click_puts_a_cursor_and_with_shift_the_span_has_figures() {
    let files = Files::new();
    let mut window = window(files.three());
    let pane = window.get_by_role_and_label(Role::GraphicsObject, "Fx [N]").rect();
    let press = |window: &mut Window, at: egui::Pos2, modifiers: Modifiers| {
        window.hover_at(at);
        window.step();
        for pressed in [true, false] {
            let button = egui::Event::PointerButton {
                pos: at,
                button: egui::PointerButton::Primary,
                pressed,
                modifiers,
            };
            window.event_modifiers(button, modifiers);
            window.step();
        }
        window.remove_cursor();
        wait(window, 3);
    };
    press(&mut window, pane.center(), Modifiers::NONE);
    assert!(!has(&window, "Shift+click sets cursor B"), "the hint is not shown");
    window.key_press(Key::T);
    settle(&mut window);
    assert!(has(&window, "Shift+click sets cursor B"));
    press(&mut window, pane.center() + Vec2::new(60.0, 0.0), Modifiers::SHIFT);
    assert!(has(&window, "Δt"));
    assert!(has(&window, "Fx Compensated error"));
    window.check_accessibility();
    window.key_press(Key::Escape);
    wait(&mut window, 3);
    assert!(!has(&window, "Δt"));
}

#[test]
fn space_plays_through_time_and_stops() {
    let files = Files::new();
    let mut window = window(files.three());
    window.key_press(Key::Space);
    window.run_steps(5);
    assert!(has(&window, "Stop"));
    window.key_press(Key::Space);
    settle(&mut window);
    window.key_press_modifiers(Modifiers::SHIFT, Key::A);
    window.key_press(Key::T);
    wait(&mut window, 3);
    assert!(has(&window, "Shift+click sets cursor B"), "cursor A is where playing stopped");
    window.key_press(Key::Escape);
    settle(&mut window);
    assert!(has(&window, "Play"));
}

#[test]
fn keys_zoom_and_step_through_time() {
    let files = Files::new();
    let mut window = window(files.three());
    let press = |window: &mut Window, modifiers, key| {
        window.key_press_modifiers(modifiers, key);
        wait(window, 3);
        shell(window).visible_time()
    };
    let width = |(from, to): (f64, f64)| to - from;
    let zoomed = press(&mut window, Modifiers::SHIFT, Key::ArrowUp).expect("a part");
    let again = press(&mut window, Modifiers::SHIFT, Key::ArrowUp).expect("a part");
    assert!((width(again) - 0.5 * width(zoomed)).abs() < 1e-9);
    let later = press(&mut window, Modifiers::SHIFT, Key::ArrowRight).expect("a part");
    assert!((later.0 - again.0 - 0.25 * width(again)).abs() < 1e-9);
    assert_eq!(press(&mut window, Modifiers::NONE, Key::Home), None);
    for _ in 0..3 {
        press(&mut window, Modifiers::NONE, Key::Period);
    }
    press(&mut window, Modifiers::SHIFT, Key::A);
    for _ in 0..2 {
        press(&mut window, Modifiers::NONE, Key::Period);
    }
    press(&mut window, Modifiers::NONE, Key::Comma);
    press(&mut window, Modifiers::SHIFT, Key::B);
    press(&mut window, Modifiers::NONE, Key::T);
    assert!(
        has(&window, "A 0.1500000 s, B 0.2000000 s"),
        "at 20 Hz, the cursors are at steps three and four"
    );
}

#[test]
fn a_plot_with_the_focus_is_moved_zoomed_and_copied_by_keys() {
    let files = Files::new();
    let mut window = window(files.three());
    for (pane, plot) in [(named("traces"), "Fx [N]"), (named("loops"), "against Fx Reference")] {
        let shell = window.state_mut().as_mut().unwrap();
        shell.send(Command::ShowPane(pane));
        settle(&mut window);
        let node = window.get_by(|node| {
            node.role() == Role::GraphicsObject
                && node.label().is_some_and(|label| label.contains(plot))
        });
        node.focus();
        wait(&mut window, 2);
        for key in [Key::Plus, Key::ArrowRight] {
            window.key_press(key);
            wait(&mut window, 3);
        }
        if pane == named("traces") {
            let (from, to) = super::shell(&window).visible_time().expect("a part");
            assert!(to - from < 18.0 && from > 2.0, "{from} to {to}");
            window.key_press(Key::Backspace);
            wait(&mut window, 3);
            assert_eq!(super::shell(&window).visible_time(), None);
        }
        window.key_press_modifiers(Modifiers::SHIFT, Key::F10);
        wait(&mut window, 3);
        assert!(has(&window, "Save as SVG…"), "{plot}");
        window.key_press(Key::Enter);
        window.run_steps(4);
        assert!(!has(&window, "Save as SVG…"), "Enter takes the first item");
    }
}

#[test]
fn a_plot_that_is_zoomed_into_far_draws_no_more_than_is_seen() {
    let files = Files::new();
    let mut window = window(files.three());
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Command::ShowPane(named("loops")));
    settle(&mut window);
    let before = window.output().shapes.len();
    let plot = window.get_by(|node| {
        node.role() == Role::GraphicsObject
            && node.label().is_some_and(|label| label.contains("against Fx Reference"))
    });
    plot.focus();
    wait(&mut window, 2);
    for _ in 0..45 {
        window.key_press(Key::Plus);
        window.step();
    }
    settle(&mut window);
    let after = window.output().shapes.len();
    assert!(after < 2 * before, "{before} shapes, then {after}");
}

#[test]
fn themes_and_sizes_are_preferences() {
    let files = Files::new();
    let mut window = window(files.three());
    menu(&mut window, "View", "Light");
    assert!(!window.ctx.global_style().visuals.dark_mode);
    assert_eq!(shell(&window).preferences().theme, Theme::Light);
    let send = |window: &mut Window, step| {
        let shell = window.state_mut().as_mut().unwrap();
        shell.send(Command::TextScale(step));
        settle(window);
    };
    send(&mut window, 1);
    assert!((shell(&window).preferences().text_scale - 1.1).abs() < 1e-6);
    for _ in 0..40 {
        send(&mut window, -1);
    }
    assert_eq!(shell(&window).preferences().text_scale, 0.5);
    send(&mut window, 0);
    assert_eq!(window.ctx.zoom_factor(), 1.0);
    ctrl(&mut window, Key::Equals);
    assert!((window.ctx.zoom_factor() - 1.1).abs() < 1e-6);
    assert!((shell(&window).preferences().text_scale - 1.1).abs() < 1e-6);
}

#[test]
fn a_file_that_is_there_is_replaced_only_after_a_yes() {
    let files = Files::new();
    let mut window = window(files.three());
    let path = files.write("there.csv", "precious");
    show(&mut window, "export");
    type_into(&mut window, "Export to", path.to_str().unwrap());
    click(&mut window, Role::Button, "Write 1 file");
    click(&mut window, Role::Button, "Do not write");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "precious");
    click(&mut window, Role::Button, "Write 1 file");
    click(&mut window, Role::Button, "Replace it");
    message(&mut window, Level::Info, "there.csv");
    assert!(std::fs::read_to_string(&path).unwrap().contains("S1_past"));
}

#[test]
fn a_new_document_forgets_the_identity_and_the_exported_path() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "export");
    type_into(&mut window, "Serial number is missing", "SN-0042");
    settle(&mut window);
    let path = files.path("first.json");
    type_into(&mut window, "Export to", path.to_str().unwrap());
    click(&mut window, Role::Button, "Write 1 file");
    assert_eq!(read_calibration(&path).unwrap().identity.get(recording::Item::Serial), "SN-0042");

    ctrl(&mut window, Key::N);
    assert_eq!(names(&window).len(), 3, "the user is asked about unsaved changes");
    click(&mut window, Role::Button, "Discard");
    assert_eq!(names(&window), Vec::<String>::new());
    let other = files
        .write("other.csv", "t [s],G1,G2,Fz [N]\n0,1,2,3\n1,2,1,4\n2,0,1,7\n3,1,3,5\n4,2,2,8\n");
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Action::Open(vec![other]));
    settle(&mut window);
    show(&mut window, "export");
    let field = window.get_by_role_and_label(Role::TextInput, "Export to");
    assert_eq!(field.value().as_deref(), Some("calibration.json"));
    let serial = window.get_by_role_and_label(Role::TextInput, "Serial number is missing");
    assert_eq!(serial.value().unwrap_or_default(), "");
    assert!(state(&window).project().identity.is_empty());
}

/// The recordings have three axes, which a `.cal` file cannot hold. The folder of the second path does not exist.
#[test]
fn each_format_shows_its_result_and_one_that_cannot_hold_the_calibration_is_disabled() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "export");
    let cal = window.get_by_role_and_label(Role::CheckBox, "ATI drivers");
    assert!(cal.accesskit_node().is_disabled());
    let path = files.path("c.cal");
    type_into(&mut window, "Export to", path.to_str().unwrap());
    settle(&mut window);
    let write = window.get_by_role_and_label(Role::Button, "Write 0 files");
    assert!(write.accesskit_node().is_disabled());
    type_into(&mut window, "Export to", files.path("c.json").to_str().unwrap());
    settle(&mut window);
    click(&mut window, Role::CheckBox, "Spreadsheets");
    click(&mut window, Role::Button, "Write 2 files");
    assert_eq!(window.query_all_by_role_and_label(Role::Label, "Written").count(), 2);
    type_into(&mut window, "Export to", files.path("gone/c.json").to_str().unwrap());
    click(&mut window, Role::Button, "Write 2 files");
    assert_eq!(window.query_all_by_role_and_label(Role::Label, "Written").count(), 0);
    assert!(has(&window, "0 of 2 files written"));
    assert_eq!(state(&window).exported(&files.path("c.json")), Some(&Ok(())));
}

#[test]
fn an_empty_window_opens_a_typed_path() {
    let files = Files::new();
    let mut window = window(Vec::new());
    ctrl(&mut window, Key::N);
    assert!(names(&window).is_empty());
    click(&mut window, Role::Button, "Type a path…");
    type_into(&mut window, PathFor::Open.title(), files.three()[0].to_str().unwrap());
    click(&mut window, Role::Button, "Open");
    assert_eq!(names(&window), ["a"]);
}

#[test]
fn a_path_is_typed_where_there_is_no_dialog() {
    let files = Files::new();
    let mut window = window(files.three());
    let content = loopscope::engine::FileContent::Bytes(std::sync::Arc::from(*b"picture"));
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Command::TypePath(PathFor::Save(content)));
    settle(&mut window);
    let path = files.path("p.png");
    type_into(&mut window, "Save as", path.to_str().unwrap());
    window.get_all_by_role_and_label(Role::Button, "Save").last().unwrap().click();
    settle(&mut window);
    assert_eq!(std::fs::read(&path).unwrap(), b"picture");
}

#[test]
fn a_recording_is_tared_and_undone() {
    let files = Files::new();
    let mut window = window(files.three());
    let first =
        |window: &Window| state(window).project().recordings.entries()[0].recording.gauges()[0];
    let before = first(&window);
    wait(&mut window, 10);
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Action::Tare(vec![0], recording::Tare::Interval(0.0, 0.0)));
    settle(&mut window);
    assert_eq!(first(&window), 0.0, "only the first sample is the tare");
    wait(&mut window, 10);
    ctrl(&mut window, Key::Z);
    assert_eq!(first(&window), before);
    menu(&mut window, "Edit", "Tare each recording");
    assert!(
        has(&window, "no half second without movement"),
        "these recordings have no unloaded interval"
    );
}

#[test]
fn presenter_mode_shows_a_sentence_the_map_one_axis_and_both_sliders() {
    let files = Files::new();
    let mut window = window(files.three());
    window.key_press(Key::Num2);
    settle(&mut window);
    window.key_press(Key::F11);
    wait(&mut window, 3);
    assert!(has(&window, " instead of ") && !has(&window, "Find an action"));
    assert_eq!(panes(&window, "Map of F_th and t_th"), 1);
    assert_eq!(panes(&window, "Fy [N]"), 1);
    slide(&mut window, "t_th", 4.0);
    assert_eq!(state(&window).project().thresholds().t_th_secs, 4.0);
    window.key_press(Key::L);
    window.key_press(Key::B);
    wait(&mut window, 3);
    assert_eq!(panes(&window, "Map of F_th and t_th"), 0);
    assert_eq!(panes(&window, "Fy error [N] against Fy Reference [N]"), 1);
    assert!(has(&window, " without compensation"));
    window.key_press(Key::Escape);
    wait(&mut window, 3);
    assert!(has(&window, "Find an action"));
}
