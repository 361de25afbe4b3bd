//! Messages as `ros2 topic echo` prints them: one value in a line, and a line `---` after each message.

use serde_json::Value;

/// Line after each message.
const END: &str = "---";
/// Maximum number of lines of a message. Further lines are dropped.
const MOST_LINES: usize = 10_000;

/// Lines of the message that arrives, and the names of the gauges.
#[derive(Debug)]
pub struct Messages {
    lines: Vec<String>,
    gauges: Vec<String>,
}

impl Messages {
    /// Returns the first message, if `end` is the line after a message and all lines before it are values.
    pub fn first<'a>(
        end: &str,
        lines: impl Iterator<Item = &'a str>,
        gauges: &[String],
    ) -> Option<String> {
        let is_value = |line: &&str| line.trim_start().starts_with("- ") || line.contains(':');
        if end.trim() != END {
            return None;
        }
        let lines: Vec<&str> = lines.filter(|line| !line.trim().is_empty()).collect();
        let lines = lines.rsplit(|line| line.trim() == END).next().unwrap_or_default();
        let is_message = lines.iter().all(is_value);
        Some(as_json(lines.iter().copied(), gauges))
            .filter(|_| is_message)
            .filter(|message| message != "{}")
    }

    pub fn new(gauges: &[String]) -> Self {
        Self { lines: Vec::new(), gauges: gauges.to_vec() }
    }

    /// Adds a line. Returns the message as a JSON object if the line ends it.
    pub fn push(&mut self, line: &str) -> Option<String> {
        if line.trim() == END {
            let lines = std::mem::take(&mut self.lines);
            return Some(as_json(lines.iter().map(|line| &**line), &self.gauges));
        }
        if self.lines.len() < MOST_LINES {
            self.lines.push(line.to_owned());
        }
        None
    }
}

/// Returns the gauge whose name ends in the last two parts of this path, as `/ft/wrench/force/x` does in those of
/// `wrench.force.x`; `None` if several gauges do.
fn gauge_at<'a>(path: &str, gauges: &'a [String]) -> Option<&'a String> {
    let parts = |name: &str| -> Vec<String> {
        let parts = name.rsplit(['.', '/']).take(2);
        parts.map(str::to_lowercase).collect()
    };
    let wanted = parts(path);
    let mut found = gauges.iter().filter(|gauge| wanted.len() == 2 && parts(gauge) == wanted);
    found.next().filter(|_| found.next().is_none())
}

/// Returns the numbers of a message as a JSON object, whose keys are the gauges or the paths of the values. The layout of a ROS
/// array is no measured value.
fn as_json<'a>(lines: impl Iterator<Item = &'a str>, gauges: &[String]) -> String {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let mut path: Vec<(usize, &str)> = Vec::new();
    let mut members: Vec<(String, Value)> = Vec::new();
    for line in lines {
        let (text, indent) = (line.trim(), line.len() - line.trim_start().len());
        if let Some(item) = text.strip_prefix("- ") {
            if let (Some(item), Some((_, Value::Array(list)))) = (number(item), members.last_mut())
            {
                list.push(item.into());
            }
            continue;
        }
        let Some((key, value)) = text.split_once(':') else { continue };
        // The values of a ROS array have no other name than `data`. A list as long as the list of gauges holds the gauges.
        let key = if key == "data" { "gauges" } else { key };
        path.retain(|(before, _)| *before < indent);
        path.push((indent, key));
        let keys: Vec<&str> = path.iter().map(|(_, key)| *key).collect();
        let value = number(value).map_or_else(
            || {
                Value::Array(
                    value.split([',', '[', ']']).filter_map(number).map(Value::from).collect(),
                )
            },
            Value::from,
        );
        let path = keys.join(".");
        members.push((gauge_at(&path, gauges).cloned().unwrap_or(path), value));
    }
    let is_measured = |(key, value): &(String, Value)| {
        !key.starts_with("layout") && value.as_array().is_none_or(|list| !list.is_empty())
    };
    Value::Object(members.into_iter().filter(is_measured).collect()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_a_wrench_are_the_gauges_whose_names_end_alike() {
        let message = "header:\n  stamp:\n    sec: 5\nwrench:\n  force:\n    x: 1.5\n    y: 2\n---";
        let json = |gauges: &[&str]| -> Value {
            let gauges: Vec<String> = gauges.iter().map(|gauge| (*gauge).to_owned()).collect();
            let lines: Vec<&str> = message.lines().collect();
            let json = Messages::first("---", lines[..lines.len() - 1].iter().copied(), &gauges);
            serde_json::from_str(&json.unwrap()).unwrap()
        };
        let named = json(&["/ft/wrench/force/x", "Force.Y", "S3"]);
        assert_eq!(named["/ft/wrench/force/x"], 1.5);
        assert_eq!(named["Force.Y"], 2.0);
        assert_eq!(named["header.stamp.sec"], 5.0);
        let unclear = json(&["/a/force/x", "/b/force/x", "y"]);
        assert_eq!(unclear["wrench.force.x"], 1.5);
        assert_eq!(unclear["wrench.force.y"], 2.0);
    }
}
