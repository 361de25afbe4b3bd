//! Random actions of the monkey.

use std::path::PathBuf;

use egui::accesskit::Role;
use egui::{
    Event, Key, Modifiers, MouseWheelUnit, Order, PointerButton, Pos2, Rect, Vec2, pos2, vec2,
};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use loopscope::ui;
use loopscope::ui::{Command, Shell, TimeMove, Workspace};

/// Pseudo-random generator with a seed (splitmix64).
#[derive(Clone)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    pub fn chance(&mut self, chance: f64) -> bool {
        self.share() < chance
    }

    pub fn of<'a, T>(&mut self, these: &'a [T]) -> &'a T {
        &these[self.below(these.len())]
    }
}

#[derive(Default)]
pub struct Act {
    pub printed: String,
    pub frames: Vec<Vec<Event>>,
    pub size: Option<Vec2>,
    pub command: Option<Command>,
    pub dropped: Option<PathBuf>,
    pub closes: bool,
    pub log_grows: bool,
    pub rests: bool,
}

const CONTROLS: [Role; 10] = [
    Role::Button,
    Role::CheckBox,
    Role::RadioButton,
    Role::Slider,
    Role::SpinButton,
    Role::ComboBox,
    Role::TextInput,
    Role::MultilineTextInput,
    Role::Tab,
    Role::GraphicsObject,
];

const KEYS: [Key; 31] = [
    Key::ArrowUp,
    Key::ArrowDown,
    Key::ArrowLeft,
    Key::ArrowRight,
    Key::Tab,
    Key::Tab,
    Key::Enter,
    Key::Enter,
    Key::Space,
    Key::Escape,
    Key::Backspace,
    Key::Delete,
    Key::Home,
    Key::End,
    Key::PageUp,
    Key::PageDown,
    Key::Plus,
    Key::Minus,
    Key::Comma,
    Key::Period,
    Key::A,
    Key::B,
    Key::T,
    Key::Z,
    Key::Num0,
    Key::F1,
    Key::F2,
    Key::F4,
    Key::F5,
    Key::F9,
    Key::F10,
];

/// Keys that are pressed with Ctrl.
const SHORTCUTS: [Key; 21] = [
    Key::A,
    Key::C,
    Key::E,
    Key::O,
    Key::P,
    Key::Q,
    Key::S,
    Key::V,
    Key::X,
    Key::Z,
    Key::Z,
    Key::Z,
    Key::Num1,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
    Key::Plus,
];

const TEXTS: [&str; 26] = [
    "0",
    "1",
    "-1",
    "3.5",
    "1e308",
    "-1e-308",
    "1e999",
    "NaN",
    "inf",
    "0,5",
    "0.1,0.2,0.4",
    "1,,2",
    "",
    " ",
    "abc",
    "ä€𝄞\u{202e}x",
    "../",
    "C:\\x",
    "out",
    "out.csv",
    "\"quoted\", and more",
    "two\nlines",
    "999999999999999999999",
    "0x10",
    "1 2 3",
    "é\u{301}",
];

/// Words that are typed into the palette.
const WORDS: [&str; 16] = [
    "train",
    "test",
    "tare",
    "undo",
    "redo",
    "show",
    "zoom",
    "play",
    "model",
    "report",
    "pane",
    "copy",
    "larger",
    "close",
    "built",
    "find best",
];

/// Source of the random actions.
pub struct Hands {
    random: Random,
}

impl Hands {
    pub fn new(seed: u64) -> Self {
        Self { random: Random::new(seed) }
    }

    /// Returns an action that is possible in this window.
    pub fn act(&mut self, window: &Harness<'_, Option<Shell>>, files: &[PathBuf]) -> Act {
        let mut act = match self.random.below(100) {
            0..38 => self.click(window),
            38..52 => self.drag(window),
            52..60 => self.wheel(window),
            60..74 => self.keys(),
            74..80 => self.write(window),
            80..84 => self.palette(),
            84..88 => self.resize(),
            88..94 => self.command(),
            94 => Act {
                dropped: Some(self.random.of(files).clone()),
                printed: "drop a file".to_owned(),
                frames: vec![Vec::new()],
                ..Act::default()
            },
            95 if self.random.chance(0.1) => Act {
                closes: true,
                printed: "close the window".to_owned(),
                frames: vec![Vec::new()],
                ..Act::default()
            },
            95..97 => Act {
                log_grows: true,
                printed: "the log grows".to_owned(),
                frames: vec![Vec::new()],
                ..Act::default()
            },
            _ => Act { rests: true, printed: "rest".to_owned(), ..Act::default() },
        };
        let idle = self.random.below(3);
        act.frames.extend(std::iter::repeat_n(Vec::new(), idle));
        act
    }

