//! Checks that every control has a hover text.

use std::collections::BTreeSet;

use super::*;

const CONTROLS: [Role; 8] = [
    Role::Button,
    Role::CheckBox,
    Role::RadioButton,
    Role::Slider,
    Role::SpinButton,
    Role::ComboBox,
    Role::TextInput,
    Role::MultilineTextInput,
];
/// Controls that need no hover text. Menus open on a click and explain their items, and the cross of a tab is obvious.
const KNOWN: [&str; 7] = ["File", "Edit", "View", "Help", "Close", "Hide", "Close window"];

fn quick_to_explain(window: &mut Window) {
    window.ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
    settle(window);
}

/// Returns true if the window shows a hover text when the pointer is at this position.
fn explains(window: &mut Window, at: egui::Pos2) -> bool {
    window.event(egui::Event::PointerMoved(at));
    window.run_steps(3);
    let shown = window.ctx.memory(|memory| {
        let layers = memory.areas().visible_layer_ids();
        layers.iter().any(|layer| layer.order == egui::Order::Tooltip)
    });
    window.event(egui::Event::PointerGone);
    window.step();
    shown
}

/// Checks that all controls on screen have a hover text.
#[track_caller]
fn all_explained(window: &mut Window) {
    let mut controls = Vec::new();
    for role in CONTROLS {
        let of_role = window.query_all_by(|node| node.role() == role && !node.is_disabled());
        controls.extend(of_role.map(|node| {
            let label = node.accesskit_node().label().or(node.value());
            (node.rect(), label.unwrap_or_default())
        }));
    }
    controls.retain(|(_, label)| !KNOWN.contains(&&**label));
    assert!(controls.len() > 5, "{controls:?}");
    let mut silent = BTreeSet::new();
    for (rect, label) in controls {
        if !explains(window, rect.center()) {
            silent.insert(label);
        }
    }
    assert!(silent.is_empty(), "no hover text: {silent:#?}");
}

/// A new user opens three files in a window of 1280 × 800.
#[test]
fn the_first_screen_has_at_most_forty_five_controls() {
    let files = Files::new();
    let mut window = window_of(files.three(), Choices::default(), Preferences::default());
    window.set_size(Vec2::new(1280.0, 800.0));
    settle(&mut window);
    let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, Vec2::new(1280.0, 800.0));
    let n: usize = (CONTROLS.iter())
        .map(|role| {
            let of_role = window.query_all_by(|node| node.role() == *role);
            of_role.filter(|node| screen.contains_rect(node.rect())).count()
        })
        .sum();
    assert!((20..=45).contains(&n), "{n} controls");
}

#[test]
fn every_control_of_every_pane_has_a_hover_text() {
    let files = Files::new();
    let mut window = window(files.three());
    window.set_size(Vec2::new(1800.0, 2400.0));
    quick_to_explain(&mut window);
    show(&mut window, "settings");
    for title in ["Fixed lag", "Creep", "Play"] {
        click(&mut window, Role::CheckBox, title);
    }
    click(&mut window, Role::ComboBox, "Model type");
    click(&mut window, Role::Button, "Kernel");
    window.get_by_label("Full scale").click();
    settle(&mut window);
    for pane in loopscope::ui::all_panes() {
        maximize(&mut window, pane.key);
        all_explained(&mut window);
    }
    show(&mut window, "metrology");
    click(&mut window, Role::Button, "Definitions…");
    for field in ["Constant load within", "Zero load up to", "Reversal threshold Fx"] {
        let rect = window.get_by_role_and_label(Role::SpinButton, field).rect();
        assert!(explains(&mut window, rect.center()), "{field}");
    }
    window.key_press(Key::Escape);
    settle(&mut window);
    for mode in ["Cross-plot", "Drift"] {
        click(&mut window, Role::Button, mode);
        all_explained(&mut window);
    }
}

#[test]
fn every_control_of_the_import_window_has_a_hover_text() {
    let files = Files::new();
    let path = files.write("bare.csv", &importing::headerless(50));
    let mut window = importing::page(vec![path]);
    window.set_size(Vec2::new(1600.0, 1400.0));
    quick_to_explain(&mut window);
    assert!(state(&window).importing.is_some());
    // No pane with small controls is below the import page.
    maximize(&mut window, "errors");
    for tick in [
        "Computes the reference load of a known weight from the pose columns",
        "The reference load is in a separate file",
    ] {
        click(&mut window, Role::CheckBox, tick);
    }
    all_explained(&mut window);
    // The settings of the text lie over the page, whose controls they cover.
    window.get_by_label_contains("Read as: ").click();
    settle(&mut window);
    click(&mut window, Role::CheckBox, "sample rate");
    for tick in ["decimal comma", "header row", "units row", "sample rate"] {
        let rect = window.get_by_role_and_label(Role::CheckBox, tick).rect();
        assert!(explains(&mut window, rect.center()), "{tick}");
    }
}

#[test]
fn the_about_window_lists_version_and_licences() {
    let mut window = window(Vec::new());
    window.set_size(Vec2::new(1600.0, 1200.0));
    quick_to_explain(&mut window);
    menu(&mut window, "Help", "About LoopScope");
    assert!(has(&window, env!("CARGO_PKG_VERSION")));
    assert!(has(&window, "gui"), "features");
    assert!(has(&window, "Permission is hereby granted"));
    click(&mut window, Role::Button, "Crates");
    assert!(has(&window, "accesskit"));
    for button in ["Copy version", "MIT", "Crates"] {
        let rect = window.get_by_role_and_label(Role::Button, button).rect();
        assert!(explains(&mut window, rect.center()), "{button}");
    }
    window.check_accessibility();
}

#[test]
fn every_menu_item_has_a_hover_text() {
    let files = Files::new();
    let mut window = window(files.three());
    quick_to_explain(&mut window);
    for menu in ["File", "Edit", "View", "Help"] {
        click(&mut window, Role::Button, menu);
        let items = window.ctx.memory(|memory| {
            let layers = memory.areas().visible_layer_ids();
            let popup = layers.iter().find(|layer| layer.order == egui::Order::Foreground);
            popup.and_then(|layer| memory.area_rect(layer.id))
        });
        let items = items.unwrap_or_else(|| panic!("{menu} is not open"));
        let n = (items.height() / 22.0) as usize;
        assert!(n >= 2, "{menu}");
        let mut explained = 0;
        for at in 0..2 * n {
            let y = items.top() + (at as f32 + 0.5) * items.height() / (2 * n) as f32;
            explained += usize::from(explains(&mut window, egui::pos2(items.left() + 30.0, y)));
        }
        assert!(explained >= n, "{menu}: {explained} of {}", 2 * n);
        window.key_press(Key::Escape);
        settle(&mut window);
    }
}
