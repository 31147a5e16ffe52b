//! The fault page, and the same as `summary.json`: injected fault, state of the machine, and time until it
//! had reacted.

use std::fmt::Write as _;

use super::scene::Seen;
use super::{Case, Class};

/// A case that was run, with its times or the reason of its failure.
pub struct Row<'a> {
    pub part: &'a str,
    pub class: &'a Class,
    pub case: &'a Case,
    pub seen: Result<Seen, String>,
}

impl Row<'_> {
    fn name(&self) -> String {
        format!("{}, {}", self.class.name, self.case.state.words())
    }

    /// Returns the measured times; none where the case failed.
    fn times(&self) -> Seen {
        self.seen.as_ref().copied().unwrap_or_default()
    }

    /// Describes the times in words.
    fn figure(&self) -> String {
        let Seen { outputs_ms, motion_ms, told_ms } = self.times();
        let parts = [("outputs off", outputs_ms), ("standstill", motion_ms), ("told", told_ms)];
        let words = parts.into_iter().filter_map(|(what, ms)| Some(format!("{what} {}", time(ms?))));
        words.collect::<Vec<_>>().join(", ")
    }

    /// Returns the slowest time as a share of the limit.
    fn share(&self) -> f64 {
        let seen = self.times();
        let slowest = [seen.outputs_ms, seen.motion_ms, seen.told_ms].into_iter().flatten().fold(0.0, f64::max);
        if self.case.within_ms > 0.0 { (slowest / self.case.within_ms).min(1.0) } else { 0.0 }
    }
}

/// A test without times: its figures in words, or the reason of its failure.
pub struct Other<'a> {
    pub name: &'a str,
    pub what: &'a str,
    pub text: Result<String, String>,
}

/// Lists all cases: name, and figure or reason of the failure.
fn ends<'a>(rows: &'a [Row<'_>], others: &'a [Other<'_>]) -> impl Iterator<Item = (String, Result<String, &'a str>)> {
    let cases = rows.iter().map(|row| (row.name(), row.seen.as_ref().map(|_| row.figure()).map_err(String::as_str)));
    let others = others
        .iter()
        .map(|other| (other.name.to_owned(), other.text.as_ref().map(String::clone).map_err(String::as_str)));
    cases.chain(others)
}

/// Lists the failed cases, by name, with the reason.
pub fn failed(rows: &[Row<'_>], others: &[Other<'_>]) -> Vec<String> {
    ends(rows, others).filter_map(|(name, end)| Some(format!("{name}: {}", end.err()?))).collect()
}

/// Formats the summary: `{"cases": [{"name", "ok", "figure", "why"}], "passed", "failed", "skipped"}`.
pub fn summary(rows: &[Row<'_>], others: &[Other<'_>]) -> String {
    let mut text = String::from("{\"cases\": [");
    let (mut passed, mut failed) = (0, 0);
    for (name, end) in ends(rows, others) {
        text += if passed + failed == 0 { "\n" } else { ",\n" };
        let (ok, figure, why) = match end {
            Ok(figure) => (true, figure, ""),
            Err(why) => (false, String::new(), why),
        };
        *(if ok { &mut passed } else { &mut failed }) += 1;
        let _ = write!(
            text,
            "  {{\"name\": {}, \"ok\": {ok}, \"figure\": {}, \"why\": {}}}",
            quoted(&name),
            quoted(&figure),
            quoted(why)
        );
    }
    let _ = writeln!(text, "\n], \"passed\": {passed}, \"failed\": {failed}, \"skipped\": 0}}");
    text
}

/// Quotes a text as a string of JSON.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            letter if letter < ' ' => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(letter));
            }
            letter => quoted.push(letter),
        }
    }
    quoted + "\""
}

