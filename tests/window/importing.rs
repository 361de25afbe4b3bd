//! Import of files whose headers do not show the roles of the columns.

use std::fmt::Write as _;

use super::*;

/// Returns a text without a header: times, two gauges and a force. The force is twice the first gauge.
pub fn headerless(n: usize) -> String {
    (0..n).fold(String::new(), |mut text, k| {
        let t = k as f64 / 20.0;
        let (a, b) = ((0.7 * t).sin(), (0.4 * t).cos());
        writeln!(text, "{t};{a};{b};{}", 2.0 * a).unwrap();
        text
    })
}

/// Returns a window with the import page of these files.
pub fn page(files: Vec<PathBuf>) -> Window {
    let mut window = window(Vec::new());
    let shell = window.state_mut().as_mut().unwrap();
    files.into_iter().for_each(|path| shell.send(ImportCommand::Open(path)));
    settle(&mut window);
    window
}

fn choose(window: &mut Window, column: impl std::fmt::Display, role: &str) {
    let combo = format!("Role of column {column}");
    click(window, Role::ComboBox, &combo);
    settle(window);
    let items: Vec<_> = window.query_all_by_label(role).collect();
    // The list is longer than its visible part, so the test finds the item by its label.
    let item = items.last().unwrap_or_else(|| panic!("no {role}"));
    item.click_accesskit();
    settle(window);
}

#[test]
fn columns_without_names_are_chosen_once_and_the_next_file_of_that_shape_loads_at_once() {
    let files = Files::new();
    let first = files.write("first.dat", &headerless(400));
    let second = files.write("test_second.dat", &headerless(300));
    let mut window = page(vec![first]);
    assert!(has(&window, "Import first.dat"));
    window.check_accessibility();
    for (column, role) in [(1, "Time"), (2, "Gauge"), (3, "Gauge"), (4, "Fx")] {
        choose(&mut window, column, role);
    }
    assert!(has(&window, "Would load 1 recording, 400 samples at 20"));
    type_into(&mut window, "unit of column 4", "N");
    settle(&mut window);
    click(&mut window, Role::Button, "Load the file");
    assert_eq!(names(&window), ["first"]);
    assert!(train_rmse(&window)[0][0] < 1e-9, "the force is twice a gauge");

    let send = window.state_mut().as_mut().unwrap();
    send.send(Action::Open(vec![second]));
    settle(&mut window);
    assert_eq!(names(&window), ["first", "test_second"]);
    assert!(state(&window).importing.is_none());
    message(
        &mut window,
        Level::Info,
        "test_second.dat: read with the column map of an earlier, similar file: time is column 1, Fx is column 4, 2 gauges",
    );
}

/// A user needs eleven presses: two for the role of the load, and one each for the field of its unit, the buttons and the path. The
/// search is stopped after two models.
#[test]
fn eleven_presses_lead_from_a_file_without_a_header_to_c_code() {
    let files = Files::new();
    let first = files.write("first.dat", &headerless(400));
    let mut window = page(vec![first]);
    choose(&mut window, 4, "Fx");
    type_into(&mut window, "unit of column 4", "N");
    settle(&mut window);
    click(&mut window, Role::Button, "Load the file");
    click(&mut window, Role::Button, "Models");
    window.get_by_role_and_label(Role::Button, "Find the best").click();
    until(&mut window, |shell| shell.engine().models.rows.len() >= 2);
    click(&mut window, Role::Button, "Stop");
    click_first(&mut window, Role::Button, "Use");
    click(&mut window, Role::Button, "Export");
    let code = files.path("sensor.h");
    type_into(&mut window, "Export to", code.to_str().unwrap());
    settle(&mut window);
    click(&mut window, Role::Button, "Write 1 file");
    until(&mut window, |_| code.exists());
    assert!(std::fs::read_to_string(&code).unwrap().contains("Fx"));
}

