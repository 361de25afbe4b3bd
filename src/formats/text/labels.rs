//! Lines with text between their numbers, such as `t:0.1 ax:1.2` and `Force = 3.2 N`, in files and from devices.

use std::ops::Range;

use super::{
    cells::{lines, number},
    times::TimeForm,
};
use crate::formats::column_name::is_any_unit;

/// Place of a number in the text of a line.
pub const NUMBER: char = '\0';

/// Returns the positions of the numbers of a line, whatever stands between them, and the other text of the line, with
/// [`NUMBER`] in the place of each. Digits in a word (`a0`, `0x13`, `12:00`) or in front of `:` or `=`, and a number behind a
/// separate minus, are text.
pub fn numbers_in(line: &str) -> (Vec<Range<usize>>, String) {
    let is_digit = |c: char| c.is_ascii_digit();
    let is_end = |c: char| c.is_ascii() && !c.is_alphanumeric() && !"+-.:=_/'^".contains(c);
    let (mut numbers, mut text, mut start) = (Vec::new(), String::new(), 0);
    for word in line.split_inclusive(is_end) {
        let (label, value) = word.split_at(word.rfind([':', '=']).map_or(0, |at| at + 1));
        let (number, unit) = value.split_at(number_length(value));
        let is_text = number.is_empty()
            || label.starts_with(is_digit)
            || unit.contains(is_digit)
            || text.trim_end().ends_with(['-', '−', '–']);
        text.push_str(label);
        if is_text {
            text.push_str(value);
        } else {
            let at = start + label.len();
            numbers.push(at..at + number.len());
            text.push(NUMBER);
            text.push_str(unit);
        }
        start += word.len();
    }
    (numbers, text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// Returns the length (bytes) of the number with which a text begins; 0 if it begins with none.
fn number_length(text: &str) -> usize {
    /// Maximum length of a number.
    const LONGEST: usize = 40;
    let ends_number =
        |n: &usize| text.as_bytes()[n - 1].is_ascii_digit() && text[..*n].parse::<f64>().is_ok();
    (1..=text.len().min(LONGEST)).rev().find(ends_number).unwrap_or(0)
}

/// Number of a line with the label in front of it and the unit behind it. A number or a time in front of the first label has
/// no label.
#[derive(Clone, Debug, PartialEq)]
pub struct Labelled {
    pub place: Range<usize>,
    pub label: String,
    pub unit: String,
}

/// Returns the numbers of a line in which each number has a label; `None` for any other line. A label ends with `:` or `=`. If
/// it is the only one of the line, it may also be plain words. The later ones of several numbers behind a label are counted.
pub fn labelled(line: &str) -> Option<Vec<Labelled>> {
    /// Maximum number of words in a label. A line with more is a message for people.
    const MOST_WORDS: usize = 6;
    let mut all: Vec<Labelled> = Vec::new();
    let mut start = 0;
    loop {
        let before = |c: char| [',', ';', '\t', ' ', '['].contains(&c);
        let rest = line[start..].trim_start_matches(before);
        let cell =
            rest.split(|c: char| before(c) || c == ']').next().unwrap_or_default().as_bytes();
        if number(cell).is_none() && TimeForm::of_all([cell].into_iter()).is_none() {
            break;
        }
        start = line.len() - rest.len() + cell.len();
        let (label, unit) = Default::default();
        all.push(Labelled { place: start - cell.len()..start, label, unit });
    }
    let is_alone = all.is_empty();
    let (places, text) = numbers_in(&line[start..]);
    let mut parts = text.split(NUMBER);
    let mut label = parts.next()?;
    let (mut of_several, mut n_of_label) = ("", 0);
    for (place, part) in places.iter().zip(parts) {
        // A list may begin with a bracket.
        label = label.trim_end_matches(['[', '(', ' ']);
        let is_only = is_alone && places.len() == 1 && !label.ends_with([',', ';']);
        let is_marked = label.ends_with([':', '=']) || is_only;
        let words = label.trim_end_matches([':', '=', ' ']);
        let words = words.trim_start_matches(|c: char| !c.is_alphanumeric());
        n_of_label += 1;
        if !words.is_empty() || n_of_label == 1 {
            let n_words = words.split(' ').count();
            if !is_marked || !words.contains(char::is_alphabetic) || n_words > MOST_WORDS {
                return None;
            }
            (of_several, n_of_label) = (words, 1);
        }
        let name = match n_of_label {
            1 => of_several.to_owned(),
            n => format!("{of_several} {n}"),
        };
        let after = part.trim_start();
        let (unit, next) = match after.split_once([',', ';', '|']) {
            Some(parts) => parts,
            None if place.end == places[places.len() - 1].end => (after, ""),
            None => {
                after.split_once(' ').filter(|(unit, _)| is_any_unit(unit)).unwrap_or(("", after))
            }
        };
        let unit = unit.trim_matches(['(', ')', '[', ']', ' ']);
        let unit = if unit.contains(' ') { "" } else { unit }.to_owned();
        let place = start + place.start..start + place.end;
        all.push(Labelled { place, label: name, unit });
        label = next;
    }
    (!places.is_empty()).then_some(all)
}

/// Maximum number of different labels in a file.
const MOST_LABELS: usize = 64;

/// Returns a text of lines with labels as a table whose cells are separated by tabs, with the labels as its header; `None` if
/// fewer than half of the first lines have labels. A sample may have several lines: it ends where a label occurs again.
pub fn table(text: &[u8]) -> Option<Vec<u8>> {
    const FIRST_LINES: usize = 200;
    const FEWEST_ROWS: usize = 3;
    let filled = || lines(text).filter(|line| !line.trim_ascii().is_empty());
    let rows = || filled().map(|line| cells(line).unwrap_or_default());
    let first: Vec<_> = rows().take(FIRST_LINES).collect();
    let n_labelled = first.iter().filter(|row| !row.is_empty()).count();
    // In a tree of names, such as messages of ROS, a label alone does not tell what a number is.
    let is_of_tree = |line: &[u8]| line.ends_with(b":") || line == b"---";
    let has_tree = filled().take(FIRST_LINES).any(|line| is_of_tree(line.trim_ascii_end()));
    if n_labelled < FEWEST_ROWS || 2 * n_labelled < first.len() || has_tree {
        return None;
    }
    let mut names: Vec<&str> = Vec::new();
    let all = || first.iter().flatten().map(|(name, _)| name.as_str());
    for name in all() {
        let is_usual = || all().filter(|other| *other == name).count() >= FEWEST_ROWS;
        if !names.contains(&name) && names.len() < MOST_LABELS && is_usual() {
            names.push(name);
        }
    }
    let header: Vec<&str> = names.iter().map(|name| name.trim_start_matches(NUMBER)).collect();
    let mut table = header.join("\t").into_bytes();
    let mut sample = vec![&b""[..]; names.len()];
    let mut end = |sample: &mut Vec<&[u8]>| {
        if sample.iter().any(|cell| !cell.is_empty()) {
            table.push(b'\n');
            table.extend(sample.join(&b'\t'));
            sample.fill(b"");
        }
    };
    for row in rows() {
        let place = |name: &String| names.iter().position(|other| other == name);
        let is_again = |(name, _): &(String, &[u8])| {
            !name.starts_with(NUMBER) && place(name).is_some_and(|at| !sample[at].is_empty())
        };
        if row.iter().any(is_again) {
            end(&mut sample);
        }
        for (name, cell) in &row {
            if let Some(at) = place(name).filter(|at| sample[*at].is_empty()) {
                sample[at] = *cell;
            }
        }
    }
    end(&mut sample);
    (!names.is_empty()).then_some(table)
}

/// Returns the numbers of a line with labels, each with its label and unit as the name of a column: `Force [N]`. The name of a
/// number or time in front of the first label begins with [`NUMBER`].
fn cells(line: &[u8]) -> Option<Vec<(String, &[u8])>> {
    let text = str::from_utf8(line).ok().filter(|line| !line.contains('"'))?;
    let cell = |(at, number): (usize, Labelled)| {
        let name = match (number.label.as_str(), number.unit.as_str()) {
            ("", _) => format!("{NUMBER}clock {}", at + 1),
            (label, "") => label.to_owned(),
            (label, unit) => format!("{label} [{unit}]"),
        };
        (name, &line[number.place])
    };
    Some(labelled(text.trim_end())?.into_iter().enumerate().map(cell).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(line: &str) -> Vec<String> {
        let cells = cells(line.as_bytes()).unwrap_or_default();
        cells.into_iter().map(|(name, _)| name.replace(NUMBER, "")).collect()
    }

    #[test]
    fn each_number_has_a_label_and_a_unit() {
        assert_eq!(names("t:0.1 ax:1.2"), ["t", "ax"]);
        assert_eq!(names("Force = 3.2 N"), ["Force [N]"]);
        assert_eq!(names("Weight 12.5 g\r"), ["Weight [g]"]);
        assert_eq!(names("Raw: -27536    Weight: 0.5 g"), ["Raw", "Weight [g]"]);
        assert_eq!(names("Load cell: 5 g, Raw = 7"), ["Load cell [g]", "Raw"]);
        assert_eq!(names("Force (N): [1 2.5  -3]"), ["Force (N)", "Force (N) 2", "Force (N) 3"]);
        assert_eq!(names("[12:00:01.5] Fz: 5 (N)"), ["clock 1", "Fz [N]"]);
        assert_eq!(names("2026-01-02 12:00:01,Weight: 5"), ["clock 1", "clock 2", "Weight"]);
        for other in ["ok,2.5", "0.1,ok,2.5", "1 2 3", "12:03:04 5", "a,b", "", "{\"t\":1}", "5 kg"]
        {
            assert_eq!(names(other), [""; 0], "{other}");
        }
    }

    #[test]
    fn a_sample_ends_where_a_label_occurs_again() {
        let text = b"Tare done\nS1: 1 g\nS1: -2.5 g\nS1: 3 g\n";
        assert_eq!(table(text).unwrap(), b"S1 [g]\n1\n-2.5\n3");
        let text = b"ADC:7\nFIR:1\n\nADC:8\nFIR:2\n\nADC:9\n\nADC:1\nFIR:3\n";
        assert_eq!(table(text).unwrap(), b"ADC\tFIR\n7\t1\n8\t2\n9\t\n1\t3");
        assert_eq!(table(b"t,S1\n0,1\n1,2\n"), None);
        assert_eq!(table(&b"force:\nx: 1\ntorque:\nx: 2\n".repeat(9)), None);
    }
}
