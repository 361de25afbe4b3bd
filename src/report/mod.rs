//! What is shown, as plain data, and how it becomes text and pictures.

pub mod figure;