/// The other files also have unnamed columns, but the time in another column, or another delimiter.
#[test]
fn a_remembered_map_is_not_used_only_because_the_number_of_columns_is_equal() {
    let files = Files::new();
    let first = files.write("first.dat", &headerless(400));
    let mut window = page(vec![first]);
    for (column, role) in [(2, "Gauge"), (3, "Gauge"), (4, "Fx")] {
        choose(&mut window, column, role);
    }
    click(&mut window, Role::Button, "Load the file");
    let turned = headerless(100).lines().fold(String::new(), |text, line| {
        let cells: Vec<&str> = line.split(';').collect();
        text + &format!("{};{};{};{}\n", cells[3], cells[1], cells[0], cells[2])
    });
    let others = [
        ("turned.dat", turned),
        ("commas.dat", headerless(100).replace(';', ",")),
        ("named.dat", format!("a;b;c;d\n{}", headerless(100))),
    ];
    for (name, text) in others {
        let path = files.write(name, &text);
        let send = window.state_mut().as_mut().unwrap();
        send.send(Action::Open(vec![path.clone()]));
        settle(&mut window);
        assert!(!state(&window).project().maps.contains_key(&path), "{name}");
    }
}

/// Returns a text as spreadsheets export it: units in brackets, semicolons, decimal commas. The force is twice the first channel.
fn bracketed(n: usize) -> String {
    let header = "Uhr [s];Messstelle 1 [mV/V];Messstelle 2 [mV/V];Presse [N]\n";
    header.to_owned() + &headerless(n).replace('.', ",")
}

#[test]
fn columns_whose_header_has_a_unit_are_shown_as_they_are_read_and_have_one_rule_each() {
    let files = Files::new();
    let mut window = page(vec![files.write("excel.csv", &bracketed(400))]);
    for (column, role) in [
        ("Uhr [s]", "Time"),
        ("Messstelle 1 [mV/V]", "Gauge"),
        ("Messstelle 2 [mV/V]", "Gauge"),
        ("Presse [N]", "Fz"),
    ] {
        let combo = format!("Role of column {column}");
        let combo = window.get_by_role_and_label(Role::ComboBox, &combo);
        assert_eq!(combo.value().as_deref(), Some(role));
    }
    choose(&mut window, "Presse [N]", "Fx");
    for role in ["Ignore", "Fy", "Gauge"] {
        choose(&mut window, "Messstelle 2 [mV/V]", role);
        let rules = &state(&window).importing.as_ref().unwrap().map.table.columns;
        let n_rules = if role == "Ignore" { 3 } else { 4 };
        assert_eq!(rules.len(), n_rules, "{rules:?}");
    }
    assert!(has(&window, "gauges Messstelle 1 Messstelle 2, reference Fx"));
    click(&mut window, Role::Button, "Load the file");
    assert!(train_rmse(&window)[0][0] < 1e-9);
}

#[test]
fn a_question_stands_in_its_row_and_nothing_moves() {
    let files = Files::new();
    let text = headerless(100).lines().fold(String::new(), |text, line| {
        let (time, rest) = line.split_once(';').unwrap();
        text + &format!("{time};{rest};{}\n", time.parse::<f64>().unwrap() + 5.0)
    });
    let mut window = page(vec![files.write("two_clocks.dat", &text)]);
    let questions = ["Is this the time of the reference?", "Is this the reference load?"];
    let place = |window: &Window| {
        let combo = window.get_by_role_and_label(Role::ComboBox, "Role of column 4");
        combo.rect().min
    };
    let before = place(&window);
    let check = |window: &Window, expected: [bool; 2], why: &str| {
        let is_answered = questions.map(|question| !has(window, question));
        assert_eq!(is_answered, expected, "{why}");
        let moved = place(window).distance(before);
        assert!(moved < 2.0, "{why}: {moved} px");
    };
    check(&window, [false, false], "no problem is shown");
    choose(&mut window, 3, "Ignore");
    check(&window, [false, false], "one gauge less answers neither");
    choose(&mut window, 4, "Fx");
    check(&window, [false, true], "the axis answers what the reference is");
    choose(&mut window, 5, "Reference clock");
    check(&window, [true, true], "the reference has a clock");
    choose(&mut window, 5, "Ignore");
    check(&window, [false, true], "it is open again");
    let load = window.get_by_role_and_label(Role::Button, "Load the file");
    assert!(!load.accesskit_node().is_disabled(), "an open question holds nothing up");
}

