//! The day on which a recording was made, and the source of this date.
//!
//! Guarantees: a date that may mean two different days is rejected. A date is clear if the year comes first, the month is
//! written as a word, or the day is above 12.

use std::fmt;
use std::str::FromStr;

use jiff::Timestamp;
use jiff::civil::Date;
use jiff::fmt::strtime::BrokenDownTime;
use serde::{Deserialize, Serialize};

/// Years that a date may have. A number outside this range is not read as a year.
pub(super) const YEARS: std::ops::RangeInclusive<i16> = 1970..=2099;
/// Words in a file header after which the date of the recording stands, in lower case and without punctuation.
const KEYS: [&str; 25] = [
    "date",
    "datum",
    "day",
    "date time",
    "datetime",
    "date and time",
    "timestamp",
    "recorded",
    "recorded on",
    "recorded at",
    "date recorded",
    "recording date",
    "date of recording",
    "start date",
    "start time",
    "started",
    "started at",
    "start",
    "test date",
    "date of test",
    "measured",
    "measured on",
    "measurement date",
    "date of measurement",
    "acquisition date",
];

/// A calendar day, written as 2024-05-03.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Day(Date);

/// Source of a recording's date. If several sources give a date, the first of them in this list is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the names of the sources say everything")]
pub enum DateSource {
    Entered,
    Header,
    Clock,
    Name,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Dated {
    pub day: Day,
    pub from: DateSource,
}

impl DateSource {
    /// Returns a description of the source for the user, such as `from the file header`.
    pub fn words(self) -> &'static str {
        match self {
            Self::Entered => "entered",
            Self::Header => "from the file header",
            Self::Clock => "from the time stamps in the file, in UTC",
            Self::Name => "from the name of the file or folder",
        }
    }
}

impl fmt::Display for Day {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl From<Day> for String {
    fn from(day: Day) -> Self {
        day.to_string()
    }
}

impl TryFrom<String> for Day {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl FromStr for Day {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unclear =
            || format!("{text:?} is not a clear date; write the date in the form 2024-05-03");
        Self::in_text(text).ok_or_else(unclear)
    }
}

impl Day {
    /// Returns the UTC day of a time in seconds since 1970.
    pub(crate) fn of_clock(secs: f64) -> Option<Self> {
        let time = Timestamp::from_second(secs as i64).ok()?;
        Some(Self(time.to_zoned(jiff::tz::TimeZone::UTC).date()))
    }

    /// Returns the day in a text, if the text contains exactly one.
    pub(crate) fn in_text(text: &str) -> Option<Self> {
        let words = words(text);
        let mut found = (0..words.len()).filter_map(|at| day_at(&words, at));
        let first = found.next()?;
        found.all(|other| other == first).then_some(Self(first))
    }

    /// Returns the day of the recording, if this line of a file header gives it.
    pub(crate) fn in_header(line: &str) -> Option<Self> {
        let line = line.trim_start_matches(['#', '%', '/', ';', '"', '\'', ' ', '\t', '\u{feff}']);
        let is_end = |c: char| matches!(c, ':' | '=' | ',' | ';' | '\t') || c.is_ascii_digit();
        let (key, value) = line.split_at(line.find(is_end)?);
        let key = key.to_lowercase();
        let key: Vec<&str> =
            key.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
        KEYS.contains(&&*key.join(" ")).then_some(())?;
        Self::in_text(value)
    }
}

/// A run of digits or of letters in a text, and the characters between it and the run before.
pub(super) struct Word<'a> {
    before: &'a str,
    pub text: &'a str,
}

impl Word<'_> {
    fn year(&self) -> Option<i16> {
        let is_year = self.text.len() == 4;
        self.text.parse().ok().filter(|year| is_year && YEARS.contains(year))
    }

    fn part(&self) -> Option<i8> {
        (self.text.len() <= 2).then(|| self.text.parse().ok()).flatten()
    }

    fn month(&self) -> Option<i8> {
        let name = if self.text.eq_ignore_ascii_case("sept") { "sep" } else { self.text };
        ["%B", "%b"].iter().find_map(|form| BrokenDownTime::parse(form, name).ok()?.month())
    }

    /// Returns true if exactly one separator of a date, such as `-`, stands between this word and the word before it.
    fn follows(&self) -> bool {
        matches!(self.before, "-" | "/" | "." | "_")
    }
}

pub(super) fn words(text: &str) -> Vec<Word<'_>> {
    let kind = |c: char| (c.is_ascii_digit(), c.is_alphabetic());
    let mut words = Vec::new();
    let mut end = 0;
    while let Some(skipped) = text[end..].find(char::is_alphanumeric) {
        let (from, start) = (end, end + skipped);
        let of = text[start..].chars().next().map(kind);
        let length = text[start..].find(|c| Some(kind(c)) != of);
        end = length.map_or(text.len(), |length| start + length);
        words.push(Word { before: &text[from..start], text: &text[start..end] });
    }
    words
}

