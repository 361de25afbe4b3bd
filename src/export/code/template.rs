//! Templates of source code: names are replaced, lines are left out or repeated.
//!
//! `@{name}` in a line stands for a text. A line `@if name` (or `@if !name`) keeps the lines up to its `@end` only where
//! the flag is set (or is not); `@for name` repeats them for each scope of a list, whose names come before those outside.
//! Guarantees: templates are this program's own, so a name that is not there is a broken invariant and panics in the tests.

use std::collections::BTreeMap;

/// What a name in a template stands for.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Text(String),
    Flag(bool),
    List(Vec<Scope>),
}

/// Names and what they stand for.
pub(super) type Scope = BTreeMap<&'static str, Value>;

/// The template with everything filled in.
pub(super) fn render(template: &str, scope: &Scope) -> String {
    let lines: Vec<&str> = template.lines().collect();
    let mut out = String::new();
    block(&lines, &[scope], &mut out);
    out
}

fn block(lines: &[&str], scopes: &[&Scope], out: &mut String) {
    let mut at = 0;
    while at < lines.len() {
        let Some((keyword, name)) = opening(lines[at]) else {
            line(lines[at], scopes, out);
            at += 1;
            continue;
        };
        let end = at + 1 + closing(&lines[at + 1..]);
        let inner = &lines[at + 1..end];
        match (keyword, find(scopes, name.trim_start_matches('!'))) {
            ("if", Value::Flag(is_set)) => {
                if *is_set != name.starts_with('!') {
                    block(inner, scopes, out);
                }
            }
            ("for", Value::List(list)) => {
                for scope in list {
                    block(inner, &[&[scope], scopes].concat(), out);
                }
            }
            _ => panic!("{name} is of another kind than {keyword} needs"),
        }
        at = end + 1;
    }
}

/// The keyword and the name of a line that opens a block.
fn opening(line: &str) -> Option<(&str, &str)> {
    let words = line.trim_start().strip_prefix('@')?;
    let (keyword, name) = words.split_once(' ')?;
    matches!(keyword, "if" | "for").then_some((keyword, name))
}

/// How many lines stand before the `@end` of the block that is open.
fn closing(lines: &[&str]) -> usize {
    let mut depth = 0;
    for (at, line) in lines.iter().enumerate() {
        if opening(line).is_some() {
            depth += 1;
        } else if line.trim() == "@end" {
            if depth == 0 {
                return at;
            }
            depth -= 1;
        }
    }
    panic!("a block of a template has no end")
}

fn line(line: &str, scopes: &[&Scope], out: &mut String) {
    let mut rest = line;
    while let Some((before, after)) = rest.split_once("@{") {
        let (name, after) = after
            .split_once('}')
            .expect("a name in a template is closed");
        let Value::Text(text) = find(scopes, name) else {
            panic!("{name} is no text")
        };
        out.push_str(before);
        out.push_str(text);
        rest = after;
    }
    out.push_str(rest);
    out.push('\n');
}

fn find<'a>(scopes: &[&'a Scope], name: &str) -> &'a Value {
    scopes
        .iter()
        .find_map(|scope| scope.get(name))
        .unwrap_or_else(|| panic!("a template names {name}, which is not there"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_replaced_and_blocks_kept_left_out_and_repeated() {
        let text = |text: &str| Value::Text(text.to_owned());
        let layers = ["a", "b"].map(|name| Scope::from([("name", text(name))]));
        let scope = Scope::from([
            ("yes", Value::Flag(true)),
            ("no", Value::Flag(false)),
            ("name", text("outside")),
            ("layers", Value::List(layers.to_vec())),
        ]);
        let template = "@if no\n  @if yes\nx\n  @end\n@end\n@{name}\n@for layers\n@if !no\n<@{name}@{name}>\n@end\n@end";
        assert_eq!(render(template, &scope), "outside\n<aa>\n<bb>\n");
    }

    /// What a user writes is a value, and values are not templates.
    #[test]
    fn a_value_is_not_read_as_a_template() {
        let scope = Scope::from([("name", Value::Text("@{name}\n@end".to_owned()))]);
        assert_eq!(render("@{name}", &scope), "@{name}\n@end\n");
    }
}