#[test]
fn a_press_answers_a_question_and_letters_give_the_selected_rows_a_role() {
    let files = Files::new();
    let mut window = page(vec![files.write("first.dat", &headerless(400))]);
    let rules =
        |window: &Window| state(window).importing.as_ref().unwrap().map.table.columns.clone();
    let last =
        |window: &Window| rules(window).iter().find(|rule| rule.column.to_string() == "4").cloned();
    let answers: Vec<_> = window.query_all_by_role_and_label(Role::Button, "kgf").collect();
    answers.last().expect("the last channel may be the load").click();
    settle(&mut window);
    let load = last(&window).expect("the channel is read");
    assert_eq!((load.is.to_string(), load.unit.as_deref()), ("Fz".to_owned(), Some("kgf")));
    let row = window.get_by_role_and_label(Role::ComboBox, "Role of column 4").rect();
    let at = row.left_center() - Vec2::new(60.0, 0.0);
    window.hover_at(at);
    window.drag_at(at);
    window.drop_at(at);
    settle(&mut window);
    for (key, role) in [(Key::G, "gauge"), (Key::I, ""), (Key::L, "Fz")] {
        window.key_press(key);
        settle(&mut window);
        let found = last(&window).map_or_else(String::new, |rule| rule.is.to_string());
        assert_eq!(found, role);
    }
}

#[test]
fn a_row_of_imports_ends_at_once() {
    let files = Files::new();
    let mut window = window(files.three());
    let paths: Vec<PathBuf> =
        (0..3).map(|at| files.write(&format!("bare{at}.dat"), &headerless(50))).collect();
    for ends in 0..2 {
        let send = window.state_mut().as_mut().unwrap();
        paths.iter().cloned().for_each(|path| send.send(ImportCommand::Open(path)));
        settle(&mut window);
        assert!(has(&window, "2 more files need a column map"));
        click(&mut window, Role::Button, "Cancel import");
        assert!(has(&window, "Import bare1"));
        if ends == 0 {
            click(&mut window, Role::Button, "Cancel all (2 files left)");
        } else {
            choose(&mut window, 2, "Gauge");
            type_into(&mut window, "name of column 2", "bridge");
            window.key_press(Key::Escape);
            settle(&mut window);
            assert!(has(&window, "Import bare1"), "Escape leaves only the field");
            for command in [Command::ToggleHelp, Command::ShowPalette] {
                window.state_mut().as_mut().unwrap().send(command);
                settle(&mut window);
                window.key_press(Key::Escape);
                settle(&mut window);
                assert!(
                    has(&window, "Import bare1"),
                    "Escape closes only the list over the window"
                );
            }
            window.key_press(Key::Escape);
            settle(&mut window);
        }
        assert!(state(&window).importing.is_none());
        message(&mut window, Level::Info, "no columns were chosen: bare1.dat, bare2.dat");
        let send = window.state_mut().as_mut().unwrap();
        send.send(Action::DismissAll);
        settle(&mut window);
    }
    assert_eq!(names(&window), ["a", "b", "test_c"]);
}

#[test]
fn problems_are_shown_before_loading_and_cancel_loses_nothing() {
    let files = Files::new();
    let mut window = window(files.three());
    let path = files.write("bare.csv", &headerless(50));
    let send = window.state_mut().as_mut().unwrap();
    send.send(Action::Import(ImportCommand::Open(path)));
    settle(&mut window);
    for column in 1..=4 {
        choose(&mut window, column, "Ignore");
    }
    let load = window.get_by_role_and_label(Role::Button, "Load the file");
    assert!(load.accesskit_node().is_disabled());
    click(&mut window, Role::Button, "Cancel import");
    assert!(!has(&window, "Import bare"));
    assert_eq!(names(&window), ["a", "b", "test_c"]);
}

