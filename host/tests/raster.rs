//! A picture from PNG to the edges of a laser: `velvet raster`, the native runner, `velvet laser`.

mod common;

use std::path::Path;

use common::{folder, said, text, velvet};

const SAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/samples/laser.ini");
/// Pixels of a row.
const COLUMNS: usize = 60;
const ROWS: usize = 6;
/// Number of black bars in a row.
const BARS: usize = 20;

/// Writes a picture of bars, a black column and two white ones, and nothing in its second row.
fn write_bars(path: &Path) {
    let file = std::fs::File::create(path).expect("a file");
    let mut encoder = png::Encoder::new(file, COLUMNS as u32, ROWS as u32);
    encoder.set_color(png::ColorType::Grayscale);
    let light = |index: usize| if index.is_multiple_of(3) && index / COLUMNS != 1 { 0 } else { 255 };
    let pixels: Vec<u8> = (0..COLUMNS * ROWS).map(light).collect();
    encoder.write_header().expect("a header").write_image_data(&pixels).expect("pixels");
}

/// Returns the number of times that a run's power goes from nothing to something and back.
fn edges(power: &str) -> usize {
    let duties: Vec<&str> = power.lines().skip(1).filter_map(|row| Some(row.split_once(',')?.1)).collect();
    let is_on = |duty: &str| duty != "0";
    duties.windows(2).filter(|pair| is_on(pair[0]) != is_on(pair[1])).count() + usize::from(is_on(duties[0]))
}

#[test]
fn a_picture_is_burnt_where_it_lies() {
    let out = folder("raster");
    let [config, picture, job] = ["config.ini", "bars.png", "bars.gcode"].map(|name| out.join(name));
    let sample = std::fs::read_to_string(SAMPLE).expect("the sample");
    std::fs::write(&config, sample.replace("must_be_homed = true", "must_be_homed = false")).expect("written");
    write_bars(&picture);
    let places = ["--at", "30,20", "--feed", "9000", "--pixel", "0.2", "--dither", "threshold"];
    let made =
        velvet(&[&["raster", text(&picture), "-o", text(&job), "--config", text(&config)], &places[..]].concat());
    assert!(made.status.success(), "{}", said(&made));
    let figures = said(&made);
    for begins in
        ["size: 12 x 1.2 mm, 60 x 6 pixels of 0.2 mm", "rows: 5 of 6 rows are burnt", "estimated time: 0:00:0"]
    {
        assert!(figures.lines().any(|line| line.starts_with(begins)), "{begins}: {figures}");
    }
    assert!(out.join("bars.html").is_file());

    let ran = velvet(&["run", "--config", text(&config), "--gcode", text(&job), "--out", text(&out), "--verify"]);
    assert!(ran.status.success(), "{}", said(&ran));
    let power = std::fs::read_to_string(out.join("power.csv")).expect("the laser's changes");
    assert_eq!(edges(&power), 2 * BARS * (ROWS - 1));

    let looked = velvet(&["laser", text(&out)]);
    assert!(looked.status.success(), "{}", said(&looked));
    assert!(said(&looked).starts_with("edges: 200 made, 200 asked for\n"), "{}", said(&looked));
}

#[test]
fn what_cannot_be_burnt_exits_2_and_leaves_no_file() {
    let out = folder("raster-refused");
    let [picture, job] = ["bars.png", "bars.gcode"].map(|name| out.join(name));
    write_bars(&picture);
    let refused = velvet(&["raster", text(&picture), "--feed", "9000", "--config", SAMPLE]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(said(&refused).contains("What would do: --at with X from 8.50 to "), "{}", said(&refused));
    std::fs::write(&picture, "no picture").expect("written");
    let unread = velvet(&["raster", text(&picture), "--feed", "9000", "--acceleration", "1000"]);
    assert_eq!(unread.status.code(), Some(2));
    assert!(said(&unread).contains("bars.png as a PNG"), "{}", said(&unread));
    assert!(!job.exists() && !out.join("bars.html").exists());
}