const HEAD: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Velvet: faults</title><style>
body{font:15px/1.45 system-ui,sans-serif;max-width:1180px;margin:2em auto;padding:0 1em;color:#1c1f23}
h1{font-size:1.6em;margin-bottom:.2em}h2{font-size:1.15em;margin:1.8em 0 .4em}
table{border-collapse:collapse;width:100%;table-layout:fixed}
th{width:7.5em}th:first-child{width:auto}th:nth-child(2){width:9.5em}th:last-child{width:8em}
th{font-weight:600;text-align:left;color:#5a626b;font-size:.85em}
th,td{padding:.3em .7em .3em 0;vertical-align:top;border-bottom:1px solid #e4e7ea}
td.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}th.n{text-align:right}
.bar{background:#e9edf0;height:.55em;width:7em;margin-top:.45em;border-radius:.2em}
.bar i{display:block;background:#2f7d5b;height:100%;border-radius:.2em}
.failed{color:#b3261e;font-weight:600}.does{color:#5a626b}
</style>";

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('`', "")
}

/// Formats a time for people.
fn time(ms: f64) -> String {
    match ms {
        ms if ms < 10.0 => format!("{ms:.2} ms"),
        ms if ms < 1_000.0 => format!("{ms:.0} ms"),
        ms => format!("{:.1} s", ms / 1e3),
    }
}

/// Formats a time for a cell of the page.
fn cell(ms: Option<f64>) -> String {
    ms.map_or_else(|| "&ndash;".into(), time)
}

/// Draws the page, as one file of HTML.
pub fn draw(rows: &[Row<'_>], others: &[Other<'_>]) -> String {
    let classes = rows.iter().map(|row| row.class.name).collect::<std::collections::BTreeSet<_>>().len();
    let failed = failed(rows, others).len();
    let mut page = String::from(HEAD);
    let verdict =
        if failed == 0 { "every one as promised".to_owned() } else { format!("<b class=failed>{failed} failed</b>") };
    let _ = write!(
        page,
        "<h1>Faults</h1><p>{classes} classes of faults in {} cases, each injected into the unmodified image on the virtual \
         board; {verdict}. Times are virtual, from the fault to the reaction. Where nothing was on, moved or had to be told \
         there is no time; after a reset the next start tells.</p>",
        rows.len()
    );
    let mut part = "";
    let mut class = "";
    for row in rows {
        if row.part != part {
            page += if part.is_empty() { "" } else { "</table>" };
            let _ = write!(
                page,
                "<h2>{}</h2><table><tr><th>what fails<th>while<th class=n>outputs off<th class=n>standstill<th class=n>told<th class=n>\
                 limit<th></tr>",
                row.part
            );
            part = row.part;
        }
        let what = if row.class.name == class {
            String::new()
        } else {
            format!("{}<br><span class=does>{}</span>", escape(row.class.what), escape(row.class.does))
        };
        class = row.class.name;
        let seen = row.times();
        let limit = if row.case.within_ms > 0.0 { time(row.case.within_ms) } else { String::new() };
        let bar = match &row.seen {
            Err(why) => format!("<span class=failed>failed</span><br>{}", escape(why)),
            Ok(_) => format!("<div class=bar><i style=\"width:{:.0}%\"></i></div>", 100.0 * row.share()),
        };
        let _ = write!(
            page,
            "<tr><td>{what}<td>{}<td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{limit}<td>{bar}</tr>",
            row.case.state.words(),
            cell(seen.outputs_ms),
            cell(seen.motion_ms),
            cell(seen.told_ms)
        );
    }
    page += if part.is_empty() { "" } else { "</table>" };
    if !others.is_empty() {
        page += "<h2>Power cuts</h2><table><tr><th>what fails<th style=\"width:auto\">what came of it</tr>";
    }
    for other in others {
        let end = match &other.text {
            Ok(text) => escape(text),
            Err(why) => format!("<span class=failed>failed</span> {}", escape(why)),
        };
        let _ = write!(page, "<tr><td>{}<td>{end}</tr>", escape(other.what));
    }
    page += if others.is_empty() { "" } else { "</table>" };
    page + "</html>\n"
}
