//! Reads and writes column maps as JSON that can be edited by hand. A map that is written reads back the same. If a map
//! cannot be used, the error names the part of the map to change.

use std::io::{self, Write};
use std::path::Path;

use crate::{
    import::map::{
        column_map::{ColumnMap, FIRST_VERSION, FORMAT, VERSION},
        error::{FINITE, MapError, MapFileError, NOT_NEGATIVE, POSITIVE, must},
        header::{Header, KeyError},
        role::Attitude,
        table::{ColumnKey, ColumnRule, Rest, TableMap},
    },
    recording::Tare,
    small_file::read_small,
};

/// Maximum length of a map file (bytes). A longer file is not a map, and reading it would waste memory.
const MAP_BYTES_LIMIT: u64 = 4 << 20;

impl ColumnMap {
    /// Reads the column map in a file, and checks it.
    pub fn read(path: &Path) -> Result<Self, MapFileError> {
        let text = read_small(path, "a column map", MAP_BYTES_LIMIT).map_err(MapError::from);
        let map = text.and_then(|text| Self::from_json(&text));
        map.map_err(|source| MapFileError { path: path.to_owned(), source })
    }

    /// Reads a column map from the text of a JSON file, and checks it.
    pub fn from_json(text: &[u8]) -> Result<Self, MapError> {
        if text.trim_ascii_start().first() != Some(&b'{') {
            return Err(MapError::NotAMap);
        }
        // These two fields are checked first, because every version of the map format has them.
        let start: serde_json::Value = serde_json::from_slice(text)?;
        let [format, version] = ["format", "version"].map(|key| &start[key]);
        if format != FORMAT {
            return Err(MapError::Format { found: format.to_string(), expected: FORMAT });
        }
        if version != VERSION && version != FIRST_VERSION {
            return Err(MapError::Version { found: version.to_string(), known: VERSION });
        }
        let mut map: Self = serde_json::from_slice(text)?;
        if version == VERSION && start["table"].get("rest").is_none() {
            map.table.rest = Rest::Proposed;
        }
        map.check()?;
        Ok(map)
    }

    /// Writes the map as JSON, with one line for each column.
    pub fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        let pretty = serde_json::to_string_pretty(self)?;
        let mut depth = 0_usize;
        for (at, line) in pretty.lines().enumerate() {
            // The outermost lists begin a line for each item, whose own lines are joined.
            match depth {
                _ if at == 0 => write!(out, "{line}")?,
                0 | 1 => write!(out, "\n{line}")?,
                _ => write!(out, " {}", line.trim_start())?,
            }
            if line.trim_start().starts_with([']', '}']) {
                depth = depth.saturating_sub(1);
            }
            if line.ends_with('[') || (depth > 0 && line.ends_with('{')) {
                depth += 1;
            }
        }
        writeln!(out)
    }

    /// Returns an error if the map contradicts itself, so that no file could be read by it.
    pub fn check(&self) -> Result<(), MapError> {
        self.table.check()?;
        if let Some(reference) = &self.reference {
            let name = Path::new(&reference.file).file_name();
            if reference.file.trim().is_empty() || name.is_none() {
                return Err(MapError::ReferenceName { file: reference.file.clone() });
            }
            reference.table.check()?;
        }
        Attitude::of_table(self.reference_table())?;
        if let Some(weight) = &self.weight {
            weight.check(self.reference_table())?;
        }
        must("join.limit_secs", self.join.limit_secs, NOT_NEGATIVE)?;
        must("join.clock_offset_secs", self.join.clock_offset_secs, FINITE)?;
        must("gap_secs", self.gap_secs, POSITIVE)?;
        match self.tare {
            Some(tare @ Tare::Interval(_, end)) if !tare.is_valid() => Err(MapError::Number {
                what: "the end of \"tare\"".to_owned(),
                value: end,
                must: "at least the start of the interval, and the start must be 0 or more",
            }),
            _ => Ok(()),
        }
    }
}

impl TableMap {
    fn check(&self) -> Result<(), MapError> {
        let (columns, names) = (self.shape.columns, self.shape.names.len());
        if names > 0 && names != columns {
            return Err(MapError::ShapeNames { columns, names });
        }
        must("sample_rate_hz", self.sample_rate_hz, POSITIVE)?;
        for rule in &self.columns {
            self.check_rule(rule)?;
        }
        // The map may list columns whose names are not in `shape`. Whether they exist is checked when a file is read.
        let header = Header::new(self.shape.names.iter().map(String::as_str));
        match header.rules(self) {
            Err(twice @ KeyError::ListedTwice { .. }) => Err(twice.into()),
            _ => Ok(()),
        }
    }

    /// Returns true if the map is for files with certain columns. A typed map has no shape.
    pub fn has_shape(&self) -> bool {
        self.shape.columns > 0
    }

