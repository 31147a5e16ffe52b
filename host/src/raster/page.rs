//! The page of a raster file: the picture that its lines burn, where it lies on the machine, and facts.

use anyhow::Result;
use serde_json::json;

use super::burnt::Pass;
use super::strokes::Layout;
use crate::page::fill;
use crate::report::page::base64;

const TEMPLATE: &str = include_str!("../../assets/raster.html");

/// What the page shows beside the picture.
#[derive(Clone, Debug)]
pub struct Facts {
    /// Name of the file of G-code.
    pub title: String,
    /// Number of columns and rows of the picture.
    pub pixels: [usize; 2],
    /// S that is drawn black.
    pub most: f64,
    /// Least and greatest places of X and Y on the machine, mm; infinite where they are not known.
    pub travel: [[f64; 2]; 2],
    /// Figures in large type: value, unit, name.
    pub tiles: Vec<[String; 3]>,
    /// Facts in a table: name and value.
    pub rows: Vec<[String; 2]>,
}

/// Brightness of the pixels that ways burn, rows from the top.
pub fn burnt(passes: &[Pass], layout: &Layout, [columns, rows]: [usize; 2], most: f64) -> Vec<u8> {
    let mut light = vec![u8::MAX; columns * rows];
    let along = layout.axis as usize;
    let ends = [columns, rows];
    let (length, lines) = (ends[along], ends[1 - along]);
    for pass in passes.iter().filter(|pass| pass.power > 0.0) {
        let (from, to) = (pass.from[along], pass.to[along]);
        let offset = if to < from { layout.reverse_offset } else { 0.0 };
        let pixel = |place: f64, axis: usize| (place - layout.at[axis]) / layout.pixel;
        let edge = |place: f64| (pixel(place - offset, along).round().max(0.0) as usize).min(length);
        let line = (pixel(pass.from[1 - along], 1 - along) as usize).min(lines - 1);
        let shade = 255.0 * (1.0 - (pass.power / most).min(1.0));
        for place in edge(from.min(to))..edge(from.max(to)) {
            let [column, row] = if along == 0 { [place, line] } else { [line, place] };
            light[(rows - 1 - row) * columns + column] = shade.round() as u8;
        }
    }
    light
}

/// Returns a grey PNG.
pub fn png(light: &[u8], [columns, rows]: [usize; 2]) -> Result<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, u32::try_from(columns)?, u32::try_from(rows)?);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(light)?;
    writer.finish()?;
    Ok(file)
}

/// Returns the page, from the ways that were read from the file of G-code.
pub fn page(passes: &[Pass], layout: &Layout, facts: &Facts) -> Result<String> {
    let light = burnt(passes, layout, facts.pixels, facts.most);
    let size = facts.pixels.map(|count| count as f64 * layout.pixel);
    let at = layout.at;
    // A lead is a way in the feed without power that meets an end of the burnt ones.
    let is_lead = |index: &usize| {
        let is_feed = |index: Option<usize>| index.and_then(|index| passes.get(index)).is_some_and(|pass| pass.is_feed);
        let pass = &passes[*index];
        let is_first = !is_feed(index.checked_sub(1));
        pass.is_feed && pass.power == 0.0 && (is_first || !is_feed(Some(index + 1)))
    };
    let line = |pass: &Pass| [pass.from, pass.to].map(|place| place.map(|mm| (mm * 1e4).round() / 1e4));
    let leads: Vec<_> = (0..passes.len()).filter(is_lead).map(|index| line(&passes[index])).collect();
    let rapids: Vec<_> = passes.iter().filter(|pass| !pass.is_feed).skip(1).map(line).collect();
    let known = |end: f64| end.is_finite().then_some(end);
    let data = json!({
        "title": facts.title, "at": at, "size": size, "pixels": facts.pixels, "pixel": layout.pixel,
        "picture": format!("data:image/png;base64,{}", base64(png(&light, facts.pixels)?.into_iter())),
        "travel": facts.travel.map(|end| end.map(known)),
        "leads": leads, "rapids": rapids, "tiles": facts.tiles, "rows": facts.rows,
    });
    Ok(fill(TEMPLATE, &facts.title, &data))
}
