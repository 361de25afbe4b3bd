//! The window: the only place that knows egui. One file a panel; [`Shell`] ties them to the state and to the threads.

mod actions;
mod appearance;
mod blocks_panel;
mod calibration_pane;
mod command_palette;
mod compare_pane;
mod context_menu;
mod dialogs;
mod equation;
mod errors_pane;
mod help;
mod import_window;
mod looking;
mod loops_pane;
mod menu;
mod metrology_pane;
mod notices_panel;
mod numbers;
mod palette;
mod picture;
mod plots;
mod recordings_panel;
mod recovery;
mod regressor_panel;
mod settings_panel;
mod shell;
mod start;
mod status_line;
mod study_worker;
mod thresholds_pane;
mod tour;
mod trace_panes;
mod workspace;

pub use dialogs::{Dialogs, NativeDialogs, Reply, SaveAs};
pub use shell::Shell;
pub use start::open_window;
