//! Messages as `ros2 topic echo` prints them: one value in a line, and a line `---` after each message.

use serde_json::Value;

/// Line after each message.
const END: &str = "---";
/// Maximum number of lines of a message. Further lines are dropped.
const MOST_LINES: usize = 10_000;

/// Lines of the message that arrives.
#[derive(Debug, Default)]
pub struct Messages(Vec<String>);

impl Messages {
    /// Returns the first message, if `end` is the line after a message and all lines before it are values.
    pub fn first<'a>(end: &str, lines: impl Iterator<Item = &'a str>) -> Option<String> {
        let is_value = |line: &&str| line.trim_start().starts_with("- ") || line.contains(':');
        if end.trim() != END {
            return None;
        }
        let lines: Vec<&str> = lines.filter(|line| !line.trim().is_empty()).collect();
        let lines = lines.rsplit(|line| line.trim() == END).next().unwrap_or_default();
        let is_message = lines.iter().all(is_value);
        Some(as_json(lines.iter().copied()))
            .filter(|_| is_message)
            .filter(|message| message != "{}")
    }

    /// Adds a line. Returns the message as a JSON object if the line ends it.
    pub fn push(&mut self, line: &str) -> Option<String> {
        if line.trim() == END {
            return Some(as_json(self.0.drain(..).collect::<Vec<_>>().iter().map(|line| &**line)));
        }
        if self.0.len() < MOST_LINES {
            self.0.push(line.to_owned());
        }
        None
    }
}

/// Returns the numbers of a message as a JSON object, whose keys are the paths of the values. The layout of a ROS array is no
/// measured value.
fn as_json<'a>(lines: impl Iterator<Item = &'a str>) -> String {
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
        members.push((keys.join("."), value));
    }
    let is_measured = |(key, value): &(String, Value)| {
        !key.starts_with("layout") && value.as_array().is_none_or(|list| !list.is_empty())
    };
    Value::Object(members.into_iter().filter(is_measured).collect()).to_string()
}
