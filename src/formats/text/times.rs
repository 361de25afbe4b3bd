//! Times that are written as dates and times of day.
//!
//! Guarantees: a text is understood whole or not at all; what is understood is the time that the text names, counted
//! from 1970-01-01 without leap seconds, as UNIX time is.
//!
//! Loggers write a handful of forms, all of them digits between marks, so they are read here directly: no names of
//! months, no time zones but an offset in digits.

use crate::recording::units::TimeUnit;

const SECS_PER_DAY: f64 = 86_400.0;

/// In which order a date names its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DateOrder {
    YearMonthDay,
    DayMonthYear,
    MonthDayYear,
}

/// How a cell names a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimeForm {
    /// A date, and if it is there a time of day after `T` or a blank.
    Date(DateOrder),
    /// A time of day alone, `h:m` to `h:m:s.s`.
    TimeOfDay,
}

/// The unit of a time column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimeSpelling {
    /// A number of these.
    Number(TimeUnit),
    /// A number of samples.
    Samples,
    /// No number.
    Text(TimeForm),
}

/// Spellings that [`TimeSpelling::from_name`] understands, for messages.
pub(crate) const TIME_SPELLINGS: &str =
    "s, ms, us, ns, samples, iso8601, d.m.y, m/d/y, d/m/y, h:m:s";

impl TimeSpelling {
    /// The spelling that a unit names; `None` for an unknown one.
    pub(crate) fn from_name(unit: &str) -> Option<Self> {
        Some(match unit.trim().to_lowercase().as_str() {
            "samples" | "sample" => Self::Samples,
            "unix" => Self::Number(TimeUnit::Seconds),
            "iso8601" | "iso 8601" => Self::Text(TimeForm::Date(DateOrder::YearMonthDay)),
            "d.m.y" | "d/m/y" => Self::Text(TimeForm::Date(DateOrder::DayMonthYear)),
            "m/d/y" => Self::Text(TimeForm::Date(DateOrder::MonthDayYear)),
            "h:m:s" => Self::Text(TimeForm::TimeOfDay),
            _ => Self::Number(TimeUnit::from_name(unit)?),
        })
    }
}

impl TimeForm {
    /// The name that [`TimeSpelling::from_name`] reads.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Date(DateOrder::YearMonthDay) => "iso8601",
            Self::Date(DateOrder::DayMonthYear) => "d/m/y",
            Self::Date(DateOrder::MonthDayYear) => "m/d/y",
            Self::TimeOfDay => "h:m:s",
        }
    }

    /// The first form in which all of these cells are times; `None` if there is none, or no cell.
    pub(crate) fn of_all<'a>(cells: impl Iterator<Item = &'a [u8]> + Clone) -> Option<Self> {
        // Month and day first: where both orders fit, files of the one kind come from programs that offer no other. With
        // points between them nobody writes the month first.
        let has_points =
            |cell: &[u8]| cell.iter().find(|byte| !byte.is_ascii_digit()) == Some(&b'.');
        let either = match cells
            .clone()
            .next()
            .is_some_and(|cell| has_points(cell.trim_ascii()))
        {
            true => [DateOrder::DayMonthYear, DateOrder::MonthDayYear],
            false => [DateOrder::MonthDayYear, DateOrder::DayMonthYear],
        };
        let forms = [
            Self::Date(DateOrder::YearMonthDay),
            Self::Date(either[0]),
            Self::Date(either[1]),
            Self::TimeOfDay,
        ];
        let mut forms = forms.into_iter();
        let is_some = cells.clone().next().is_some();
        forms.find(|form| is_some && form.fits(cells.clone()))
    }

    fn fits<'a>(self, mut cells: impl Iterator<Item = &'a [u8]>) -> bool {
        cells.all(|cell| self.secs(cell).is_some())
    }

    /// The other order of day and month, where these cells are dates in it too, and other times apart.
    pub(crate) fn other_order<'a>(
        self,
        cells: impl Iterator<Item = &'a [u8]> + Clone,
    ) -> Option<Self> {
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

    /// The time in seconds that a cell names, since 1970 or since midnight.
    pub(crate) fn secs(self, cell: &[u8]) -> Option<f64> {
        let mut text = Text(cell.trim_ascii());
        let secs = match self {
            Self::TimeOfDay => text.time_of_day()?,
            Self::Date(order) => {
                let days = text.date(order)? as f64;
                let time = if text.0.is_empty() {
                    0.0
                } else {
                    text.between_date_and_time()?;
                    text.time_of_day()? - text.zone_secs()?
                };
                days * SECS_PER_DAY + time
            }
        };
        text.0.is_empty().then_some(secs)
    }
}

