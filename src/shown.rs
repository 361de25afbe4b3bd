//! Text from files, such as names of gauges and recordings, made harmless where it is shown.

use std::borrow::Cow;
use std::fmt::Display;

/// Of longer messages the middle is left out: nobody reads on, and a terminal would scroll away what came before.
const MESSAGE_CHARS: usize = 1200;
/// So much of it stands before what is left out.
const START_CHARS: usize = 900;

/// The text on one line without anything that cannot be seen: control and direction marks become their codes.
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

/// Whether a character is not seen itself, but changes how others are.
pub(crate) fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// Text between the tags or quotes of XML; what XML cannot hold at all becomes its code in words.
pub(crate) fn for_xml(text: &str) -> String {
    let text = printable(text).replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}");
    quick_xml::escape::escape(text).into_owned()
}

/// A message as a person gets it, in a terminal or in the window: [`printable`], and not without end.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_upon_a_terminal_or_a_reader_is_shown_by_its_code() {
        assert_eq!(
            printable("a\u{1b}[2J\r\n\u{202e}b 力"),
            "a\\u{1b}[2J\\u{d}\\u{a}\\u{202e}b 力"
        );
        assert!(matches!(printable("Fx [N·m]"), Cow::Borrowed(_)));
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
}