    fn check_rule(&self, rule: &ColumnRule) -> Result<(), MapError> {
        match &rule.column {
            &ColumnKey::Number(number)
                if self.has_shape() && !(1..=self.shape.columns).contains(&number) =>
            {
                return Err(MapError::NoSuchColumn { number, columns: self.shape.columns });
            }
            ColumnKey::Name(name) if self.has_shape() && !self.text.header => {
                return Err(MapError::NameWithoutHeader { name: name.clone() });
            }
            _ => {}
        }
        let of = |what| format!("{what} of column {}", rule.column);
        let is_scale = |x: f64| x != 0.0 && x.is_finite();
        must(of("\"scale\""), rule.scale, ("finite and not 0", is_scale))?;
        must(of("\"counts_per_unit\""), rule.counts_per_unit, POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::text::{Delimiter, TextLayout};
    use crate::import::map::role::ColumnRole;
    use crate::import::map::{Join, ReferenceFile};
    use crate::import::map::{JoinMethod, Shape, Stamps};
    use crate::recording::Axis;

    fn two_files() -> ColumnMap {
        let rule = |number, is| ColumnRule::new(ColumnKey::Number(number), is);
        let table = |columns, rules| TableMap {
            shape: Shape { columns, names: Vec::new() },
            text: TextLayout { delimiter: Delimiter::Semicolon, ..TextLayout::default() },
            sample_rate_hz: Some(12.5),
            stamps: Stamps::Sorted,
            rest: Rest::Ignored,
            columns: rules,
        };
        let load = ColumnRule {
            unit: Some("kN".to_owned()),
            scale: -1.0,
            dropouts: vec![-1.0],
            ..rule(5, ColumnRole::Load(Axis::Fz))
        };
        ColumnMap {
            table: table(4, vec![rule(1, ColumnRole::Time), rule(2, ColumnRole::Gauge)]),
            reference: Some(ReferenceFile {
                file: "states.csv".to_owned(),
                table: table(5, vec![rule(1, ColumnRole::Time), load]),
            }),
            join: Join {
                method: JoinMethod::Nearest,
                limit_secs: Some(0.1),
                clock_offset_secs: -2.5,
            },
            tare: Some(Tare::Interval(0.0, 1.5)),
            gap_secs: Some(2.25),
            group: Some("{folder}".parse().unwrap()),
            ..ColumnMap::default()
        }
    }

    fn json(map: &ColumnMap) -> String {
        let mut text = Vec::new();
        map.write_json(&mut text).unwrap();
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn a_written_map_reads_back_the_same() {
        let map = two_files();
        let text = json(&map);
        assert_eq!(ColumnMap::from_json(text.as_bytes()).unwrap(), map);
        let of_column =
            "\"is\": \"Fz\", \"unit\": \"kN\", \"scale\": -1.0, \"dropouts\": [ -1.0 ] }";
        assert!(text.lines().any(|line| line.contains(of_column)), "{text}");
    }

    #[test]
    fn the_part_that_cannot_be_used_is_named() {
        let whole = json(&two_files());
        for (from, to, word) in [
            (FORMAT, "something", "its \"format\" is \"something\""),
            ("\"version\": 2", "\"version\": 9", "version 9"),
            ("\"column\": 2", "\"column\": 7", "lists column 7"),
            ("\"column\": 2", "\"column\": 0", "lists column 0"),
            ("\"column\": 2", "\"column\": 1", "column 1 is listed twice"),
            ("\"column\": 2", "\"column\": \"S1\"", "the file has no header"),
            ("\"gauge\"", "\"gage\"", "a column cannot have the role \"gage\""),
            ("\"Fz\"", "\"pose_x\"", "one whole orientation"),
            ("\"Fz\"", "\"pose_qx\"", "one whole orientation"),
            ("\"semicolon\"", "\"colon\"", "`colon`"),
            ("\"scale\": -1.0", "\"scale\": 0", "\"scale\" of column 5 is 0"),
            ("\"scale\": -1.0", "\"size\": 0", "unknown field `size`"),
            ("12.5", "-12.5", "sample_rate_hz is -12.5"),
            ("0.1", "-0.1", "join.limit_secs is -0.1"),
            ("2.25", "0", "gap_secs is 0"),
            ("{folder}", "{folder", "group pattern \"{folder\""),
            ("states.csv", "", "the file of the reference load is \"\""),
            ("states.csv", "..", "the file of the reference load is \"..\""),
            ("\"columns\": 4", "\"columns\": 4, \"names\": [\"t\"]", "1 names"),
            ("}", "", "JSON"),
        ] {
            assert!(whole.contains(from), "{from}: {whole}");
            let edited = whole.replacen(from, to, 1);
            let error = ColumnMap::from_json(edited.as_bytes()).unwrap_err();
            let message = error.to_string();
            assert!(message.contains(word), "{to}: {message}");
        }
    }

    #[test]
    fn a_file_without_a_map_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let of = |path: &Path| ColumnMap::read(path).unwrap_err().to_string();
        assert!(of(folder.path()).contains("a folder, not of a file"));
        assert!(
            of(&folder.path().join("gone.json"))
                .contains("gone.json: the file of the column map cannot be read")
        );
        let path = folder.path().join("a.json");
        std::fs::write(&path, "t,S1\n").unwrap();
        assert!(of(&path).contains("a.json: this file is not JSON"));
        std::fs::write(&path, "{}").unwrap();
        assert!(of(&path).contains("not a column map"));
    }
}
