//! The previous generation's `config`: `key value # comment`, dotted keys; of two lines with one key the
//! last counts.

/// Setting of the old file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Line number, from 1.
    pub number: usize,
    /// Dotted key, such as `temperature_control.hotend.max_temp`.
    pub key: String,
    /// First word after the key, as the old firmware reads it.
    pub value: String,
    /// The owner's comment behind the setting.
    pub comment: String,
}

/// Returns all settings in the order of the file; of two with one key the later.
pub fn read(text: &str) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    // Some editors put a byte order mark before the first line.
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let (content, comment) = line.split_once('#').unwrap_or((line, ""));
        let mut words = content.split_whitespace();
        let Some(key) = words.next() else { continue };
        let value = words.next().unwrap_or("").to_owned();
        let line = Line { number: index + 1, key: key.to_owned(), value, comment: comment.trim().to_owned() };
        lines.retain(|earlier| earlier.key != line.key || key == "include");
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_line_of_a_key_counts_and_comments_stay() {
        let lines = read(
            "\u{feff} # head\n\nalpha_max_rate 300 # slow\nbeta_max_rate\t500# tab\nalpha_max_rate   600 unit\nx\n",
        );
        let told: Vec<_> =
            lines.iter().map(|l| (l.number, l.key.as_str(), l.value.as_str(), l.comment.as_str())).collect();
        assert_eq!(told, [(4, "beta_max_rate", "500", "tab"), (5, "alpha_max_rate", "600", ""), (6, "x", "", "")]);
    }
}
