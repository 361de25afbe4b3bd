//! The window without a display or a graphics card.

use std::time::Duration;

use loopscope::engine::{Action, Edit};
use loopscope::questions::View;
use loopscope::recording::RecordingSet;
use loopscope::ui::{NativeDialogs, Shell};

const SIZE: egui::Vec2 = egui::vec2(1600.0, 900.0);

pub struct Screen {
    context: egui::Context,
    pub shell: Shell,
}

impl Screen {
    /// Opens the window with the recordings of `set`, and waits until everything is drawn.
    pub fn showing(set: RecordingSet) -> Self {
        let context = egui::Context::default();
        let shell = Shell::new(&context, Vec::new(), Box::new(NativeDialogs));
        let mut screen = Self { context, shell };
        // The built-in sensor loads first. The recordings of `set` must replace the built-in sensor before the measurement.
        screen.settle();
        screen.shell.send(Edit::Replace(std::sync::Arc::new(set)));
        screen.shell.send(Action::Show(View::All));
        screen.settle();
        screen
    }

    /// Draws frames until no background work runs.
    pub fn settle(&mut self) {
        self.frame(None);
        while self.shell.is_busy() {
            std::thread::sleep(Duration::from_millis(5));
            self.frame(None);
        }
        self.frame(None);
        assert!(self.shell.engine().analysis().is_some(), "{:?}", self.shell.engine().problem());
    }

    pub fn frame(&mut self, pointer: Option<egui::Pos2>) {
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, SIZE)),
            events: pointer.map(egui::Event::PointerMoved).into_iter().collect(),
            ..Default::default()
        };
        let mut output = self.context.run_ui(input, |ui| self.shell.frame(ui));
        output.textures_delta.clear();
        let shapes = std::mem::take(&mut output.shapes);
        std::hint::black_box(self.context.tessellate(shapes, output.pixels_per_point));
    }
}