/// The load is a weight of 2 kg in several orientations: `F = m Rᵀg + offset`. The offset of the reference is (0.5, -0.25, 1) N.
#[test]
fn the_weight_is_found_from_poses_and_forces() {
    let files = Files::new();
    let mut text = "t [s],S1,S2,roll,pitch,yaw,Fx [N],Fy [N],Fz [N]".to_owned();
    for k in 0..200 {
        let t = f64::from(k) / 20.0;
        let (roll, pitch) = (1.2 * (0.7 * t).sin(), 0.9 * (0.4 * t).cos());
        let pull = 2.0 * 9.806_65;
        let force = [
            pull * pitch.sin() + 0.5,
            -pull * pitch.cos() * roll.sin() - 0.25,
            -pull * pitch.cos() * roll.cos() + 1.0,
        ];
        let [x, y, z] = force;
        let (s1, s2) = (x + 0.5 * y, z - y);
        write!(text, "\n{t},{s1},{s2},{roll},{pitch},0.0,{x},{y},{z}").unwrap();
    }
    let path = files.write("arm.csv", &text);
    let mut window = window(files.three());
    let send = window.state_mut().as_mut().unwrap();
    send.send(Action::Import(ImportCommand::Open(path)));
    settle(&mut window);
    for (column, role) in [("roll", "Pose roll"), ("pitch", "Pose pitch"), ("yaw", "Pose yaw")] {
        choose(&mut window, column, role);
    }
    let weight = "Computes the reference load of a known weight from the pose columns";
    click(&mut window, Role::CheckBox, weight);
    click(&mut window, Role::Button, "Find the weight");
    message(&mut window, Level::Info, "reference force: 0.500000, -0.250000, 1.000000 N");
    let importing =
        |window: &Window| state(window).importing.clone().expect("the estimate is shown");
    let found = importing(&window).map.weight.and_then(|weight| weight.mass_kg);
    assert!((found.unwrap() - 2.0).abs() < 1e-6, "{found:?}");
    window.check_accessibility();
}

/// A click selects a row, and Shift+click selects all rows up to the clicked row. With a load axis as role, the following rows get the
/// following axes.
#[test]
fn a_role_chosen_for_one_of_the_selected_columns_is_for_all_of_them() {
    let files = Files::new();
    let rows = (0..300).fold("clock,alpha,beta,gamma,delta\n".to_owned(), |text, k| {
        let a = (0.1 * f64::from(k)).sin();
        format!("{text}{},{a},{},{},{}\n", 0.05 * f64::from(k), a + 1.0, 2.0 * a, 3.0 - a)
    });
    let mut window = page(vec![files.write("run.csv", &rows)]);
    let select = |window: &mut Window, column: &str, modifiers: egui::Modifiers| {
        window.get_by_label(column).click_modifiers(modifiers);
        settle(window);
    };
    let roles = |window: &Window| -> Vec<String> {
        let importing = state(window).importing.as_ref().unwrap();
        let rules = importing.map.table.columns.iter();
        rules.map(|rule| format!("{} {}", rule.column, rule.is)).collect()
    };
    let gauges = ["alpha", "beta", "gamma", "delta"].map(|name| format!("\"{name}\" gauge"));
    assert_eq!(roles(&window)[1..], gauges);
    select(&mut window, "beta", egui::Modifiers::NONE);
    select(&mut window, "delta", egui::Modifiers::SHIFT);
    choose(&mut window, "gamma", "Fx");
    let loads = ["\"beta\" Fx", "\"gamma\" Fy", "\"delta\" Fz"];
    assert_eq!(roles(&window)[2..], loads);
    select(&mut window, "gamma", egui::Modifiers::COMMAND);
    choose(&mut window, "beta", "Ignore");
    assert_eq!(roles(&window)[1..], ["\"alpha\" gauge", "\"gamma\" Fy"]);
    window.check_accessibility();
}
