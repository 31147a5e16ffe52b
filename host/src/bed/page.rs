//! The page of a bed: a map with contour lines, a view in space, the heights at the points, the sentences.
//! The page needs no network.

use serde_json::json;

use super::Mesh;
use crate::page::fill;

const TEMPLATE: &str = include_str!("../../assets/bed.html");

/// Number of heights drawn along the surface's longer side.
const FINE: f64 = 64.0;

/// Returns the whole HTML page of a mesh.
pub fn page(mesh: &Mesh, title: &str) -> String {
    let [first, last] = [mesh.shape.place(0), mesh.shape.place(mesh.shape.points() - 1)];
    let low = [first[0].min(last[0]), first[1].min(last[1])];
    let size = [(last[0] - first[0]).abs(), (last[1] - first[1]).abs()];
    let longest = size[0].max(size[1]);
    let [wide, deep] = size.map(|size| (FINE * size / longest).round().max(8.0) as usize);
    let at = |index: usize, count: usize, axis: usize| low[axis] + size[axis] * index as f64 / (count - 1) as f64;
    let surface: Vec<f64> = (0..deep)
        .flat_map(|row| (0..wide).map(move |column| (column, row)))
        .map(|(column, row)| mesh.height(at(column, wide, 0), at(row, deep, 1)))
        .map(|height| (height * 1e5).round() / 1e5)
        .collect();
    let points = mesh.heights.iter().enumerate().map(|(index, height)| {
        let [x, y] = mesh.shape.place(index);
        json!([x, y, height])
    });
    let data = json!({
        "low": low, "size": size, "wide": wide, "deep": deep, "surface": surface,
        "points": points.collect::<Vec<_>>(), "count": mesh.shape.count, "words": mesh.sentences(),
        "tilt": mesh.form.tilt, "bend": mesh.form.bend, "twist": mesh.form.twist, "rest": mesh.form.rest, "mean": mesh.form.mean,
        "highest": mesh.form.highest, "lowest": mesh.form.lowest, "interpolation": mesh.interpolation.name(),
    });
    fill(TEMPLATE, title, &data)
}
