//! Examples below the `--help` text of a job.

/// Returns the text of the examples; each is a command and its effect.
pub fn examples(examples: &[(&str, &str)]) -> String {
    let lines = examples.iter().map(|(line, what)| format!("\n  {line}\n      {what}"));
    "Examples:".to_owned() + &lines.collect::<String>()
}
