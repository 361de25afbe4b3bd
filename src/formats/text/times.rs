//! Reads times that are written as dates and times of day.
//!
//! Guarantees: the text of a time is understood completely or not at all. Times are counted from 1970-01-01 without leap
//! seconds, as UNIX time is. Supported are the forms that loggers write: digits between marks, without names of months, and a
//! time zone only as an offset in digits.

use std::ops::RangeInclusive;

use jiff::civil::{self, Date, Time};

use crate::recording::units::TimeUnit;

const EPOCH: Date = civil::date(1970, 1, 1);
/// Marks between the parts of a date.
const MARKS: [char; 3] = ['-', '/', '.'];

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DateOrder {
    YearMonthDay,
    DayMonthYear,
    MonthDayYear,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeForm {
    /// Date, optionally with a time of day after `T` or a blank.
    Date(DateOrder),
    /// Time of day alone, `h:m` to `h:m:s.s`.
    TimeOfDay,
}

#[derive(Clone, Copy, Debug)]
pub enum TimeSpelling {
    Number(TimeUnit),
    Samples,
    Text(TimeForm),
}

/// Spellings that [`TimeSpelling::from_name`] understands, as a list for error messages.
pub const TIME_SPELLINGS: &str =
    "s, ms, us, ns, min, h, samples, iso8601, d.m.y, m/d/y, d/m/y, h:m:s";

impl TimeSpelling {
    pub fn from_name(unit: &str) -> Option<Self> {
        // `hh:mm:ss.fff` and `dd.mm.yyyy` are spelled with one letter each.
        let mut letters: Vec<char> = unit.trim().to_lowercase().chars().collect();
        letters.dedup();
        let short: String = letters.into_iter().collect();
        Some(match short.as_str() {
            "samples" | "sample" => Self::Samples,
            "unix" => Self::Number(TimeUnit::Seconds),
            "iso8601" | "iso 8601" => Self::Text(TimeForm::Date(DateOrder::YearMonthDay)),
            "d.m.y" | "d/m/y" => Self::Text(TimeForm::Date(DateOrder::DayMonthYear)),
            "m/d/y" => Self::Text(TimeForm::Date(DateOrder::MonthDayYear)),
            "y-m-d" | "y/m/d" => Self::Text(TimeForm::Date(DateOrder::YearMonthDay)),
            "h:m" | "h:m:s" | "h:m:s.f" | "h:m:s.s" | "h:m:s.m" => Self::Text(TimeForm::TimeOfDay),
            _ => Self::Number(TimeUnit::from_name(unit)?),
        })
    }
}

impl TimeForm {
    pub fn name(self) -> &'static str {
        match self {
            Self::Date(DateOrder::YearMonthDay) => "iso8601",
            Self::Date(DateOrder::DayMonthYear) => "d/m/y",
            Self::Date(DateOrder::MonthDayYear) => "m/d/y",
            Self::TimeOfDay => "h:m:s",
        }
    }

    /// Returns the first form of a time that fits all of these cells; `None` if no form fits or there are no cells.
    pub fn of_all<'a>(cells: impl Iterator<Item = &'a [u8]> + Clone) -> Option<Self> {
        // The order month-day is tried before day-month. Where both orders fit, the file comes from a program that offers
        // only month-day. With points between the parts, the day always comes first.
        let first = cells.clone().next()?.trim_ascii();
        let mut orders = [DateOrder::MonthDayYear, DateOrder::DayMonthYear];
        if first.iter().find(|byte| !byte.is_ascii_digit()) == Some(&b'.') {
            orders.reverse();
        }
        let [first, second] = orders.map(Self::Date);
        let forms = [Self::Date(DateOrder::YearMonthDay), first, second, Self::TimeOfDay];
        forms.into_iter().find(|form| form.fits(cells.clone()))
    }

    fn fits<'a>(self, mut cells: impl Iterator<Item = &'a [u8]>) -> bool {
        cells.all(|cell| self.secs(cell).is_some())
    }

    /// Returns this form of a date with day and month exchanged, if that form also fits these cells and gives other time
    /// differences.
    pub fn other_order<'a>(self, cells: impl Iterator<Item = &'a [u8]> + Clone) -> Option<Self> {
        let other = Self::Date(match self {
            Self::Date(DateOrder::MonthDayYear) => DateOrder::DayMonthYear,
            Self::Date(DateOrder::DayMonthYear) => DateOrder::MonthDayYear,
            _ => return None,
        });
        let shift = |cell| Some(other.secs(cell)? - self.secs(cell)?);
        let first = cells.clone().next().and_then(shift);
        let differs = cells.clone().any(|cell| shift(cell) != first);
        (differs && other.fits(cells)).then_some(other)
    }

    /// Returns the time in a cell: seconds since 1970 for a date, or since midnight for a time of day.
    pub fn secs(self, cell: &[u8]) -> Option<f64> {
        self.secs_since(0, cell)
    }

    /// Returns the time in a cell, as [`Self::secs`] does, minus `since` (s since 1970).
    pub fn secs_since(self, since: i64, cell: &[u8]) -> Option<f64> {
        let text = std::str::from_utf8(cell).ok()?.trim_ascii();
        let Self::Date(order) = self else {
            return time_of_day(text);
        };
        let is_of_day = |c: char| c.is_ascii_digit() || MARKS.contains(&c);
        let end = text.find(|c| !is_of_day(c)).unwrap_or(text.len());
        let (day, rest) = text.split_at(end);
        let midnight = (date(day, order)?.duration_since(EPOCH).as_secs() - since) as f64;
        if rest.is_empty() {
            return Some(midnight);
        }
        let time = rest.strip_prefix(['T', ',', ' ', '\t'])?.trim_ascii_start();
        let (time, zone) = time.split_at(time.find(['Z', '+', '-']).unwrap_or(time.len()));
        Some(midnight + (time_of_day(time)? - zone_secs(zone)?))
    }
}

