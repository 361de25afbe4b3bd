//! Texts for screen readers. A value is read with the names of its row and column.

use super::*;

#[test]
fn the_text_of_a_table_cell_has_its_row_column_and_unit() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "calibration");
    // A number of the matrix is read with the names of its axis and feature.
    assert!(has(&window, "S1 Fx "));
}

#[test]
fn the_text_of_a_plot_has_its_values_or_its_contents() {
    let files = Files::new();
    let mut window = window(files.three());
    let plot = |window: &Window| {
        let plot = window.get_by_role_and_label(Role::GraphicsObject, "Fx [N]");
        (plot.rect(), plot.value().unwrap_or_default())
    };
    let (rect, printed) = plot(&window);
    assert!(printed.starts_with("time [s]: ") && printed.contains(", Fx [N]: "), "{printed}");
    window.hover_at(rect.center());
    window.run_steps(3);
    let (_, printed) = plot(&window);
    assert!(printed.starts_with("Fx at ") && printed.contains(" s: Reference "), "{printed}");
    assert!(printed.contains(", Compensated ") && printed.contains(" N, error "), "{printed}");
    window.remove_cursor();
    window.run_steps(3);
    let traces = &analysis(&window).traces;
    let value = traces.axes[0].conventional.value(0);
    window.state_mut().as_mut().unwrap().send(Command::Time(loopscope::ui::TimeMove::Step(1)));
    window.run_steps(3);
    let (_, printed) = plot(&window);
    assert!(
        printed.starts_with("Fx at ") && value.is_finite(),
        "the keys give the same text: {printed}"
    );
}

#[test]
fn fields_of_the_import_window_are_named_by_the_header() {
    let files = Files::new();
    let text = (0..300).fold("time,load cell,x,x\n".to_owned(), |text, k| {
        text + &format!("{},{},{},{k}\n", 0.01 * f64::from(k), k % 7, k % 5)
    });
    let path = files.write("odd.csv", &text);
    let mut window = window(files.three());
    window.state_mut().as_mut().unwrap().send(ImportCommand::Open(path));
    settle(&mut window);
    for (name, role) in
        [("column load cell", "Gauge"), ("column 3, x", "Gauge"), ("column time", "Time")]
    {
        let combo = format!("Role of {name}");
        let combo = window.get_by_role_and_label(Role::ComboBox, &combo);
        assert_eq!(combo.value().as_deref(), Some(role), "{name}");
        window.get_by_role_and_label(Role::TextInput, &format!("unit of {name}"));
        click(&mut window, Role::Button, &format!("more about {name}"));
        window.get_by_role_and_label(Role::SpinButton, &format!("scale factor of {name}"));
        window.key_press(Key::Escape);
        settle(&mut window);
    }
}