/// What is left to be understood.
struct Text<'a>(&'a [u8]);

impl Text<'_> {
    fn take(&mut self, byte: u8) -> bool {
        let is_next = self.0.first() == Some(&byte);
        if is_next {
            self.0 = &self.0[1..];
        }
        is_next
    }

    /// A number of `digits` digits, and how many there were.
    fn number(&mut self, digits: std::ops::RangeInclusive<usize>) -> Option<(i64, usize)> {
        let is_digit = |byte: &&u8| byte.is_ascii_digit();
        let n_digits = self
            .0
            .iter()
            .take(*digits.end())
            .take_while(is_digit)
            .count();
        if n_digits < *digits.start() {
            return None;
        }
        let (number, rest) = self.0.split_at(n_digits);
        self.0 = rest;
        let value = |sum, digit: &u8| sum * 10 + i64::from(digit - b'0');
        Some((number.iter().fold(0, value), n_digits))
    }

    /// Days since 1970-01-01.
    fn date(&mut self, order: DateOrder) -> Option<i64> {
        let (first, n_digits) = self.number(1..=4)?;
        let mark = *self.0.first()?;
        if !b"-/.".contains(&mark) {
            return None;
        }
        let mut next = |digits| self.take(mark).then(|| self.number(digits)).flatten();
        let (year, month, day) = match order {
            DateOrder::YearMonthDay => {
                let (month, day) = (next(1..=2)?.0, next(1..=2)?.0);
                (n_digits == 4).then_some((first, month, day))?
            }
            DateOrder::DayMonthYear => {
                let (month, (year, year_digits)) = (next(1..=2)?.0, next(2..=4)?);
                (full_year(year, year_digits)?, month, first)
            }
            DateOrder::MonthDayYear => {
                let (day, (year, year_digits)) = (next(1..=2)?.0, next(2..=4)?);
                (full_year(year, year_digits)?, first, day)
            }
        };
        let is_date = (1..=12).contains(&month) && (1..=days_of(year, month)).contains(&day);
        is_date.then(|| days_since_1970(year, month, day))
    }

    fn between_date_and_time(&mut self) -> Option<()> {
        let blanks = self.0.len() - self.0.trim_ascii_start().len();
        self.0 = self.0.trim_ascii_start();
        (blanks > 0 || self.take(b'T') || self.take(b',')).then_some(())?;
        self.0 = self.0.trim_ascii_start();
        Some(())
    }

    /// `h:m`, `h:m:s` or `h:m:s.s` (also with a comma), with or without AM or PM.
    fn time_of_day(&mut self) -> Option<f64> {
        let mut hour = self.number(1..=2)?.0;
        self.take(b':').then_some(())?;
        let minute = self.number(1..=2)?.0;
        let mut secs = 0.0;
        if self.take(b':') {
            secs = self.number(1..=2)?.0 as f64;
            if self.take(b'.') || self.take(b',') {
                let (decimals, n_digits) = self.number(1..=18)?;
                secs += decimals as f64 / 10_f64.powi(n_digits as i32);
            }
        }
        let half = self.0.trim_ascii_start();
        if let Some(afternoon) =
            half.get(..2)
                .and_then(|half| match half.to_ascii_lowercase().as_slice() {
                    b"am" => Some(false),
                    b"pm" => Some(true),
                    _ => None,
                })
        {
            (1..=12).contains(&hour).then_some(())?;
            hour = hour % 12 + if afternoon { 12 } else { 0 };
            self.0 = &half[2..];
        }
        // A leap second is the first second of the next minute, as UNIX time has it.
        let is_time = hour <= 24 && minute < 60 && secs < 61.0;
        is_time.then_some((hour * 3600 + minute * 60) as f64 + secs)
    }

    /// The offset from UTC in seconds: `Z`, `+h`, `+hh:mm`, `-hhmm`; none is UTC.
    fn zone_secs(&mut self) -> Option<f64> {
        if self.0.is_empty() || self.take(b'Z') {
            return Some(0.0);
        }
        let sign = if self.take(b'-') {
            -1.0
        } else {
            self.take(b'+').then_some(1.0)?
        };
        let hours = self.number(1..=2)?.0;
        let minutes = if self.take(b':') || !self.0.is_empty() {
            self.number(2..=2)?.0
        } else {
            0
        };
        Some(sign * (hours * 3600 + minutes * 60) as f64)
    }
}