/// Returns the date that starts at the word with index `at`. If this word is the name of a month, the day may also stand
/// before it.
fn day_at(words: &[Word<'_>], at: usize) -> Option<Date> {
    let word = &words[at];
    let next = |by: usize| words.get(at + by);
    let follows = |by: usize| next(by).filter(|word| word.follows());
    if let Some(month) = word.month() {
        let before = at.checked_sub(1).map(|at| &words[at]);
        let (first, second) = (before.and_then(Word::part), next(1).and_then(Word::part));
        // A number that belongs to a time of day, such as 01 in 10:22:01 May 3 2024, is not the day of a date.
        let is_clock = |at: usize| {
            words[at].before.ends_with(':')
                || words.get(at + 1).is_some_and(|own| own.before.starts_with(':'))
        };
        let first = first.filter(|_| !is_clock(at - 1));
        let second = second.filter(|_| !is_clock(at + 1));
        let day = match (first, second) {
            (Some(day), None) | (None, Some(day)) => day,
            _ => return None,
        };
        let year = match before.and_then(Word::year) {
            Some(year) => year,
            None => words[at + 1..].iter().find_map(Word::year)?,
        };
        return Date::new(year, month, day).ok();
    }
    if !word.text.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    if let Some(year) = word.year()
        && let (Some(month), Some(day)) = (follows(1), follows(2))
        && month.before == day.before
    {
        return Date::new(year, month.part()?, day.part()?).ok();
    }
    if word.text.len() == 8 && word.before != "." && next(1).is_none_or(|own| own.before != ".") {
        let number: i32 = word.text.parse().ok()?;
        let (year, rest) = ((number / 10_000) as i16, number % 10_000);
        let date = Date::new(year, (rest / 100) as i8, (rest % 100) as i8);
        return date.ok().filter(|date| YEARS.contains(&date.year()));
    }
    let (one, other, year) = (word.part()?, follows(1)?, follows(2)?);
    if other.before != year.before {
        return None;
    }
    let (other, year) = (other.part()?, year.year()?);
    match (one, other) {
        (13.., 1..=12) => Date::new(year, other, one).ok(),
        (1..=12, 13..) => Date::new(year, one, other).ok(),
        (one, other) if one == other => Date::new(year, one, one).ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn day(text: &str) -> Option<String> {
        Day::in_text(text).map(|day| day.to_string())
    }

    #[test]
    fn dates_are_read_in_many_notations() {
        for text in [
            "2024-05-03",
            "2024/5/3",
            "2024.05.03 10:22:01",
            "2024-05-03T10:22:01+02:00",
            "20240503",
            "run_20240503_2",
            "press 2024_05_03b",
            "3 May 2024",
            "03-May-2024",
            "May 3, 2024",
            "Fri May  3 10:22:01 2024",
            "2024-May-03",
            "03MAY2024",
        ] {
            assert_eq!(day(text).as_deref(), Some("2024-05-03"), "{text}");
        }
        for text in ["13/05/2024", "05/13/2024", "13.05.2024"] {
            assert_eq!(day(text).as_deref(), Some("2024-05-13"), "{text}");
        }
        assert_eq!(day("04/04/2024").as_deref(), Some("2024-04-04"));
    }

    #[test]
    fn ambiguous_dates_are_rejected() {
        for text in [
            "",
            "03/05/2024",
            "03.05.2024",
            "13/05/24",
            "2024-13-01",
            "2023-02-29",
            "12345678",
            "99999999",
            "0.20240503",
            "run 2024",
            "may 2024",
            "2024-05-03 to 2024-05-04",
            "192.168.10.12",
            "10:22:01",
        ] {
            assert_eq!(day(text), None, "{text}");
        }
        assert!("03/05/2024".parse::<Day>().is_err());
    }

    #[test]
    fn only_the_date_of_the_recording_is_read_from_a_header() {
        let day = |line| Day::in_header(line).map(|day| day.to_string());
        for line in [
            "# date: 2024-05-03",
            "Date,2024/05/03",
            "Date\t2024/05/03\t2024/05/03",
            "\"Start Time\";\"2024-05-03 10:22\"",
            "// Recorded on 2024-05-03",
            "% Date of test = 3 May 2024",
        ] {
            assert_eq!(day(line).as_deref(), Some("2024-05-03"), "{line}");
        }
        for line in [
            "# calibration date: 2024-05-03",
            "# next calibration due: 2024-05-03",
            "date,S1,S2,Fz",
            "# 2024-05-03",
            "Date,03/05/2024",
        ] {
            assert_eq!(day(line), None, "{line}");
        }
    }
}
