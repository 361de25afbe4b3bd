//! Escapes texts that come from files, such as names of gauges, for comments, identifiers, XML and YAML.

use crate::shown::{for_xml, is_hidden, printable};

/// Returns the text as [`printable`], changed so that it neither begins nor ends a C comment and contains no trigraph.
pub(super) fn for_block_comment(text: &str) -> String {
    kept_apart(&printable(text), |pair| matches!(pair, ('*', '/') | ('/', '*') | ('?', '?')))
}

/// Returns the text with a blank inserted between each two characters for which `must_not_meet` is true.
fn kept_apart(text: &str, must_not_meet: fn((char, char)) -> bool) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if out.chars().next_back().is_some_and(|before| must_not_meet((before, c))) {
            out.push(' ');
        }
        out.push(c);
    }
    out
}

/// Returns the text as [`printable`], in ASCII characters only.
pub(super) fn ascii(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '·' => out.push('.'),
            '°' => out.push_str("deg"),
            c if c.is_ascii() => out.push(c),
            c => out.extend(c.escape_unicode()),
        }
    }
    out
}

/// Returns an identifier that is valid in every language of exported code, made from the name of a file.
pub(super) fn identifier(name: &str) -> String {
    let mut out: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(40).collect();
    if !out.starts_with(|c: char| c.is_ascii_alphabetic()) {
        out.insert_str(0, "cal_");
    }
    out
}

/// Names that Python, its standard library, NumPy, C or Rust already use, and names of the self-test files. An exported
/// library with one of these names would hide the original.
const TAKEN: &str = include_str!("templates/taken_names.txt");

/// Returns an [`identifier`] for an exported library that is none of the [`TAKEN`] names, also on file systems that ignore
/// case.
pub(super) fn library_name(name: &str) -> String {
    let name = identifier(name);
    let small = name.to_ascii_lowercase();
    if TAKEN.split_whitespace().any(|word| word == small) { format!("cal_{name}") } else { name }
}

/// Returns the text as [`for_xml`] for an XML comment, in which two hyphens must not be adjacent.
pub(super) fn for_xml_comment(text: &str) -> String {
    let mut out = kept_apart(&for_xml(text), |pair| pair == ('-', '-'));
    if out.ends_with('-') {
        out.push(' ');
    }
    out
}

/// Returns the text as a double-quoted YAML string, including the quotes.
pub(super) fn for_yaml(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if is_hidden(c) => out.push_str(&format!("\\U{:08x}", u32::from(c))),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_ends_a_comment_or_a_line() {
        let nasty = "a*/ b /*/ ??/ \n\r\u{1b}[31m \u{202e}x 力";
        let safe = for_block_comment(nasty);
        for unwanted in ["*/", "/*", "??", "\n", "\r", "\u{1b}", "\u{202e}"] {
            assert!(!safe.contains(unwanted), "{safe}");
        }
        assert!(safe.contains("\\u{1b}[31m") && safe.ends_with("力"));
        assert_eq!(for_xml_comment("a--> <b-"), "a- -&gt; &lt;b- ");
    }

    #[test]
    fn a_file_name_is_converted_to_an_identifier() {
        assert_eq!(identifier("left arm-2"), "left_arm_2");
        assert_eq!(identifier("2nd"), "cal_2nd");
        assert_eq!(identifier("_x"), "cal__x");
        assert_eq!(identifier(""), "cal_");
        assert_eq!(identifier("力"), "cal__");
    }

    #[test]
    fn a_library_hides_nothing_of_the_system() {
        for name in ["math", "NumPy", "csv", "stdio", "class", "selftest"] {
            assert_eq!(library_name(name), format!("cal_{name}"));
        }
        assert_eq!(library_name("left arm"), "left_arm");
        assert_eq!(library_name("mathematics"), "mathematics");
    }

    #[test]
    fn quotes_and_hidden_characters_are_escaped() {
        assert_eq!(for_yaml("a\"b\\c\n力"), "\"a\\\"b\\\\c\\U0000000a力\"");
    }
}
