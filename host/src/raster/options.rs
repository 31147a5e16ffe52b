//! Options of `velvet raster`, and their ranges.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};

use super::dither::{Dither, MOST_LEVELS};
use super::writer::Powers;

/// Millimetres of an inch.
const INCH: f64 = 25.4;
/// Sides of pixels that are taken, mm.
const PIXELS_MM: [f64; 2] = [0.001, 100.0];

/// What `velvet raster` takes.
#[derive(Clone, Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Options {
    /// The picture, a PNG
    pub picture: PathBuf,
    /// File for the G-code [default: the picture's name with .gcode]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Page that shows what the G-code burns [default: the output's name with .html]
    #[arg(long, value_name = "HTML")]
    pub page: Option<PathBuf>,
    /// No page
    #[arg(long, conflicts_with = "page")]
    pub no_page: bool,
    /// Configuration of the machine: its travel, speeds, accelerations, S of full power
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Place and size")]
    pub place: Place,
    #[command(flatten, next_help_heading = "Tones")]
    pub tones: Tones,
    #[command(flatten, next_help_heading = "Power and motion")]
    pub motion: MotionOptions,
}

/// Place and size of the picture.
#[derive(Clone, Debug, clap::Args)]
pub struct Place {
    /// Width of the picture, mm [default: by the height, or a pixel of the laser for each of the picture]
    #[arg(long, value_name = "MM")]
    pub width: Option<f64>,
    /// Height of the picture, mm [default: by the width]
    #[arg(long, value_name = "MM")]
    pub height: Option<f64>,
    /// Side of a laser's pixel and distance of its rows, mm
    #[arg(long, value_name = "MM", default_value_t = 0.1)]
    pub pixel: f64,
    /// The same as pixels of an inch
    #[arg(long, value_name = "N", conflicts_with = "pixel")]
    pub dpi: Option<f64>,
    /// Lower left corner of the picture, mm
    #[arg(long, value_name = "X,Y", default_value = "0,0", value_parser = corner, allow_hyphen_values = true)]
    pub at: [f64; 2],
    /// Change left and right, for what is seen from behind
    #[arg(long)]
    pub mirror: bool,
}

/// From the picture's tones to levels of power.
#[derive(Clone, Debug, clap::Args)]
pub struct Tones {
    /// Way from grey to levels of power
    #[arg(long, value_enum, default_value_t)]
    pub dither: Dither,
    /// Number of levels of power, 0 among them, 2 to 256 [default: 256 with --dither none, else 2]
    #[arg(long, value_name = "N")]
    pub levels: Option<u16>,
    /// Burn what is white
    #[arg(long)]
    pub invert: bool,
    /// Share of white that is added, -1 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub brightness: f32,
    /// Factor of the distance from middle grey, 0 to 100
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub contrast: f32,
    /// Above 1 middle tones become lighter, below 1 darker; 0.05 to 20
    #[arg(long, value_name = "GAMMA", default_value_t = 1.0)]
    pub gamma: f32,
}

/// Power and motion.
#[derive(Clone, Debug, clap::Args)]
pub struct MotionOptions {
    /// Speed of the rows, mm/min
    #[arg(long, value_name = "MM/MIN")]
    pub feed: f64,
    /// Power of black, in percent of full power, or as S600
    #[arg(long, value_name = "POWER", default_value = "100")]
    pub power: String,
    /// Power of the lightest grey that is burnt at all, the same
    #[arg(long, value_name = "POWER", default_value = "0")]
    pub power_min: String,
    /// S of full power [default: maximum_s_value of the configuration, or 1]
    #[arg(long, value_name = "S")]
    pub scale: Option<f64>,
    /// Constant power (M3) instead of power by the speed (M4)
    #[arg(long)]
    pub m3: bool,
    /// Air assist: M8 before the picture, M9 behind it
    #[arg(long)]
    pub air: bool,
    /// Acceleration along the rows, mm/s^2, where there is no --config
    #[arg(long, value_name = "MM/S^2", conflicts_with = "config")]
    pub acceleration: Option<f64>,
    /// Go along columns, Y, instead of rows, X
    #[arg(long)]
    pub vertical: bool,
    /// Burn there and back (the default)
    #[arg(long)]
    pub both_directions: bool,
    /// Burn to the right (or up) only
    #[arg(long, conflicts_with_all = ["both_directions", "reverse_offset"])]
    pub one_way: bool,
    /// Way by which rows that go back are moved, mm: for play, and for a laser that is late
    #[arg(long, value_name = "MM", default_value_t = 0.0)]
    pub reverse_offset: f64,
}