    /// Returns true if the monkey waits for a long time after this action.
    pub fn is_patient(&mut self) -> bool {
        self.random.chance(0.05)
    }

    fn modifiers(&mut self) -> Modifiers {
        match self.random.below(12) {
            0 => Modifiers::SHIFT,
            1 => Modifiers::COMMAND,
            2 => Modifiers::ALT,
            3 => Modifiers::COMMAND | Modifiers::SHIFT,
            _ => Modifiers::NONE,
        }
    }

    /// Returns a random position and the name of the widget there, or "nothing". Floating widgets are preferred.
    fn place(&mut self, window: &Harness<'_, Option<Shell>>) -> (Pos2, String) {
        let screen = window.ctx.content_rect();
        let anywhere = |random: &mut Random, rect: Rect| {
            pos2(
                rect.min.x + rect.width() * random.share() as f32,
                rect.min.y + rect.height() * random.share() as f32,
            )
        };
        if self.random.chance(0.12) {
            let at = anywhere(&mut self.random, screen);
            return (at, "nothing".to_owned());
        }
        let wants_control = self.random.chance(0.8);
        let points = window.ctx.pixels_per_point();
        let nodes: Vec<(Rect, String)> = window
            .query_all_by(|node| !wants_control || CONTROLS.contains(&node.role()))
            .filter_map(|node| {
                let bounds = node.accesskit_node().bounding_box()?;
                let [left, top, right, bottom] =
                    [bounds.x0, bounds.y0, bounds.x1, bounds.y1].map(|at| at as f32 / points);
                let rect =
                    Rect::from_min_max(pos2(left, top), pos2(right, bottom)).intersect(screen);
                rect.is_positive().then(|| {
                    let own = node.accesskit_node();
                    let name = own.label().or(own.value()).unwrap_or_default();
                    (rect, format!("{:?} {name:.40}", own.role()))
                })
            })
            .collect();
        if nodes.is_empty() {
            return (anywhere(&mut self.random, screen), "nothing".to_owned());
        }
        let mut chosen = self.random.of(&nodes).clone();
        if self.random.chance(0.6) {
            for _ in 0..30 {
                let layer = window.ctx.layer_id_at(chosen.0.center());
                if layer.is_some_and(|layer| layer.order != Order::Background) {
                    break;
                }
                chosen = self.random.of(&nodes).clone();
            }
        }
        let at = match self.random.chance(0.5) {
            true => chosen.0.center(),
            false => anywhere(&mut self.random, chosen.0),
        };
        (at, chosen.1)
    }

    fn button(&mut self) -> PointerButton {
        match self.random.below(10) {
            0 | 1 => PointerButton::Secondary,
            2 => PointerButton::Middle,
            _ => PointerButton::Primary,
        }
    }

    fn click(&mut self, window: &Harness<'_, Option<Shell>>) -> Act {
        let (pos, name) = self.place(window);
        let (button, modifiers) = (self.button(), self.modifiers());
        let mut frames = vec![vec![Event::PointerMoved(pos)]];
        let times = if self.random.chance(0.12) { 2 } else { 1 };
        for _ in 0..times {
            for pressed in [true, false] {
                frames.push(vec![Event::PointerButton { pos, button, pressed, modifiers }]);
            }
        }
        Act {
            printed: format!("{times} x {button:?} {}at {pos:?}: {name}", held(modifiers)),
            frames,
            ..Act::default()
        }
    }

