//! What `--help` shows of each job in use, and a test tries.

use clap::Command;

/// The job ("" for none), and how it is called, with what comes of it.
const EXAMPLES: &[(&str, &[(&str, &str)])] = &[
    (
        "",
        &[
            ("loopscope", "the window on the built-in sensor"),
            ("loopscope press_*.csv test.csv", "the window on these recordings"),
            ("loopscope work.json", "a session, or a calibration"),
        ],
    ),
    (
        "inspect",
        &[
            ("loopscope inspect press.csv", "what would be loaded"),
            ("loopscope inspect log.mat --write-map map.json", "a column map to correct by hand"),
        ],
    ),
    ("demo", &[("loopscope demo recordings", "simulated recordings to try the rest on")]),
    (
        "fit",
        &[
            (
                "loopscope fit --train day1.csv day2.csv --test day3.csv --export sensor.json",
                "conventional and with a look-back of 3 N and 15 s",
            ),
            (
                "loopscope fit --train day*.csv --play --ridge auto --export sensor.h --export sensor.json",
                "play operators, their strength by cross-validation; C code",
            ),
        ],
    ),
    (
        "check",
        &[(
            "loopscope check day1.csv day2.csv --mass 1,2,5",
            "is it enough, and which masses to hang next; exit code 3 if not",
        )],
    ),
    ("sensor", &[("loopscope sensor", "a description to fill in and keep as sensor.toml")]),
    (
        "report",
        &[
            (
                "loopscope report --train day1.csv day2.csv --test day3.csv --out report.html",
                "one page to print or to send",
            ),
            (
                "loopscope report --train recordings --sensor sensor.toml --limits limits.toml --out report.html",
                "with the sensor's identity; exit code 3 if a limit is exceeded",
            ),
        ],
    ),
    (
        "best",
        &[(
            "loopscope best --train day1.csv day2.csv day3.csv --minutes 5 --export sensor.json",
            "the model it proposes",
        )],
    ),
    (
        "compare",
        &[(
            "loopscope compare --train day1.csv day2.csv --test day3.csv --regressors linear,kernel --csv table.csv",
            "the paper's comparison of these",
        )],
    ),
    (
        "sweep",
        &[(
            "loopscope sweep --train day1.csv day2.csv --f-th 0:10:0.5 --t-th 1,5,15 --svg map.svg",
            "the map of errors over both thresholds",
        )],
    ),
    (
        "apply",
        &[
            ("loopscope apply sensor.json run.csv --out loads", "loads/run_loads.csv"),
            ("loopscope apply sensor.json log.csv --follow", "the rows of a log that grows"),
        ],
    ),
    (
        "metrology",
        &[(
            "loopscope metrology press.csv --full-scale 200,200,400 --csv figures.csv",
            "hysteresis, repeatability and more, in % of these loads",
        )],
    ),
    (
        "completions",
        &[
            (
                "loopscope completions bash > ~/.local/share/bash-completion/completions/loopscope",
                "for one user",
            ),
            ("loopscope completions zsh > ~/.zfunc/_loopscope", "where ~/.zfunc is in fpath"),
        ],
    ),
];

/// The job with its examples under its help.
pub fn shown(job: Command) -> Command {
    let text = of(job.get_name());
    job.after_help(text)
}

/// The examples of a job, as they stand under its help.
pub fn of(job: &str) -> String {
    let Some((_, lines)) = EXAMPLES.iter().find(|(name, _)| *name == job) else {
        return String::new();
    };
    let lines = lines.iter();
    let lines = lines.map(|(line, what)| format!("\n  {line}\n      {what}"));
    "Examples:".to_owned() + &lines.collect::<String>()
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory as _, Parser as _};

    use super::*;
    use crate::cli::Cli;

    #[test]
    fn every_example_is_understood_and_every_job_has_one() {
        for (job, lines) in EXAMPLES {
            for (line, _) in *lines {
                let words = line.split(" > ").next().unwrap().split(' ');
                let cli = Cli::try_parse_from(words).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(cli.job.is_some(), !job.is_empty(), "{line}");
                assert!(line.contains(job), "{line}");
            }
        }
        let command = Cli::command();
        for job in command.get_subcommands().filter(|job| !job.is_hide_set()) {
            let help = job.get_after_help().map(ToString::to_string);
            let named = help.is_some_and(|help| help.starts_with("Examples:"));
            assert!(named, "{} has no example", job.get_name());
        }
    }
}