/// Fails where an option is out of its range.
pub fn check(options: &Options) -> Result<()> {
    let Options { place, tones, motion, .. } = options;
    let positive = |name: &str, value: Option<f64>| {
        let is_so = value.is_none_or(|value| value.is_finite() && value > 0.0);
        ensure!(is_so, "{name} must be above 0");
        Ok(())
    };
    positive("--width", place.width)?;
    positive("--height", place.height)?;
    positive("--dpi", place.dpi)?;
    positive("--feed", Some(motion.feed))?;
    positive("--scale", motion.scale)?;
    positive("--acceleration", motion.acceleration)?;
    let [least, most] = PIXELS_MM;
    ensure!((least..=most).contains(&pixel(place)), "a pixel of {} mm is not {least} to {most} mm", pixel(place));
    ensure!(place.at.iter().all(|mm| mm.abs() < 1e5), "--at is further than 100 m");
    ensure!(motion.reverse_offset.abs() < 100.0, "--reverse-offset is not within 100 mm");
    ensure!((-1.0..=1.0).contains(&tones.brightness), "--brightness is not -1 to 1");
    ensure!((0.0..=100.0).contains(&tones.contrast), "--contrast is not 0 to 100");
    ensure!((0.05..=20.0).contains(&tones.gamma), "--gamma is not 0.05 to 20");
    let levels = tones.levels.unwrap_or(2);
    ensure!((2..=MOST_LEVELS).contains(&levels), "--levels is not 2 to {MOST_LEVELS}");
    let is_threshold = tones.dither == Dither::Threshold;
    ensure!(!is_threshold || levels == 2, "--dither threshold has two levels: --dither none has {levels}");
    Ok(())
}

/// Returns the side of a pixel, mm.
pub fn pixel(place: &Place) -> f64 {
    place.dpi.map_or(place.pixel, |dpi| INCH / dpi)
}

/// Returns the powers of levels.
pub fn powers(motion: &MotionOptions, scale: f64) -> Result<Powers> {
    let [most, least] = [("--power", &motion.power), ("--power-min", &motion.power_min)].map(|(name, text)| {
        let (number, unit) = match text.strip_prefix(['S', 's']) {
            Some(s) => (s, 1.0),
            None => (text.strip_suffix('%').unwrap_or(text), scale / 100.0),
        };
        let s = number.parse::<f64>().ok().map(|number| number * unit);
        let s = s.filter(|s| (0.0..=scale * (1.0 + 1e-9)).contains(s));
        s.with_context(|| format!("{name} {text} is neither 0 to 100 percent nor S0 to S{scale}"))
    });
    let (most, least) = (most?, least?);
    ensure!(most > 0.0, "--power 0 burns nothing");
    ensure!(least <= most, "--power-min {} is more than --power {}", motion.power_min, motion.power);
    Ok(Powers { scale, most, least })
}

/// Reads a place X,Y.
fn corner(text: &str) -> Result<[f64; 2], String> {
    let read = |text: &str| text.trim().parse::<f64>().ok().filter(|mm| mm.is_finite());
    let place = text.split_once(',').and_then(|(x, y)| Some([read(x)?, read(y)?]));
    place.ok_or_else(|| "X,Y in mm is needed, such as 100,20".to_owned())
}
