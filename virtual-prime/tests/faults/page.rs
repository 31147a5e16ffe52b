//! The fault page: what was injected, in which state, and how soon the machine had reacted.

use std::fmt::Write as _;

use super::scene::Seen;
use super::{Case, Class};

/// A case that was run; nothing was seen where it failed.
pub struct Row<'a> {
    pub part: &'a str,
    pub class: &'a Class,
    pub case: &'a Case,
    pub seen: Option<Seen>,
}

impl Row<'_> {
    pub fn name(&self) -> String {
        format!("{}, {}", self.class.what, self.case.state.words())
    }

    /// Of the limit, the share that it took.
    fn share(&self) -> f64 {
        let seen = self.seen.unwrap_or_default();
        let slowest = [seen.outputs_ms, seen.motion_ms, seen.told_ms].into_iter().flatten().fold(0.0, f64::max);
        if self.case.within_ms > 0.0 { (slowest / self.case.within_ms).min(1.0) } else { 0.0 }
    }
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

/// A time as a person reads it.
fn time(ms: Option<f64>) -> String {
    match ms {
        None => "&ndash;".into(),
        Some(ms) if ms < 10.0 => format!("{ms:.2} ms"),
        Some(ms) if ms < 1_000.0 => format!("{ms:.0} ms"),
        Some(ms) => format!("{:.1} s", ms / 1e3),
    }
}

/// The page, as one file of HTML.
pub fn draw(rows: &[Row<'_>]) -> String {
    let classes = rows.iter().map(|row| row.class.name).collect::<std::collections::BTreeSet<_>>().len();
    let failed = rows.iter().filter(|row| row.seen.is_none()).count();
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
        let seen = row.seen.unwrap_or_default();
        let limit = if row.case.within_ms > 0.0 { time(Some(row.case.within_ms)) } else { String::new() };
        let bar = match row.seen {
            None => "<span class=failed>failed</span>".to_owned(),
            Some(_) => format!("<div class=bar><i style=\"width:{:.0}%\"></i></div>", 100.0 * row.share()),
        };
        let _ = write!(
            page,
            "<tr><td>{what}<td>{}<td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{limit}<td>{bar}</tr>",
            row.case.state.words(),
            time(seen.outputs_ms),
            time(seen.motion_ms),
            time(seen.told_ms)
        );
    }
    page + "</table></html>\n"
}
