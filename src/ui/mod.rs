//! The window: the only place that knows egui. One file a panel; [`Shell`] ties them to the state and to the threads.

mod blocks_panel;
mod calibration_pane;
mod compare_pane;
mod dialogs;
mod errors_pane;
mod looking;
mod loops_pane;
mod menu;
mod metrology_pane;
mod notices_panel;
mod numbers;
mod palette;
mod plots;
mod recordings_panel;
mod regressor_panel;
mod settings_panel;
mod shell;
mod start;
mod status_line;
mod study_worker;
mod thresholds_pane;
mod trace_panes;

pub use dialogs::{Dialogs, NativeDialogs, Reply};
pub use shell::Shell;
pub use start::open_window;
