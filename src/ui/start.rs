//! Opens the window, or prints in one line why the window cannot open.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

use crate::{
    engine::PreferencesFile,
    panicked::panic_message,
    ui::{dialogs::NativeDialogs, shell::Shell, status_line},
};

const WITHOUT_DISPLAY: &str =
    "without a display, use `loopscope fit`, `apply` or `demo` (see `loopscope --help`)";

/// Parts of winit's messages about a library that is missing at run time.
const LIBRARY_IS_MISSING: [&str; 3] = ["shared librar", "could not be loaded", "XKBNotFound"];

const APP_ID: &str = "loopscope";

struct Window {
    shell: Shell,
    preferences: Option<PreferencesFile>,
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        if let Some(secs) = frame.info().cpu_usage {
            status_line::note_frame(ui.ctx(), secs);
        }
        self.shell.frame(ui);
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        self.shell.end();
    }

    fn save(&mut self, _storage: &mut dyn eframe::Storage) {
        if let Some(file) = &mut self.preferences
            && let Err(error) = file.write(&self.shell.preferences())
        {
            log::warn!("preferences: {error}");
        }
    }
}

/// Opens the window with `files`, or with the built-in simulated sensor if there are none. Returns when the user closes the
/// window.
pub fn open_window(files: Vec<PathBuf>) -> ExitCode {
    if let Some(missing) = missing_display() {
        eprintln!("loopscope: {missing}; {WITHOUT_DISPLAY}");
        return ExitCode::FAILURE;
    }
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("LoopScope")
            .with_app_id(APP_ID)
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([800.0, 500.0])
            .with_icon(icon())
            .with_drag_and_drop(true),
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(move |creation| {
        let context = creation.egui_ctx.clone();
        let folder = eframe::storage_dir(APP_ID);
        let kept = folder.as_deref().and_then(PreferencesFile::read_in);
        let shell = Shell::new(&context, files, Box::new(NativeDialogs)).finding_thresholds();
        let mut shell = shell.with_preferences(kept.unwrap_or_default());
        let mut preferences = None;
        if let Some(folder) = folder {
            preferences = Some(PreferencesFile::new(&folder, shell.preferences()));
            shell = shell.with_recovery(&folder);
        }
        Ok(Box::new(Window { shell, preferences }))
    });
    // If a library of the window system is missing, winit panics. One line explains the cause better than a backtrace. Panics
    // of other threads are shown in the window.
    let panicked = Arc::new(Mutex::new(None));
    let seen = Arc::clone(&panicked);
    std::panic::set_hook(Box::new(move |info| {
        if let Ok(mut seen) = seen.lock() {
            let place = info.location().map(ToString::to_string).unwrap_or_default();
            *seen = Some(format!("{} ({place})", panic_message(info.payload())));
        }
    }));
    let run = || eframe::run_native("LoopScope", options, create);
    let (what, why) = match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(())) => return ExitCode::SUCCESS,
        Ok(Err(error)) => ("cannot open", error.to_string()),
        Err(_) => {
            let message = panicked.lock().ok().and_then(|mut seen| seen.take());
            ("failed", message.unwrap_or_default())
        }
    };
    eprintln!("loopscope: the window {what}: {}", with_way_out(&why));
    ExitCode::FAILURE
}

/// Returns the icon of the program. A test ensures that the image can be read.
fn icon() -> egui::IconData {
    eframe::icon_data::from_png_bytes(include_bytes!("../../assets/loopscope.png"))
        .unwrap_or_default()
}

/// Returns the reason why this machine cannot open a window, if there is one.
fn missing_display() -> Option<&'static str> {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let is_unix_desktop = cfg!(all(unix, not(target_os = "macos")));
    let any = ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(is_set);
    (is_unix_desktop && !any).then_some(
        "there is no display to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is set)",
    )
}

/// Returns one line with the reason why the window cannot open, and with the remedy.
fn with_way_out(why: &str) -> String {
    let why = why.split_whitespace().collect::<Vec<_>>().join(" ");
    let is_missing = LIBRARY_IS_MISSING.iter().any(|words| why.contains(words));
    let mut install = "";
    if is_missing && cfg!(target_os = "linux") {
        install = "install the window's libraries (Debian, Ubuntu: `sudo apt-get install libgl1 libxcursor1 libxi6 libxkbcommon-x11-0`); ";
    }
    format!("{why}; {install}{WITHOUT_DISPLAY}")
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(target_os = "linux")]
    fn a_library_that_is_missing_is_named_with_its_package() {
        for why in [
            "os error:\n Failed to load one of xlib's shared libraries",
            "Library libxkbcommon-x11.so could not be loaded.",
        ] {
            let told = super::with_way_out(why);
            assert!(told.contains("libxkbcommon-x11-0") && !told.contains('\n'), "{told}");
        }
        assert!(!super::with_way_out("no OpenGL").contains("apt-get"));
    }

    #[test]
    fn the_icon_is_a_picture() {
        let icon = super::icon();
        assert_eq!((icon.width, icon.height), (256, 256));
        assert_eq!(icon.rgba.len(), 256 * 256 * 4);
    }
}
