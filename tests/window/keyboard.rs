//! Checks that all actions can be done with keys alone.

use super::*;
use crate::importing::{headerless, page};

fn key(key: Key) -> egui::Event {
    held(Modifiers::NONE, key)
}

fn held(modifiers: Modifiers, key: Key) -> egui::Event {
    egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
}

fn palette() -> egui::Event {
    held(Modifiers::COMMAND, Key::P)
}

/// Draws one frame with all these events together, as on a slow machine.
fn at_once(window: &mut Window, events: impl IntoIterator<Item = egui::Event>) {
    window.input_mut().events.extend(events);
    window.step();
}

fn press(window: &mut Window, keys: &[Key]) {
    for one in keys {
        at_once(window, [key(*one)]);
        window.run_steps(2);
    }
}

fn focused(window: &Window) -> Option<String> {
    let node = window.query_all_by(|node| node.is_focused()).next()?;
    let node = node.accesskit_node();
    node.label().or(node.value())
}

/// Opens the list of this button with the keyboard.
#[track_caller]
fn open(window: &mut Window, button: &str) {
    window.get_by_role_and_label(Role::ComboBox, button).focus();
    window.run_steps(2);
    press(window, &[Key::Enter]);
}

fn chosen(window: &Window, button: &str) -> String {
    let button = window.get_by_role_and_label(Role::ComboBox, button);
    button.value().unwrap_or_default()
}

#[test]
fn text_typed_right_after_the_palettes_keys_goes_into_the_palette() {
    let files = Files::new();
    // The key works without a focus, and while a text field has the focus.
    for field in [None, Some("Export to")] {
        let mut window = window(files.three());
        if let Some(field) = field {
            let shell = window.state_mut().as_mut().unwrap();
            shell.send(Command::ShowPane(crate::workspace::named("export")));
            settle(&mut window);
            window.get_by_role_and_label(Role::TextInput, field).focus();
            window.run_steps(2);
        }
        let text = |text: &str| egui::Event::Text(text.to_owned());
        let path = field.map(|field| {
            let field = window.get_by_role_and_label(Role::TextInput, field);
            field.value()
        });
        at_once(
            &mut window,
            [palette(), key(Key::T), text("t"), key(Key::A), text("a"), text("b")],
        );
        at_once(&mut window, [text("l"), text("x"), key(Key::Backspace)]);
        for letter in ["e", " ", "c"] {
            at_once(&mut window, [text(letter)]);
        }
        let typed = window.get_by_role_and_label(Role::TextInput, "Find an action");
        assert_eq!(typed.value().as_deref(), Some("table c"));
        if let Some(path) = path {
            let field = window.get_by_role_and_label(Role::TextInput, field.unwrap());
            assert_eq!(field.value(), path, "all of the text is in the field");
        }
        press(&mut window, &[Key::Escape]);
        assert!(window.query_by_role_and_label(Role::TextInput, "Find an action").is_none());
    }
}

#[test]
fn a_whole_search_in_one_frame_is_done() {
    let files = Files::new();
    let mut window = window(files.three());
    let text = egui::Event::Text("show me".to_owned());
    let down = || key(Key::ArrowDown);
    at_once(&mut window, [palette(), text, down(), down(), key(Key::Enter)]);
    settle(&mut window);
    assert!(shell(&window).on_screen().contains(&crate::workspace::named("metrology")));
    assert!(window.query_by_role_and_label(Role::TextInput, "Find an action").is_none());
}

/// Types `words` into the palette, and runs the first action that it finds.
fn find(window: &mut Window, words: &str) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.event(egui::Event::Text(words.to_owned()));
    window.key_press(Key::Enter);
    settle(window);
    window.run_steps(4);
}

#[test]
fn the_palette_finds_the_control_of_each_setting() {
    let files = Files::new();
    let mut window = window(files.three());
    let send = window.state_mut().as_mut().unwrap();
    send.send(Command::Show(loopscope::ui::Workspace::Import));
    settle(&mut window);
    let mut settings = state(&window).project().settings.clone();
    for (words, control) in [
        ("set f_th", "F_th"),
        ("set t_th", "t_th"),
        ("creep", "Creep"),
        ("set play", "Play"),
        ("set polynomial", "none"),
        ("set ridge", "ridge"),
        ("set offset", "Offset term"),
        ("history rate", "History rate"),
        ("decimation", "Decimation"),
        ("set epochs", "Epochs"),
        ("set seed", "seed"),
        ("set ridge", "auto"),
    ] {
        if words == "set epochs" {
            settings.regressor = Regressor::Network;
            settings.ridge = RidgeChoice::Auto;
            let send = window.state_mut().as_mut().unwrap();
            send.send(Edit::Settings(settings.clone()));
            settle(&mut window);
        }
        find(&mut window, words);
        assert_eq!(focused(&window).as_deref(), Some(control), "{words}");
    }
}

