//! Fills the templates of source code and reports that are part of this program.

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, UndefinedBehavior, Value};

use crate::shown::for_xml;

/// Returns the template engine, for which a missing value is an error. With `trims`, lines that hold only a template tag give
/// no output line.
pub(super) fn environment(trims: bool) -> Environment<'static> {
    let mut templates = Environment::new();
    let mut syntax = SyntaxConfig::builder();
    syntax.trim_blocks(trims).lstrip_blocks(trims);
    let syntax = syntax.keep_trailing_newline(true).build();
    templates.set_syntax(syntax.expect("the usual delimiters differ"));
    templates.set_undefined_behavior(UndefinedBehavior::Strict);
    templates
}

pub(super) fn filled(template: &str, values: Value) -> String {
    let filled = environment(true).render_str(template, values);
    filled.expect("the templates are this program's own")
}

/// Fills a template of HTML or XML. Every text is escaped, unless the program marks it as [safe](Value::from_safe_string).
pub(crate) fn filled_markup(template: &str, values: Value) -> String {
    let mut templates = environment(true);
    templates.set_formatter(|out, _, value| {
        let text = value.to_string();
        let text = if value.is_safe() { text } else { for_xml(&text) };
        Ok(out.write_str(&text)?)
    });
    let filled = templates.render_str(template, values);
    filled.expect("the templates are this program's own")
}