    fn drag(&mut self, window: &Harness<'_, Option<Shell>>) -> Act {
        let (from, name) = self.place(window);
        let to = match self.random.chance(0.5) {
            true => self.place(window).0,
            false => {
                from + vec2(self.random.share() as f32, self.random.share() as f32) * 200.0
                    - Vec2::splat(100.0)
            }
        };
        let (button, modifiers) = (self.button(), self.modifiers());
        let press = |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers };
        let mut frames = vec![vec![Event::PointerMoved(from)], vec![press(from, true)]];
        let moves = 2 + self.random.below(8);
        for at in 1..=moves {
            frames.push(vec![Event::PointerMoved(from + (to - from) * (at as f32 / moves as f32))]);
        }
        match self.random.chance(0.05) {
            true => frames.push(vec![Event::PointerGone]),
            false => frames.push(vec![press(to, false)]),
        }
        Act {
            printed: format!("drag {button:?} {}from {from:?} to {to:?}: {name}", held(modifiers)),
            frames,
            ..Act::default()
        }
    }

    fn wheel(&mut self, window: &Harness<'_, Option<Shell>>) -> Act {
        let (pos, name) = self.place(window);
        let modifiers = self.modifiers();
        let delta = vec2(0.0, *self.random.of(&[-300.0, -60.0, 60.0, 300.0, 3000.0]));
        let delta = if self.random.chance(0.2) { delta.yx() } else { delta };
        let turn = Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta,
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers,
        };
        let times = 1 + self.random.below(6);
        let mut frames = vec![vec![Event::PointerMoved(pos)]];
        frames.extend(std::iter::repeat_n(vec![turn], times));
        Act {
            printed: format!("wheel {delta:?} {}at {pos:?}: {name}", held(modifiers)),
            frames,
            ..Act::default()
        }
    }

    fn keys(&mut self) -> Act {
        let (modifiers, key) = match self.random.chance(0.3) {
            true => {
                let more = if self.random.chance(0.2) { Modifiers::SHIFT } else { Modifiers::NONE };
                (Modifiers::COMMAND | more, *self.random.of(&SHORTCUTS))
            }
            false => {
                let held = match self.random.below(6) {
                    0 => Modifiers::SHIFT,
                    1 => Modifiers::ALT,
                    _ => Modifiers::NONE,
                };
                (held, *self.random.of(&KEYS))
            }
        };
        let times = if self.random.chance(0.2) { 10 } else { 1 };
        Act {
            printed: format!("{times} x key {}{key:?}", held(modifiers)),
            frames: std::iter::repeat_n(press(modifiers, key), times).collect(),
            ..Act::default()
        }
    }

    /// Types into a clicked field, or into the widget with the focus.
    fn write(&mut self, window: &Harness<'_, Option<Shell>>) -> Act {
        let text = *self.random.of(&TEXTS);
        let mut act = if self.random.chance(0.7) { self.click(window) } else { Act::default() };
        if self.random.chance(0.7) {
            act.frames.push(press(Modifiers::COMMAND, Key::A));
        }
        let event = match self.random.chance(0.8) {
            true => Event::Text(text.to_owned()),
            false => Event::Paste(text.to_owned()),
        };
        act.frames.push(vec![event]);
        if self.random.chance(0.6) {
            act.frames.push(press(
                Modifiers::NONE,
                *self.random.of(&[Key::Enter, Key::Tab, Key::Escape]),
            ));
        }
        act.printed = format!("write {text:?} after {}", act.printed);
        act
    }

    fn palette(&mut self) -> Act {
        let word = *self.random.of(&WORDS);
        let mut frames = vec![press(Modifiers::COMMAND, Key::P)];
        frames.push(vec![Event::Text(word.to_owned())]);
        let down = self.random.below(6);
        frames.extend(std::iter::repeat_n(press(Modifiers::NONE, Key::ArrowDown), down));
        frames.push(press(Modifiers::NONE, Key::Enter));
        Act { printed: format!("palette {word:?}, {down} down"), frames, ..Act::default() }
    }

    fn resize(&mut self) -> Act {
        let (min, max) = if self.random.chance(0.1) { (40.0, 400.0) } else { (800.0, 2400.0) };
        let mut side = || (min + (max - min) * self.random.share()) as f32;
        let size = vec2(side(), 0.6 * side());
        Act {
            printed: format!("resize to {size:?}"),
            size: Some(size),
            frames: vec![Vec::new()],
            ..Act::default()
        }
    }

    fn command(&mut self) -> Act {
        let panes: Vec<_> = ui::all_panes().collect();
        let pane = *self.random.of(&panes);
        let command = match self.random.below(6) {
            0 => Command::Show(self.random.of(&Workspace::ALL).0),
            1 | 2 => Command::ToggleMaximized(Some(pane)),
            3 => Command::Time(*self.random.of(&[
                TimeMove::Fit,
                TimeMove::Zoom(1e-3),
                TimeMove::Zoom(0.5),
                TimeMove::TogglePlay,
                TimeMove::PutCursor(0),
                TimeMove::PutCursor(1),
                TimeMove::Step(1),
            ])),
            _ => Command::ShowPane(pane),
        };
        Act {
            printed: format!("{command:?}").chars().take(120).collect(),
            command: Some(command),
            frames: vec![Vec::new()],
            ..Act::default()
        }
    }
}

fn press(modifiers: Modifiers, key: Key) -> Vec<Event> {
    let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
    vec![
        Event::ModifiersChanged(modifiers),
        event(true),
        event(false),
        Event::ModifiersChanged(Modifiers::NONE),
    ]
}

fn held(modifiers: Modifiers) -> String {
    match modifiers {
        Modifiers::NONE => String::new(),
        held => format!("{} ", egui::ModifierNames::NAMES.format(&held, false)),
    }
}
