//! Column maps that are typed: `Mass_kg=Fz kgf, Reading=gauge`.

use crate::import::map::{
    column_map::ColumnMap,
    role::ColumnRole,
    table::{ColumnKey, ColumnRule, Rest, TableMap},
};

/// Key of the sample rate among the typed columns.
const RATE: &str = "sample_rate_hz";

impl ColumnMap {
    /// Reads a map of the form `COLUMN=ROLE UNIT, …`. COLUMN is a name in the header, with or without its unit, or a number. A
    /// name may stand in double quotes. `/1000` behind the unit gives the counts per unit. All other columns keep their
    /// proposed role.
    ///
    /// # Errors
    /// A message that names the part that is not understood.
    pub fn typed(text: &str) -> Result<Self, String> {
        let mut table = TableMap { rest: Rest::Proposed, ..TableMap::default() };
        let mut rest = text.trim();
        while !rest.is_empty() {
            let (key, after) = match rest.strip_prefix('"').and_then(|own| own.split_once('"')) {
                Some((name, after)) => (ColumnKey::Name(name.to_owned()), after.trim_start()),
                None => {
                    let end = rest.find('=').unwrap_or(rest.len());
                    let name = rest[..end].trim();
                    let number = name.parse().ok().filter(|number| *number > 0);
                    let key =
                        number.map_or_else(|| ColumnKey::Name(name.to_owned()), ColumnKey::Number);
                    (key, &rest[end..])
                }
            };
            let after = after.strip_prefix('=').ok_or_else(|| {
                format!("\"{rest}\" is no COLUMN=ROLE, such as \"Mass_kg=Fz kgf, Reading=gauge\"")
            })?;
            let (value, later) = after.split_once(',').unwrap_or((after, ""));
            rest = later.trim_start();
            let value = value.trim();
            if key == ColumnKey::Name(RATE.to_owned()) {
                let rate = value.parse().ok().filter(|rate: &f64| *rate > 0.0 && rate.is_finite());
                table.sample_rate_hz =
                    Some(rate.ok_or_else(|| format!("{RATE} is {value}, which is no rate in Hz"))?);
                continue;
            }
            let (role, unit) = value.split_once(' ').unwrap_or((value, ""));
            let is = ColumnRole::try_from(role.to_owned())?;
            let mut rule = ColumnRule::new(key, is);
            let mut unit = unit.trim();
            if let Some((start, counts)) = unit.rsplit_once('/')
                && let Ok(counts) = counts.trim().parse::<f64>()
            {
                rule.counts_per_unit = counts;
                unit = start.trim();
            }
            rule.unit = Some(unit.to_owned()).filter(|unit| !unit.is_empty());
            table.columns.push(rule);
        }
        let map = Self::of_table(table);
        map.check().map_err(|error| error.to_string())?;
        Ok(map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Axis;

    #[test]
    fn typed_columns_give_roles_units_and_counts() {
        let map =
            ColumnMap::typed("Mass_kg=Fz kgf, \"a, b\" = gauge,3=Fx N/1000.5, sample_rate_hz=50");
        let table = map.unwrap().table;
        let rule = |key: ColumnKey, is| ColumnRule::new(key, is);
        let name = |name: &str| ColumnKey::Name(name.to_owned());
        let unit = |unit: &str| Some(unit.to_owned());
        assert_eq!(
            table.columns,
            [
                ColumnRule {
                    unit: unit("kgf"),
                    ..rule(name("Mass_kg"), ColumnRole::Load(Axis::Fz))
                },
                rule(name("a, b"), ColumnRole::Gauge),
                ColumnRule {
                    unit: unit("N"),
                    counts_per_unit: 1000.5,
                    ..rule(ColumnKey::Number(3), ColumnRole::Load(Axis::Fx))
                },
            ]
        );
        assert_eq!((table.sample_rate_hz, table.rest), (Some(50.0), Rest::Proposed));
        for wrong in ["Mass", "a=gage", "a=Fz N/0", "sample_rate_hz=-1", "a=gauge b=gauge=c, d"] {
            assert!(ColumnMap::typed(wrong).is_err(), "{wrong}");
        }
    }
}