fn digits(text: &str, n_digits: RangeInclusive<usize>) -> Option<i64> {
    let is_number = n_digits.contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    is_number.then(|| text.parse().ok())?
}

fn date(text: &str, order: DateOrder) -> Option<Date> {
    let mark = text.chars().find(|c| !c.is_ascii_digit())?;
    // A date may end with the same mark that stands between its parts, as in `5.3.2024.`.
    let parts: Vec<&str> = text.strip_suffix(mark).unwrap_or(text).split(mark).collect();
    let (year, month, day) = match (order, &parts[..]) {
        (DateOrder::YearMonthDay, [year, month, day]) if year.len() == 4 => (year, month, day),
        (DateOrder::DayMonthYear, [day, month, year]) => (year, month, day),
        (DateOrder::MonthDayYear, [month, day, year]) => (year, month, day),
        _ => return None,
    };
    let (month, day) = (digits(month, 1..=2)?, digits(day, 1..=2)?);
    // Years of two digits mean 1970 to 2069.
    let year = match (year.len(), digits(year, 2..=4)?) {
        (4, year) => year,
        (2, year @ 70..) => 1900 + year,
        (2, year) => 2000 + year,
        _ => return None,
    };
    Date::new(year as i16, month as i8, day as i8).ok()
}

/// Returns the seconds since midnight of a time of day: `h:m`, `h:m:s` or `h:m:s.s` (or with a comma or a colon), also with
/// AM or PM.
fn time_of_day(text: &str) -> Option<f64> {
    let (clock, half) = match text.split_at_checked(text.len().saturating_sub(2)) {
        Some((clock, half)) if half.eq_ignore_ascii_case("am") => (clock, Some(0)),
        Some((clock, half)) if half.eq_ignore_ascii_case("pm") => (clock, Some(12)),
        _ => (text, None),
    };
    let clock = if half.is_some() { clock.trim_ascii_end() } else { clock };
    let mut parts = clock.splitn(3, ':');
    let mut hour = digits(parts.next()?, 1..=2)?;
    let minute = digits(parts.next()?, 1..=2)?;
    let (whole, decimals) = match parts.next().map(|secs| (secs, secs.split_once(['.', ',', ':'])))
    {
        None => ("0", "0"),
        Some((_, Some(parts))) => parts,
        Some((whole, None)) => (whole, "0"),
    };
    let secs = digits(whole, 1..=2)?;
    let share = digits(decimals, 1..=18)? as f64 / 10_f64.powi(decimals.len() as i32);
    if let Some(hours) = half {
        (1..=12).contains(&hour).then_some(())?;
        hour = hour % 12 + hours;
    }
    // A leap second counts as the first second of the next minute, as in UNIX time. A day may end at 24:00.
    let is_time = secs <= 60 && Time::new(hour as i8, minute as i8, secs.min(59) as i8, 0).is_ok();
    let is_end = (hour, minute, secs) == (24, 0, 0) && share == 0.0;
    (is_time || is_end).then_some((hour * 3600 + minute * 60) as f64 + (secs as f64 + share))
}

