//! Finds the columns of a file that a column map lists by name or number, and turns both into indices. No other source file
//! does this. A column cannot have two rules, even if one rule uses its name and the other its number.

use std::collections::HashMap;

use crate::{
    formats::text::Head,
    import::map::{
        role::ColumnRole,
        table::{ColumnKey, ColumnRule, TableMap},
    },
    shown::{listed, shown},
};

/// Names of the columns of a file, in the order of the file. The list is empty for a file without a header.
#[derive(Debug)]
pub struct Header<'a> {
    names: Vec<&'a str>,
    /// For each name, the indices of the columns that have it.
    places: HashMap<&'a str, Vec<usize>>,
}

/// Reason why the columns that a column map lists cannot be found in a file. Columns are counted from 1.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum KeyError {
    #[error(
        "the column map needs a column named {}, but the columns of this file are {}; use another column map, or none",
        shown(name),
        listed(names)
    )]
    Missing { name: String, names: Vec<String> },
    #[error(
        "columns {first} and {second} are both named {}; list them in the column map by their numbers instead of their names",
        shown(name)
    )]
    SameNames { name: String, first: usize, second: usize },
    #[error(
        "column {column} is listed twice, as {first} and as {second}; list it once in the column map"
    )]
    ListedTwice { column: usize, first: ColumnKey, second: ColumnKey },
}

impl<'a> Header<'a> {
    /// Creates the header from the names of all columns, in the order of the file. The name of a column may be empty.
    pub fn new(names: impl IntoIterator<Item = &'a str>) -> Self {
        let names: Vec<&str> = names.into_iter().collect();
        let mut places: HashMap<&str, Vec<usize>> = HashMap::new();
        for (index, name) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            places.entry(name).or_default().push(index);
        }
        Self { names, places }
    }

    pub fn of(head: &'a Head) -> Self {
        Self::new(head.names.iter().map(String::as_str))
    }

    /// Returns the name or number by which a column map lists the column with this index: the name if no other column has the
    /// same name, else the number.
    pub fn key(&self, index: usize) -> ColumnKey {
        match self.names.get(index) {
            Some(name) if self.places.get(name).is_some_and(|own| own.len() == 1) => {
                ColumnKey::Name((*name).to_owned())
            }
            _ => ColumnKey::Number(index + 1),
        }
    }

    /// Returns the index of the column with this name or number. Returns an error if no column, or more than one column, has
    /// the name.
    pub fn index(&self, key: &ColumnKey) -> Result<usize, KeyError> {
        match key {
            ColumnKey::Number(number) => Ok(number.saturating_sub(1)),
            ColumnKey::Name(name) => match self.places.get(name.as_str()).map(Vec::as_slice) {
                Some([index]) => Ok(*index),
                Some([first, second, ..]) => {
                    let name = name.clone();
                    Err(KeyError::SameNames { name, first: first + 1, second: second + 1 })
                }
                _ => {
                    let names = self.names.iter().map(|own| (*own).to_owned()).collect();
                    Err(KeyError::Missing { name: name.clone(), names })
                }
            },
        }
    }

    /// Returns the rules of a column map with the indices of their columns, in the order of the file. Returns [`KeyError`] if
    /// the column of a rule does not exist, or if two rules are for the same column.
    pub fn rules<'t>(&self, table: &'t TableMap) -> Result<Vec<(usize, &'t ColumnRule)>, KeyError> {
        let with_index = |rule: &'t ColumnRule| Ok((self.index(&rule.column)?, rule));
        let rules: Result<Vec<_>, _> = table.columns.iter().map(with_index).collect();
        let mut rules = rules?;
        rules.sort_by_key(|(index, _)| *index);
        let twice = |pair: &&[(usize, &ColumnRule)]| pair[0].0 == pair[1].0;
        match rules.windows(2).find(twice) {
            None => Ok(rules),
            Some(pair) => Err(KeyError::ListedTwice {
                column: pair[0].0 + 1,
                first: pair[0].1.column.clone(),
                second: pair[1].1.column.clone(),
            }),
        }
    }
}

impl TableMap {
    /// Returns the rule of the map for the column with this index. If the map has none, the returned rule has the role
    /// `ignore`.
    pub fn rule(&self, header: &Header<'_>, index: usize) -> ColumnRule {
        let is_it = |rule: &&ColumnRule| header.index(&rule.column) == Ok(index);
        let rule = self.columns.iter().find(is_it).cloned();
        rule.unwrap_or_else(|| ColumnRule::new(header.key(index), ColumnRole::Ignore))
    }

    /// Replaces the rule of the map for the column with this index. If the map has none, the rule is inserted in the order of
    /// the columns.
    pub fn set_rule(&mut self, header: &Header<'_>, index: usize, rule: ColumnRule) {
        let is_it = |rule: &ColumnRule| header.index(&rule.column) == Ok(index);
        let is_after = |rule: &ColumnRule| header.index(&rule.column).is_ok_and(|at| at > index);
        let rules = &mut self.columns;
        let at = rules.iter().position(is_it);
        rules.retain(|rule| !is_it(rule));
        if rule.is != ColumnRole::Ignore {
            let at = at.or_else(|| rules.iter().position(is_after));
            rules.insert(at.unwrap_or(rules.len()), rule);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_one_column_or_an_error_that_names_the_reason() {
        let header = Header::new(["t", "x", "", "x", "Fx [N]"]);
        let named = |name: &str| header.index(&ColumnKey::Name(name.to_owned()));
        assert_eq!(named("Fx [N]"), Ok(4));
        assert_eq!(header.key(4), ColumnKey::Name("Fx [N]".to_owned()));
        for without_a_name_of_its_own in [1, 2, 3, 9] {
            let number = ColumnKey::Number(without_a_name_of_its_own + 1);
            assert_eq!(header.key(without_a_name_of_its_own), number);
        }
        assert_eq!(header.index(&ColumnKey::Number(3)), Ok(2));
        assert!(matches!(named("Fx"), Err(KeyError::Missing { .. })));
        assert!(matches!(named(""), Err(KeyError::Missing { .. })));
        let same = named("x").unwrap_err();
        assert!(matches!(same, KeyError::SameNames { first: 2, second: 4, .. }));
    }

    #[test]
    fn a_name_and_a_number_of_the_same_column_are_refused() {
        let name = ColumnKey::Name("Fx [N]".to_owned());
        let rule = |key: &ColumnKey| ColumnRule::new(key.clone(), ColumnRole::Ignore);
        let mut table = TableMap {
            columns: vec![rule(&name), rule(&ColumnKey::Number(1))],
            ..TableMap::default()
        };
        let header = Header::new(["t", "Fx [N]"]);
        let indices = |table: &TableMap| -> Vec<usize> {
            let rules = header.rules(table).unwrap();
            rules.into_iter().map(|(index, _)| index).collect()
        };
        assert_eq!(indices(&table), [0, 1]);
        table.columns.push(rule(&ColumnKey::Number(2)));
        let twice = KeyError::ListedTwice { column: 2, first: name, second: ColumnKey::Number(2) };
        assert_eq!(header.rules(&table).unwrap_err(), twice);
    }
}
