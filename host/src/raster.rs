//! `velvet raster`: a picture as G-code for a laser, and a page that shows what the G-code burns.

mod burnt;
mod dither;
mod machine;
mod options;
mod page;
mod picture;
mod strokes;
#[cfg(test)]
mod tests;
mod time;
mod writer;

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use units::Axis;

use dither::Levels;
use machine::{Limits, Machine};
pub use options::Options;
use options::{Place, Tones, check, pixel, powers};
use page::Facts;
use picture::{Picture, Tone};
use strokes::{Layout, Stroke};
use writer::{Frame, Powers, in_comment, letters, trimmed};

/// A picture as G-code, and figures about it.
struct Raster {
    layout: Layout,
    levels: Levels,
    strokes: Vec<Stroke>,
    machine: Machine,
    powers: Powers,
    seconds: f64,
    text: String,
}

/// Reads the picture, writes G-code and page, prints figures.
pub fn raster(options: &Options) -> Result<()> {
    let picture = Picture::read(&options.picture)?;
    let source = file_name(&options.picture);
    let raster = Raster::new(options, picture, &source)?;
    let output = options.output.clone().unwrap_or_else(|| options.picture.with_extension("gcode"));
    write(&output, &raster.text)?;
    let figures = raster.figures(options);
    for [name, value] in &figures {
        println!("{name}: {value}");
    }
    println!("file: {}, {} lines, {} bytes", output.display(), raster.text.lines().count(), raster.text.len());
    if !options.no_page {
        let path = options.page.clone().unwrap_or_else(|| output.with_extension("html"));
        ensure!(path != output, "{} is both --output and --page", path.display());
        write(&path, &raster.page(file_name(&output), source, figures)?)?;
        println!("page: {}", path.display());
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

impl Raster {
    /// Makes a picture's G-code.
    fn new(options: &Options, picture: Picture, source: &str) -> Result<Self> {
        let Options { place, tones, motion, .. } = options;
        check(options)?;
        let axis = if motion.vertical { Axis::Y } else { Axis::X };
        let mut machine = machine(options, axis)?;
        machine.scale = motion.scale.unwrap_or(machine.scale);
        let speed = motion.feed / 60.0;
        if speed > machine.limits.speed * (1.0 + 1e-9) {
            let most = machine.limits.speed * 60.0;
            bail!("--feed {} is more than {} of the machine can do, {most:.0} mm/min", motion.feed, axis.letter());
        }
        let powers = powers(motion, machine.scale)?;
        let layout = Layout {
            pixel: pixel(place),
            at: place.at,
            axis,
            both_directions: !motion.one_way,
            reverse_offset: motion.reverse_offset,
            lead: Layout::lead(&machine.limits, speed),
        };
        let levels = levels(tones, place, picture)?;
        let strokes = layout.strokes(&levels);
        ensure!(!strokes.is_empty(), "the picture is blank: nothing of it is burnt (see --invert, --brightness)");
        layout.check(&strokes, &machine.travel, &machine.limits, speed)?;
        let seconds = time::of_strokes(&layout, &strokes, &machine.limits, speed);
        let mut raster = Self { layout, levels, strokes, machine, powers, seconds, text: String::new() };
        raster.text = raster.written(options, source);
        if let Some(config) = &raster.machine.config {
            raster.seconds = time::of_file(config, &raster.text)?;
            raster.text = raster.written(options, source);
        }
        Ok(raster)
    }

    /// Returns the G-code.
    fn written(&self, options: &Options, source: &str) -> String {
        let Self { layout, strokes, powers, levels, .. } = self;
        let Options { motion, .. } = options;
        let frame = Frame {
            comments: self.comments(options, source),
            feed: motion.feed,
            is_constant: motion.m3,
            has_air: motion.air,
        };
        writer::write(&frame, layout, strokes, powers, |level| levels.share(level))
    }

    fn comments(&self, options: &Options, source: &str) -> Vec<String> {
        let first = format!("Picture: {}, by velvet raster", in_comment(source));
        let figures = self.figures(options).into_iter();
        std::iter::once(first)
            .chain(figures.map(|[name, value]| format!("{}{}: {value}", name[..1].to_uppercase(), &name[1..])))
            .collect()
    }

    /// Returns figures about the picture: name and value.
    fn figures(&self, options: &Options) -> Vec<[String; 2]> {
        let Self { layout, levels, strokes, powers, .. } = self;
        let [width, height] = self.size().map(|mm| trimmed(format!("{mm:.3}")));
        let [along, across] = letters(layout.axis);
        let lines = if along == 'X' { ["rows", "rows"] } else { ["columns", "columns"] };
        let all = if along == 'X' { levels.rows } else { levels.columns };
        let burnt = levels.of.iter().filter(|level| **level > 0).count();
        let feed = options.motion.feed;
        let way = if layout.both_directions { "there and back" } else { "one way" };
        let runs: usize = strokes.iter().map(|stroke| stroke.runs.len()).sum();
        let s = |s: f64| trimmed(format!("{s:.3}"));
        let pairs = [
            (
                "size",
                format!("{width} x {height} mm, {} x {} pixels of {} mm", levels.columns, levels.rows, layout.pixel),
            ),
            (
                lines[0],
                format!(
                    "{} of {all} {} are burnt, {runs} runs, {burnt} of {} pixels",
                    strokes.len(),
                    lines[1],
                    levels.of.len()
                ),
            ),
            ("bounds", self.bounds(along, across)),
            ("speed", format!("{feed} mm/min ({} mm/s), {way} along {along}", trimmed(format!("{:.2}", feed / 60.0)))),
            ("leads", format!("{:.2} mm at each end, for {:.0} mm/s^2", layout.lead, self.machine.limits.acceleration)),
            (
                "power",
                format!(
                    "S{} to S{}, {} is full, {}",
                    s(powers.least),
                    s(powers.most),
                    s(powers.scale),
                    if options.motion.m3 { "M3" } else { "M4" }
                ),
            ),
            ("tones", format!("{} levels, {}", levels.count, options.tones.dither.name())),
            ("estimated time", hours(self.seconds)),
        ];
        pairs.map(|(name, value)| [name.to_owned(), value]).to_vec()
    }

    fn size(&self) -> [f64; 2] {
        [self.levels.columns, self.levels.rows].map(|count| count as f64 * self.layout.pixel)
    }

    fn bounds(&self, along: char, across: char) -> String {
        let Some([least, most]) = self.layout.bounds(&self.strokes) else { return String::new() };
        let [a, b] = if along == 'X' { [0, 1] } else { [1, 0] };
        format!(
            "{along}{:.2} to {along}{:.2} with leads, {across}{:.2} to {across}{:.2}",
            least[a], most[a], least[b], most[b]
        )
    }

    fn page(&self, title: String, source: String, figures: Vec<[String; 2]>) -> Result<String> {
        let passes = burnt::read(&self.text).context("the file that was written")?;
        let [width, height] = self.size().map(|mm| trimmed(format!("{mm:.2}")));
        let tile = |value: String, unit: &str, name: &str| [value, unit.to_owned(), name.to_owned()];
        let tiles = vec![
            tile(hours(self.seconds), "h:min:s", "estimated time"),
            tile(format!("{width} x {height}"), "mm", "size"),
            tile(self.layout.pixel.to_string(), "mm", "pixel"),
            tile(format!("{} x {}", self.levels.columns, self.levels.rows), "", "pixels"),
            tile(
                format!("{:.1}", self.text.len() as f64 / 1e3),
                "kB",
                &format!("{} lines of G-code", self.text.lines().count()),
            ),
        ];
        let rows = std::iter::once(["picture".to_owned(), source]).chain(figures).collect();
        let facts = Facts {
            title,
            pixels: [self.levels.columns, self.levels.rows],
            most: self.powers.most,
            travel: self.machine.travel,
            tiles,
            rows,
        };
        page::page(&passes, &self.layout, &facts)
    }
}

/// Returns the machine of the configuration, or one of which the acceleration alone is known.
fn machine(options: &Options, axis: Axis) -> Result<Machine> {
    let motion = &options.motion;
    let Some(path) = &options.config else {
        let Some(acceleration) = motion.acceleration else {
            bail!("the acceleration is needed for the leads of the rows: give --config FILE, or --acceleration MM/S^2");
        };
        let limits =
            Limits { speed: f64::INFINITY, acceleration, jerk: f64::INFINITY, seek: motion.feed / 60.0, spread: 0.0 };
        return Ok(Machine { config: None, limits, travel: [[f64::NEG_INFINITY; 2], [f64::INFINITY; 2]], scale: 1.0 });
    };
    Machine::read(path, axis, options.place.at)
}

/// Returns the levels of the picture at the size that is asked for.
fn levels(tones: &Tones, place: &Place, picture: Picture) -> Result<Levels> {
    let (columns, rows) = (picture.columns as f64, picture.rows as f64);
    let [width, height] = match (place.width, place.height) {
        (None, None) => [columns, rows].map(|count| count * pixel(place)),
        (Some(width), None) => [width, width * rows / columns],
        (None, Some(height)) => [height * columns / rows, height],
        (Some(width), Some(height)) => [width, height],
    };
    let [columns, rows] = [width, height].map(|mm| (mm / pixel(place)).round().max(1.0) as usize);
    picture::ensure_fits(columns, rows).context("give a larger --pixel or a smaller picture")?;
    let tone = Tone {
        brightness: tones.brightness,
        contrast: tones.contrast,
        gamma: tones.gamma,
        inverts: tones.invert,
        mirrors: place.mirror,
    };
    let darkness = picture.resized(columns, rows).darkness(&tone);
    Ok(tones.dither.levels(&darkness, tones.levels.unwrap_or(tones.dither.usual_levels())))
}

/// Returns a time as hours, minutes and seconds.
fn hours(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    format!("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
}
