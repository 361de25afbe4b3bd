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

    /// Adds an element, with attributes of its own, that holds a text.
    pub fn element(&mut self, tag: &str, text: &str) {
        let name = tag.split(' ').next().unwrap_or(tag);
        self.raw(&format!("<{tag}>{}</{name}>", for_xml(text)));
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
        let titles = table
            .columns
            .iter()
            .map(|column| Cell::words(column.title()));
        let titles: Vec<Cell> = titles.collect();
        let mut notes = Vec::new();
        self.within("div", "class=\"wide\"", |page| {
            page.within("table", "", |page| {
                if !table.title.is_empty() {
                    page.element("caption", &table.title);
                }
                page.within("thead", "", |head| {
                    head.row("th", &table.columns, &titles, &mut notes);
                });
                page.within("tbody", "", |body| {
                    for row in &table.rows {
                        body.row("td", &table.columns, row, &mut notes);
                    }
                });
            });
        });
        for (at, reason) in notes.iter().enumerate() {
            self.element("p class=\"about\"", &format!("({}) {reason}.", at + 1));
        }
        if !table.note.is_empty() {
            self.element("p", &table.note);
        }
    }

    /// A row; where a reason has no room it is a number of those that stand below the table.
    fn row(&mut self, tag: &str, columns: &[Column], cells: &[Cell], notes: &mut Vec<String>) {
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
            let noted = cell
                .reason()
                .filter(|_| span == 1 && columns.len() > 3)
                .map(|reason| {
                    let known = notes.iter().position(|own| own == reason);
                    let at = known.unwrap_or_else(|| {
                        notes.push(reason.to_owned());
                        notes.len() - 1
                    });
                    format!("({})", at + 1)
                });
            let text = for_xml(noted.as_deref().or(cell.reason()).unwrap_or(&cell.text));
            let scope = if tag == "th" { " scope=\"col\"" } else { "" };
            row.push_str(&format!("<{tag}{scope}{attributes}>{text}</{tag}>"));
        }
        self.raw(&format!("{row}</tr>"));
    }
}
