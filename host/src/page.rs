//! Pages that stand alone: a template, the scripts and styles that it names, and data as JSON. No network is
//! needed to look at one.

use serde::Serialize;

/// Scripts and styles, by their names in the templates.
const ASSETS: [(&str, &str); 13] = [
    ("uplot.css", include_str!("../assets/vendor/uPlot.min.css")),
    ("uplot.js", include_str!("../assets/vendor/uPlot.iife.min.js")),
    ("three.js", include_str!("../assets/vendor/three.min.js")),
    ("report.css", include_str!("../assets/report.css")),
    ("palette.js", include_str!("../assets/palette.js")),
    ("account.js", include_str!("../assets/report-account.js")),
    ("report.js", include_str!("../assets/report.js")),
    ("motion.js", include_str!("../assets/motion.js")),
    ("heat.js", include_str!("../assets/heat.js")),
    ("bed.js", include_str!("../assets/bed.js")),
    ("preflight.js", include_str!("../assets/preflight.js")),
    ("migrate.js", include_str!("../assets/migrate.js")),
    ("raster.js", include_str!("../assets/raster.js")),
];

/// Returns a page: the template with its assets, its data and its title.
pub fn fill(template: &str, title: &str, data: &impl Serialize) -> String {
    // `<` never stands in the JSON, so no text in the data can end the script it is in.
    let data = serde_json::to_string(data).unwrap_or_else(|_| "null".to_owned()).replace('<', "\\u003c");
    let mut page = String::with_capacity(data.len() + (1 << 20));
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        page += before;
        let Some((slot, after)) = after.split_once("}}") else { break };
        match ASSETS.iter().find(|(name, _)| *name == slot) {
            Some((_, content)) => page += content,
            None if slot == "data" => page += &data,
            None => page += &escape(title),
        }
        rest = after;
    }
    page + rest
}

/// Returns the text with what has a meaning in HTML replaced.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
