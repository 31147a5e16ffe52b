//! The recorded sessions, in the format of `tests/data/v2/README.md`.

/// Action on the machine.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A line that is typed.
    Line(String),
    /// Bytes typed, spelled with escapes.
    Raw(String),
    /// So many seconds pass.
    Wait(String),
    /// Something breaks or is repaired.
    Fault(String),
    /// A line that only our machine gets, to be where v2's is.
    Ours(String),
}

/// Inputs, and what is answered to them.
#[derive(Clone, Debug, Default)]
pub struct Exchange {
    pub steps: Vec<Step>,
    /// Seconds until the first byte of v2's answer, where it took long.
    pub patience: Option<String>,
    /// Answer of Smoothieware v2.
    pub theirs: Vec<String>,
    /// Known answer of Velvet.
    pub ours: Vec<String>,
}

/// Record of a console session on one machine.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// `config:` and `set:` lines.
    pub head: Vec<String>,
    pub exchanges: Vec<Exchange>,
}

impl Exchange {
    /// The input by which a reason finds it.
    pub fn input(&self) -> &str {
        let typed = self.steps.iter().rev().find_map(|step| match step {
            Step::Line(text) | Step::Raw(text) => Some(text.as_str()),
            _ => None,
        });
        typed.unwrap_or("(wait)")
    }
}

impl Record {
    pub fn parse(text: &str) -> Self {
        let mut record = Self::default();
        let mut replied = true;
        for line in text.lines() {
            if line.starts_with("config:") || line.starts_with("set:") {
                record.head.push(line.to_owned());
                continue;
            }
            if let Some(step) = step(line) {
                if replied {
                    record.exchanges.push(Exchange::default());
                    replied = false;
                }
                record.last().steps.push(step);
                continue;
            }
            let (sign, rest) = line.split_at(1.min(line.len()));
            match sign {
                "@" => record.last().patience = Some(rest.trim().to_owned()),
                "" => {}
                _ => {
                    replied = true;
                    if sign != "+" {
                        record.last().theirs.push(rest.to_owned());
                    }
                    if sign != "-" {
                        record.last().ours.push(rest.to_owned());
                    }
                }
            }
        }
        record
    }

    fn last(&mut self) -> &mut Exchange {
        self.exchanges.last_mut().expect("an input before its reply")
    }
}

fn step(line: &str) -> Option<Step> {
    let (sign, rest) = line.split_once(' ')?;
    let rest = rest.to_owned();
    Some(match sign {
        ">" => Step::Line(rest),
        ">>" => Step::Raw(rest),
        "." => Step::Wait(rest),
        "*" => Step::Fault(rest),
        "!" => Step::Ours(rest),
        _ => return None,
    })
}

/// Both replies in one: ` ` for a common line, `-` for v2's, `+` for ours.
pub fn differences<'a>(theirs: &'a [String], ours: &'a [String]) -> Vec<(char, &'a str)> {
    let (rows, columns) = (theirs.len(), ours.len());
    let mut common = vec![vec![0_usize; columns + 1]; rows + 1];
    for row in (0..rows).rev() {
        for column in (0..columns).rev() {
            common[row][column] = if theirs[row] == ours[column] {
                common[row + 1][column + 1] + 1
            } else {
                common[row + 1][column].max(common[row][column + 1])
            };
        }
    }
    let (mut row, mut column) = (0, 0);
    let mut lines = Vec::new();
    while row < rows || column < columns {
        if row < rows && column < columns && theirs[row] == ours[column] {
            lines.push((' ', theirs[row].as_str()));
            (row, column) = (row + 1, column + 1);
        } else if column == columns || (row < rows && common[row + 1][column] >= common[row][column + 1]) {
            lines.push(('-', theirs[row].as_str()));
            row += 1;
        } else {
            lines.push(('+', ours[column].as_str()));
            column += 1;
        }
    }
    lines
}
