//! HTML that is well-formed XML too, so that any reader of either takes it.
//!
//! Guarantees: every text is escaped; a table's rows are as wide as its head.

use crate::shown::for_xml;

/// A page, or a part of one, that is being written.
#[derive(Default)]
pub(super) struct Markup(String);

/// A cell of a table.
#[derive(Clone, Debug)]
pub(super) enum Cell {
    /// Words.
    Text(String),
    /// A number, to the right.
    Number(String),
    /// Hexadecimal digits, which may break anywhere.
    Hash(String),
    /// Why there are no numbers, over this many columns.
    Reason(String, usize),
}

impl Cell {
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// A number where there is one, else a dash.
    pub fn number(number: Option<String>) -> Self {
        Self::Number(number.unwrap_or_else(|| "–".to_owned()))
    }
}

impl Markup {
    pub fn into_string(self) -> String {
        self.0
    }

    /// Adds markup as it is: this program's own, never text from a file.
    pub fn raw(&mut self, markup: &str) {
        self.0.push_str(markup);
        self.0.push('\n');
    }

    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.raw(&for_xml(text));
    }

    /// Adds an element that holds a text.
    pub fn element(&mut self, tag: &str, text: &str) {
        self.raw(&format!("<{tag}>{}</{tag}>", for_xml(text)));
    }

    /// Adds what `content` writes between the tags.
    pub fn within(&mut self, tag: &str, attributes: &str, content: impl FnOnce(&mut Self)) {
        let space = if attributes.is_empty() { "" } else { " " };
        self.raw(&format!("<{tag}{space}{attributes}>"));
        content(self);
        self.raw(&format!("</{tag}>"));
    }

    /// Adds a part of the page under its heading.
    pub fn section(&mut self, id: &str, class: &str, title: &str, content: impl FnOnce(&mut Self)) {
        let attributes = match class {
            "" => format!("id=\"{id}\""),
            class => format!("id=\"{id}\" class=\"{class}\""),
        };
        self.within("section", &attributes, |page| {
            page.element("h2", title);
            content(page);
        });
    }

    /// Adds a table; the cells of `head` say how the columns stand.
    pub fn table(&mut self, head: &[Cell], rows: impl IntoIterator<Item = Vec<Cell>>) {
        self.within("div", "class=\"wide\"", |page| {
            page.within("table", "", |table| {
                table.within("thead", "", |table| table.row("th", head));
                table.within("tbody", "", |table| {
                    for row in rows {
                        table.row("td", &row);
                    }
                });
            });
        });
    }

    fn row(&mut self, tag: &str, cells: &[Cell]) {
        let cells: String = cells
            .iter()
            .map(|cell| {
                let (attributes, text) = match cell {
                    Cell::Text(text) => (String::new(), text),
                    Cell::Number(text) => (" class=\"number\"".to_owned(), text),
                    Cell::Hash(text) => (" class=\"hash\"".to_owned(), text),
                    Cell::Reason(text, columns) => {
                        (format!(" class=\"reason\" colspan=\"{columns}\""), text)
                    }
                };
                format!("<{tag}{attributes}>{}</{tag}>", for_xml(text))
            })
            .collect();
        self.raw(&format!("<tr>{cells}</tr>"));
    }
}