#[test]
fn the_palette_opens_recent_files() {
    let files = Files::new();
    let mut window = window(files.three());
    let send = window.state_mut().as_mut().unwrap();
    send.send(Edit::New);
    settle(&mut window);
    find(&mut window, "open test_c");
    assert_eq!(names(&window), ["test_c"]);
}

#[test]
fn arrows_move_through_a_list_from_the_chosen_item_and_enter_chooses() {
    let files = Files::new();
    let mut window = window(files.three());
    let list = "Recording";
    let first = chosen(&window, list);
    assert_eq!(first, "a");
    open(&mut window, list);
    assert_eq!(focused(&window).as_deref(), Some("a"));
    press(&mut window, &[Key::ArrowDown]);
    assert_eq!(focused(&window).as_deref(), Some("b"));
    press(&mut window, &[Key::ArrowDown, Key::ArrowDown]);
    assert_eq!(
        focused(&window).as_deref(),
        Some("All, one after the other"),
        "the arrows wrap around the end"
    );
    press(&mut window, &[Key::ArrowUp, Key::Enter]);
    assert_eq!(chosen(&window, list), "test_c");
    assert_eq!(focused(&window).as_deref(), Some(list), "the button has the focus again");
    press(&mut window, &[Key::Enter, Key::ArrowUp, Key::Escape]);
    assert_eq!(chosen(&window, list), "test_c", "Escape changes nothing");
    assert_eq!(focused(&window).as_deref(), Some(list));
}

#[test]
fn no_key_of_a_list_is_lost_if_several_come_in_one_frame() {
    let files = Files::new();
    let mut window = window(files.three());
    let list = "Recording";
    window.get_by_role_and_label(Role::ComboBox, list).focus();
    window.run_steps(2);
    at_once(&mut window, [key(Key::Enter)]);
    at_once(&mut window, [key(Key::ArrowDown), key(Key::ArrowDown), key(Key::Enter)]);
    settle(&mut window);
    assert_eq!(chosen(&window, list), "test_c");
}

#[test]
fn arrows_go_on_from_a_list_that_was_opened_by_a_click() {
    let files = Files::new();
    let mut window = window(files.three());
    let button = window.get_by_role_and_label(Role::ComboBox, "Model type");
    button.click();
    window.run_steps(3);
    press(&mut window, &[Key::ArrowDown, Key::ArrowDown, Key::Enter]);
    assert_eq!(chosen(&window, "Model type"), Regressor::ALL[2].label());
}

#[test]
fn a_long_list_follows_the_focus() {
    let files = Files::new();
    let first = files.write("first.dat", &headerless(400));
    let mut window = page(vec![first]);
    let button = window.get_by_role_and_label(Role::ComboBox, "Role of column 1");
    button.focus();
    window.run_steps(2);
    press(&mut window, &[Key::Enter]);
    press(&mut window, &[Key::ArrowUp]);
    let last = focused(&window).expect("an item");
    let item = window.query_all_by_label(&last).last().unwrap().rect();
    let layer = window.ctx.layer_id_at(item.center());
    let is_seen = layer.is_some_and(|layer| layer.order == egui::Order::Foreground);
    assert!(is_seen, "{last} at {item} is not on the list");
}

/// Ctrl and an arrow step a threshold, but move by words in a text field.
#[test]
fn keys_step_the_thresholds_unless_text_is_typed() {
    let files = Files::new();
    let mut window = window(files.three());
    let pair = |window: &Window| state(window).project().thresholds();
    let first = pair(&window);
    for (held, key) in [
        (Modifiers::COMMAND, Key::ArrowRight),
        (Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::ArrowDown),
    ] {
        window.key_press_modifiers(held, key);
        settle(&mut window);
    }
    let stepped = pair(&window);
    assert!(stepped.f_th > first.f_th && stepped.t_th_secs < first.t_th_secs, "{stepped:?}");
    show(&mut window, "recordings");
    window.get_by_role_and_label(Role::TextInput, "Filter").focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::ArrowRight);
    settle(&mut window);
    assert_eq!(pair(&window), stepped);
}
