//! Files whose names do not say what their columns are.

use super::*;

/// Times, two gauges, a force; no header. The force is twice the first gauge.
pub fn headerless(n: usize) -> String {
    (0..n).fold(String::new(), |mut text, k| {
        let t = k as f64 / 20.0;
        let (a, b) = ((0.7 * t).sin(), (0.4 * t).cos());
        writeln!(text, "{t};{a};{b};{}", 2.0 * a).unwrap();
        text
    })
}

fn choose(window: &mut Window, column: usize, role: &str) {
    let combo = format!("Column {column} is ");
    window.get_by_label_contains(&combo).click();
    settle(window);
    let items: Vec<_> = window.query_all_by_label(role).collect();
    items.last().unwrap_or_else(|| panic!("no {role}")).click();
    settle(window);
}

#[test]
fn columns_without_names_are_said_once_and_the_next_file_of_that_shape_loads_at_once() {
    let files = Files::new();
    let first = files.write("first.dat", &headerless(400));
    let second = files.write("test_second.dat", &headerless(300));
    let mut window = window(vec![first]);
    assert!(has(&window, "Import first.dat"));
    window.check_accessibility();
    for (column, role) in [(1, "time"), (2, "gauge"), (3, "gauge"), (4, "Fx")] {
        choose(&mut window, column, role);
    }
    assert!(has(&window, "Would load 1 recording, 400 samples at 20"));
    click(&mut window, Role::Button, "Load it");
    assert_eq!(names(&window), ["first"]);
    assert!(
        train_rmse(&window)[0][0] < 1e-9,
        "the force is a gauge's double"
    );

    let send = window.state_mut().as_mut().unwrap();
    send.send(Command::OpenFiles(vec![second]));
    settle(&mut window);
    assert_eq!(names(&window), ["first", "test_second"]);
    assert!(state(&window).importing.is_none());
}

#[test]
fn what_would_go_wrong_is_said_before_loading_and_cancel_loses_nothing() {
    let files = Files::new();
    let mut window = window(files.three());
    let path = files.write("bare.csv", &headerless(50));
    let send = window.state_mut().as_mut().unwrap();
    send.send(Command::Import(ImportCommand::Open(path)));
    settle(&mut window);
    for column in 1..=4 {
        choose(&mut window, column, "ignore");
    }
    let load = window.get_by_role_and_label(Role::Button, "Load it");
    assert!(load.accesskit_node().is_disabled());
    click(&mut window, Role::Button, "Cancel import");
    assert!(!has(&window, "Import bare"));
    assert_eq!(names(&window), ["a", "b", "test_c"]);
}

#[test]
fn a_map_is_written_for_the_command_line_and_read_again() {
    let files = Files::new();
    let mut window = window(vec![files.write("first.dat", &headerless(400))]);
    for (column, role) in [(1, "time"), (2, "gauge"), (3, "gauge"), (4, "Fz")] {
        choose(&mut window, column, role);
    }
    let path = files.path("map.json");
    type_into(&mut window, "Column map", path.to_str().unwrap());
    click(&mut window, Role::Button, "Write map");
    let map = recording::columns::ColumnMap::read(&path).unwrap();
    assert_eq!(map, state(&window).importing.as_ref().unwrap().map);
    choose(&mut window, 4, "ignore");
    assert_ne!(map, state(&window).importing.as_ref().unwrap().map);
    click(&mut window, Role::Button, "Read map");
    assert_eq!(map, state(&window).importing.as_ref().unwrap().map);
}