/// Returns the offset of a time zone from UTC in seconds. The text is `Z`, `+h`, `+hh:mm` or `-hhmm`; without text, the time
/// is UTC.
fn zone_secs(text: &str) -> Option<f64> {
    if text.is_empty() || text == "Z" {
        return Some(0.0);
    }
    let sign = if text.starts_with('-') { -1.0 } else { 1.0 };
    let offset = text.strip_prefix(['+', '-'])?;
    let (hours, minutes) = match offset.split_once(':') {
        Some(parts) => parts,
        None if offset.len() > 2 => offset.split_at_checked(2)?,
        None => (offset, "00"),
    };
    let minutes = digits(hours, 1..=2)? * 60 + digits(minutes, 2..=2)?;
    Some(sign * (minutes * 60) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ISO: TimeForm = TimeForm::Date(DateOrder::YearMonthDay);
    const MONTH_FIRST: TimeForm = TimeForm::Date(DateOrder::MonthDayYear);
    const DAY_FIRST: TimeForm = TimeForm::Date(DateOrder::DayMonthYear);

    #[test]
    fn points_put_the_day_first_and_an_ambiguous_order_is_known() {
        let form = |cells: &[&'static str]| {
            let cells = cells.iter().map(|cell| cell.as_bytes());
            let form = TimeForm::of_all(cells.clone()).unwrap();
            (form, form.other_order(cells))
        };
        let night = ["03/04/2025 23:59", "04/04/2025 0:01"];
        assert_eq!(form(&night), (MONTH_FIRST, Some(DAY_FIRST)));
        assert_eq!(form(&["03.04.2025", "04.04.2025"]).0, DAY_FIRST);
        assert_eq!(form(&["03/13/2025", "03/14/2025"]), (MONTH_FIRST, None));
        assert_eq!(form(&["13/03/2025", "14/03/2025"]), (DAY_FIRST, None));
        let one_day = ["03/04/2025 10:00", "03/04/2025 10:01"];
        assert_eq!(form(&one_day), (MONTH_FIRST, None), "the intervals are equal in both orders");
        assert_eq!(form(&["2025-03-04", "2025-04-04"]), (ISO, None));
    }

    /// 2001-09-09 01:46:40 UTC is the UNIX time 1e9, 1969-12-31 23:59:59 is -1.
    #[test]
    fn all_spellings_of_a_time_give_the_same_seconds() {
        for (form, text) in [
            (ISO, "2001-09-09T01:46:40Z"),
            (ISO, "2001-09-09 01:46:40.000"),
            (ISO, "2001-09-09T01:46:40,0"),
            (ISO, "2001/9/9 1:46:40"),
            (ISO, "2001-09-09T03:46:40+02:00"),
            (ISO, "2001-09-08T19:16:40-0630"),
            (DAY_FIRST, "09.09.2001 01:46:40"),
            (DAY_FIRST, "9/9/01, 1:46:40"),
            (MONTH_FIRST, "09/09/2001 1:46:40 AM"),
        ] {
            assert_eq!(form.secs(text.as_bytes()), Some(1e9), "{text}");
        }
        assert_eq!(ISO.secs(b"1969-12-31 23:59:59"), Some(-1.0));
        assert_eq!(ISO.secs(b"2001-09-09"), Some(999_993_600.0));
        assert_eq!(MONTH_FIRST.secs(b"2/1/1970 12:00 AM"), Some(31.0 * 86_400.0));
        assert_eq!(DAY_FIRST.secs(b"2/1/1970 12:00 PM"), Some(1.5 * 86_400.0));
        assert_eq!(TimeForm::TimeOfDay.secs(b"01:02:03.25"), Some(3723.25));
        assert_eq!(TimeForm::TimeOfDay.secs(b"01:02:03:250"), Some(3723.25));
        assert_eq!(TimeForm::TimeOfDay.secs(b"24:00"), Some(86_400.0));
        assert_eq!(TimeForm::TimeOfDay.secs(b"23:59:60"), Some(86_400.0));
    }

    #[test]
    fn a_text_that_is_not_a_time_is_refused() {
        for text in [
            "",
            "x",
            "2001",
            "2001-13-01",
            "2001-02-29",
            "2001-09-09T",
            "2001-09-09T25:00",
            "2001-09-09 01:46:40 x",
            "2001-09-09 01:60",
            "9.9.2001 1:00",
            "2001-09.09",
            "2001-09-09T01:46:40+",
            "\u{664}001-09-09",
            "2001-09-09T24:59",
            "2001-09-09T23:59:61",
            "2001-09-09-01",
        ] {
            assert_eq!(ISO.secs(text.as_bytes()), None, "{text}");
        }
        assert_eq!(MONTH_FIRST.secs(b"13/1/2001"), None);
        assert_eq!(MONTH_FIRST.secs(b"1/1/2001 13:00 PM"), None);
        assert_eq!(TimeForm::TimeOfDay.secs(b"12"), None);
        assert_eq!(TimeForm::TimeOfDay.secs(b"24:59"), None);
    }

    #[test]
    fn all_cells_together_determine_the_form() {
        let form = |cells: &[&str]| TimeForm::of_all(cells.iter().map(|cell| cell.as_bytes()));
        assert_eq!(form(&["1/2/2001", "3/4/2001"]), Some(MONTH_FIRST));
        assert_eq!(form(&["1/2/2001", "13/4/2001"]), Some(DAY_FIRST));
        assert_eq!(form(&["2001-01-01T00:00:00"]), Some(ISO));
        assert_eq!(form(&["1:00", "x"]), None);
        assert_eq!(form(&[]), None);
    }
}