/// Two digits are a year from 1970 to 2069.
fn full_year(year: i64, n_digits: usize) -> Option<i64> {
    match n_digits {
        4 => Some(year),
        2 => Some(if year < 70 { 2000 + year } else { 1900 + year }),
        _ => None,
    }
}

fn days_of(year: i64, month: i64) -> i64 {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days since 1970-01-01 in the Gregorian calendar: years are counted from March on, so that the leap day comes last
/// and the months before a date have `(153 m + 2) / 5` days.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let leap_days = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    // 719,468 days lie between 0000-03-01 and 1970-01-01.
    365 * year + leap_days + (153 * month + 2) / 5 + (day - 1) - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    const ISO: TimeForm = TimeForm::Date(DateOrder::YearMonthDay);
    const MONTH_FIRST: TimeForm = TimeForm::Date(DateOrder::MonthDayYear);
    const DAY_FIRST: TimeForm = TimeForm::Date(DateOrder::DayMonthYear);

    /// Counting one day after the other gives the same numbers as the formula.
    #[test]
    fn points_put_the_day_first_and_what_fits_both_ways_is_known() {
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
        assert_eq!(
            form(&one_day),
            (MONTH_FIRST, None),
            "times apart are the same"
        );
        assert_eq!(form(&["2025-03-04", "2025-04-04"]), (ISO, None));
    }

    #[test]
    fn every_day_of_four_centuries_follows_the_one_before() {
        let mut expected = 0;
        for year in 1970..2400 {
            for month in 1..=12 {
                for day in 1..=days_of(year, month) {
                    assert_eq!(days_since_1970(year, month, day), expected);
                    expected += 1;
                }
            }
        }
        assert_eq!(expected, 157_054); // 430 · 365 + 104 leap days
    }

    /// 2001-09-09 01:46:40 UTC is the UNIX time 1e9, 1969-12-31 23:59:59 is -1.
    #[test]
    fn all_ways_to_write_a_time_give_the_same() {
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
        assert_eq!(
            MONTH_FIRST.secs(b"2/1/1970 12:00 AM"),
            Some(31.0 * 86_400.0)
        );
        assert_eq!(DAY_FIRST.secs(b"2/1/1970 12:00 PM"), Some(1.5 * 86_400.0));
        assert_eq!(TimeForm::TimeOfDay.secs(b"01:02:03.25"), Some(3723.25));
    }

    #[test]
    fn what_is_no_time_is_none() {
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
        ] {
            assert_eq!(ISO.secs(text.as_bytes()), None, "{text}");
        }
        assert_eq!(MONTH_FIRST.secs(b"13/1/2001"), None);
        assert_eq!(MONTH_FIRST.secs(b"1/1/2001 13:00 PM"), None);
        assert_eq!(TimeForm::TimeOfDay.secs(b"12"), None);
    }

    #[test]
    fn cells_settle_their_form_together() {
        let form = |cells: &[&str]| TimeForm::of_all(cells.iter().map(|cell| cell.as_bytes()));
        assert_eq!(form(&["1/2/2001", "3/4/2001"]), Some(MONTH_FIRST));
        assert_eq!(form(&["1/2/2001", "13/4/2001"]), Some(DAY_FIRST));
        assert_eq!(form(&["2001-01-01T00:00:00"]), Some(ISO));
        assert_eq!(form(&["1:00", "x"]), None);
        assert_eq!(form(&[]), None);
    }
}
