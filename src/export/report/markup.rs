//! HTML that is well-formed XML too, so that any reader of either takes it.
//!
//! Guarantees: every text is escaped; a table's rows are as wide as its head.

use crate::report::{Align, Cell, Column, Table, Value};
use crate::shown::for_xml;

/// A page, or a part of one, that is being written.
#[derive(Default)]
pub(super) struct Markup(String);

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

    /// Adds a table below its title, its note below it.
    pub fn table(&mut self, table: &Table) {
        if !table.title.is_empty() {
            self.element("h3", &table.title);
        }
        let titles = table
            .columns
            .iter()
            .map(|column| Cell::words(column.title()));
        let titles: Vec<Cell> = titles.collect();
        self.within("div", "class=\"wide\"", |page| {
            page.within("table", "", |page| {
                page.within("thead", "", |head| head.row("th", &table.columns, &titles));
                page.within("tbody", "", |body| {
                    for row in &table.rows {
                        body.row("td", &table.columns, row);
                    }
                });
            });
        });
        if !table.note.is_empty() {
            self.element("p", &table.note);
        }
    }

    fn row(&mut self, tag: &str, columns: &[Column], cells: &[Cell]) {
        let mut row = String::from("<tr>");
        let mut cells = columns.iter().zip(cells).peekable();
        while let Some((column, cell)) = cells.next() {
            let mut span = 1;
            while cells
                .next_if(|(_, next)| next.value == Value::Continued)
                .is_some()
            {
                span += 1;
            }
            let attributes = match (cell.reason(), column.align) {
                (Some(_), _) => format!(" class=\"reason\" colspan=\"{span}\""),
                (None, Align::Left) => String::new(),
                (None, Align::Right) => " class=\"number\"".to_owned(),
                (None, Align::Anywhere) => " class=\"hash\"".to_owned(),
            };
            let text = for_xml(cell.reason().unwrap_or(&cell.text));
            row.push_str(&format!("<{tag}{attributes}>{text}</{tag}>"));
        }
        self.raw(&format!("{row}</tr>"));
    }
}
