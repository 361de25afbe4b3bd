//! Makes text from files, such as names of gauges and recordings, safe to show.

use std::borrow::Cow;
use std::fmt::Display;
use std::path::Path;

/// Maximum length of a message in characters. The middle of a longer message is omitted, so that a terminal still shows earlier
/// messages.
const MESSAGE_CHARS: usize = 1200;
/// Number of characters of a long message that are kept before the omitted middle.
const START_CHARS: usize = 900;
/// Maximum number of names that a message lists. Further names are only counted.
const LISTED_NAMES: usize = 8;
/// Maximum number of characters that a message quotes from one text in a file.
const SHOWN_CHARS: usize = 40;

/// Returns the name of a file without its folder. Returns the path if the path has no file name.
pub(crate) fn file_name(path: &Path) -> Cow<'_, str> {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy()
}

/// Returns a number as it is written in full, or with an exponent if it would have very many digits.
pub(crate) fn number(number: f64) -> String {
    let is_short = number == 0.0 || !number.is_finite() || (1e-5..1e16).contains(&number.abs());
    if is_short { number.to_string() } else { format!("{number:e}") }
}

/// Returns the text on one line, with control characters and changes of writing direction replaced by their codes.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match is_hidden(c) {
            true => out.extend(c.escape_unicode()),
            false => out.push(c),
        }
    }
    Cow::Owned(out)
}

/// Returns true if a character is invisible but changes the display of other characters.
pub(crate) fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// Returns the text escaped for XML. Characters that XML does not allow are replaced by their codes.
pub(crate) fn for_xml(text: &str) -> String {
    let text = printable(text).replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}");
    quick_xml::escape::escape(text).into_owned()
}

/// Returns a message for a terminal or the window, on one line and of limited length.
pub(crate) fn message(text: &dyn Display) -> String {
    let text = text.to_string();
    let text = printable(&text);
    let n_chars = text.chars().count();
    if n_chars <= MESSAGE_CHARS {
        return text.into_owned();
    }
    let start = text.chars().take(START_CHARS);
    let end = text.chars().skip(n_chars - (MESSAGE_CHARS - START_CHARS));
    start.chain(['…']).chain(end).collect()
}

/// Returns a text from a file as a message quotes it: with control characters escaped and of limited length.
pub(crate) fn shown(text: &str) -> Cow<'_, str> {
    let is_plain = |c: char| c.escape_debug().len() == 1;
    if text.len() <= SHOWN_CHARS && text.chars().all(is_plain) {
        return Cow::Borrowed(text);
    }
    let mut escaped = text.chars().flat_map(char::escape_debug);
    let mut start: String = escaped.by_ref().take(SHOWN_CHARS).collect();
    if escaped.next().is_some() {
        start.push('…');
    }
    Cow::Owned(start)
}

/// Returns the first names from a file in one text, and the number of the names that are left out.
pub(crate) fn listed(names: &[String]) -> String {
    first(LISTED_NAMES, names.iter().map(|name| shown(name)))
}

/// Returns all items in one text, separated by `between`.
pub(crate) fn joined(between: &str, all: impl IntoIterator<Item = impl Display>) -> String {
    all.into_iter().map(|own| own.to_string()).collect::<Vec<_>>().join(between)
}

/// Returns the first `max` items in one text, separated by commas, and the number of further items.
pub(crate) fn first(max: usize, all: impl IntoIterator<Item = impl Display>) -> String {
    first_by(", ", max, all)
}

/// Returns the first `max` clauses in one text, separated by semicolons, and the number of further clauses.
pub(crate) fn first_clauses(max: usize, all: impl IntoIterator<Item = impl Display>) -> String {
    first_by("; ", max, all)
}

fn first_by(between: &str, max: usize, all: impl IntoIterator<Item = impl Display>) -> String {
    let mut all = all.into_iter();
    let first = joined(between, all.by_ref().take(max));
    let comma = between.trim_matches([',', ' ']);
    let more = and_more(max + all.count(), max);
    format!("{first}{}", more.map_or_else(String::new, |more| format!("{comma} {more}")))
}

/// Returns how many items a text leaves out, as `and 3 more`; `None` if it leaves out none.
pub(crate) fn and_more(all: usize, max: usize) -> Option<String> {
    (all > max).then(|| format!("and {} more", all - max))
}

/// Returns a number with its noun: `1 sample`, `2 samples`.
pub(crate) fn counted(n: usize, noun: &str) -> String {
    match (n, noun) {
        (1, _) | (_, "series") => format!("{n} {noun}"),
        (_, "trajectory") => format!("{n} trajectories"),
        _ => format!("{n} {noun}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_by_their_codes() {
        assert_eq!(printable("a\u{1b}[2J\r\n\u{202e}b 力"), "a\\u{1b}[2J\\u{d}\\u{a}\\u{202e}b 力");
        assert!(matches!(printable("Fx [N·m]"), Cow::Borrowed(_)));
    }

    #[test]
    fn very_large_and_small_numbers_have_an_exponent() {
        let text = [0.0, -12.5, 1e15, 1e270, -2.5e-9, f64::NAN].map(number);
        assert_eq!(text, ["0", "-12.5", "1000000000000000", "1e270", "-2.5e-9", "NaN"]);
    }

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(
            for_xml("a<b> & \"c\" 'd'\u{7}\u{ffff}N·m"),
            "a&lt;b&gt; &amp; &quot;c&quot; &apos;d&apos;\\u{7}\u{fffd}N·m"
        );
    }

    #[test]
    fn a_message_has_an_end() {
        assert_eq!(message(&"short"), "short");
        let long = message(&format!("begins {} ends", "力".repeat(20_000)));
        assert_eq!(long.chars().count(), MESSAGE_CHARS + 1);
        assert!(long.starts_with("begins") && long.ends_with("ends"));
    }

    #[test]
    fn text_from_files_is_escaped_and_short() {
        assert_eq!(shown("Fx µ"), "Fx µ");
        assert_eq!(shown("a\u{1b}[2J\n"), "a\\u{1b}[2J\\n");
        let long = shown(&"x".repeat(10_000)).into_owned();
        assert_eq!(long.chars().count(), SHOWN_CHARS + 1);
        assert!(shown(&"\0".repeat(10_000)).chars().count() <= SHOWN_CHARS + 1);
    }

    #[test]
    fn long_lists_end_in_a_count() {
        let names: Vec<_> = (0..10).map(|k| format!("c{k}")).collect();
        assert_eq!(listed(&names[..2]), "c0, c1");
        assert!(listed(&names).ends_with("c7 and 2 more"));
    }
}
