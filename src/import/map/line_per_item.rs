//! Formats JSON so that it is easy to read: objects are indented, and each item of a list is on one line.

use std::io::{self, Write};

use serde_json::ser::Formatter;

#[derive(Debug, Default)]
pub(super) struct LinePerItem {
    depth: usize,
    open_lists: usize,
}

impl LinePerItem {
    fn new_line<W: ?Sized + Write>(&self, out: &mut W) -> io::Result<()> {
        write!(out, "\n{:1$}", "", 2 * self.depth)
    }

    fn between<W: ?Sized + Write>(&self, out: &mut W, first: bool, lists: usize) -> io::Result<()> {
        if !first {
            out.write_all(b",")?;
        }
        if self.open_lists <= lists {
            self.new_line(out)
        } else if first {
            Ok(())
        } else {
            out.write_all(b" ")
        }
    }
}

impl Formatter for LinePerItem {
    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth += 1;
        out.write_all(if self.open_lists > 0 { b"{ " } else { b"{" })
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if self.open_lists > 0 {
            return out.write_all(b" }");
        }
        self.new_line(out)?;
        out.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.between(out, first, 0)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        out.write_all(b": ")
    }

    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth += 1;
        self.open_lists += 1;
        out.write_all(b"[")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.between(out, first, 1)
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth -= 1;
        self.open_lists -= 1;
        if self.open_lists == 0 {
            self.new_line(out)?;
        }
        out.write_all(b"]")
    }
}

#[cfg(test)]
mod tests {
    use serde::Serialize as _;
    use serde_json::json;

    use super::*;

    #[test]
    fn each_item_of_a_list_has_its_line() {
        let value = json!({"a": {"b": 1}, "c": [{"d": [1, 2], "e": "x"}, {"f": null}]});
        let mut text = Vec::new();
        let mut writer = serde_json::Serializer::with_formatter(&mut text, LinePerItem::default());
        value.serialize(&mut writer).unwrap();
        let expected = "{\n  \"a\": {\n    \"b\": 1\n  },\n  \"c\": [\n    \
            { \"d\": [1, 2], \"e\": \"x\" },\n    { \"f\": null }\n  ]\n}";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }
}
