//! Examples of a job in use, as `--help` shows them.

/// Returns the text below the help: how the program is called, and what comes of it.
pub fn examples(examples: &[(&str, &str)]) -> String {
    let lines = examples.iter().map(|(line, what)| format!("\n  {line}\n      {what}"));
    "Examples:".to_owned() + &lines.collect::<String>()
}
