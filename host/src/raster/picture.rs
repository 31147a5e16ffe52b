//! Pictures: a PNG as its brightness, laid onto another number of pixels, with its tones changed.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use png::{BitDepth, ColorType, Decoder, Transformations};

/// Greatest number of pixels of a picture, read or burnt.
pub const MOST_PIXELS: usize = 100_000_000;
/// Shares of red, green and blue in brightness (ITU-R BT.709).
const SHARES: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Brightness of pixels, 0 for black to 1 for white, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels of a row.
    pub columns: usize,
    pub rows: usize,
    pub light: Vec<f32>,
}

/// Change of a picture's tones.
#[derive(Clone, Copy, Debug)]
pub struct Tone {
    /// Share of white that is added.
    pub brightness: f32,
    /// Factor of the distance from middle grey.
    pub contrast: f32,
    /// Exponent: brightness becomes its power of 1 / gamma.
    pub gamma: f32,
    /// What is white is burnt, and what is black is not.
    pub inverts: bool,
    /// Left and right change places.
    pub mirrors: bool,
}

impl Picture {
    /// Reads a PNG of any kind: grey, colours, palette, 1 to 16 bits; what is transparent is white.
    pub fn read(path: &Path) -> Result<Self> {
        let file = File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::decode(BufReader::new(file)).with_context(|| format!("cannot read {} as a PNG", path.display()))
    }

    /// Reads a PNG from a stream; see [`Self::read`].
    pub fn decode(stream: impl std::io::BufRead + std::io::Seek) -> Result<Self> {
        let mut decoder = Decoder::new(stream);
        decoder.set_transformations(Transformations::EXPAND);
        let mut reader = decoder.read_info()?;
        let [columns, rows] = [reader.info().width as usize, reader.info().height as usize];
        ensure_fits(columns, rows)?;
        let size = reader.output_buffer_size().context("the picture is too large")?;
        let mut bytes = vec![0; size];
        let frame = reader.next_frame(&mut bytes)?;
        let channels = match frame.color_type {
            ColorType::Grayscale => 1,
            ColorType::GrayscaleAlpha => 2,
            ColorType::Rgb => 3,
            ColorType::Rgba => 4,
            ColorType::Indexed => bail!("its palette is missing"),
        };
        let values: Vec<f32> = match frame.bit_depth {
            BitDepth::Sixteen => {
                bytes.chunks_exact(2).map(|pair| f32::from(u16::from_be_bytes([pair[0], pair[1]])) / 65_535.0).collect()
            }
            _ => bytes.iter().map(|byte| f32::from(*byte) / 255.0).collect(),
        };
        let light = values.chunks_exact(channels).take(columns * rows).map(brightness).collect();
        Ok(Self { columns, rows, light })
    }

    /// Returns the picture on so many columns and rows: each pixel has the mean of what lies under it.
    pub fn resized(&self, columns: usize, rows: usize) -> Self {
        let wide = self.light.chunks_exact(self.columns).flat_map(|row| means(row, columns)).collect();
        let wide = Self { columns, rows: self.rows, light: wide };
        let turned = wide.turned();
        let tall = turned.light.chunks_exact(self.rows).flat_map(|column| means(column, rows)).collect();
        Self { columns: rows, rows: columns, light: tall }.turned()
    }

    /// Returns the picture with columns for rows.
    fn turned(&self) -> Self {
        let column = |column| self.light.iter().skip(column).step_by(self.columns).copied();
        let light = (0..self.columns).flat_map(column).collect();
        Self { columns: self.rows, rows: self.columns, light }
    }

    /// Returns how dark each pixel is to be burnt, from 0 for not at all to 1.
    pub fn darkness(mut self, tone: &Tone) -> Self {
        for light in &mut self.light {
            let toned = (*light - 0.5) * tone.contrast + 0.5 + tone.brightness;
            let toned = toned.clamp(0.0, 1.0).powf(1.0 / tone.gamma);
            *light = if tone.inverts { toned } else { 1.0 - toned };
        }
        if tone.mirrors {
            self.light.chunks_exact_mut(self.columns).for_each(<[f32]>::reverse);
        }
        self
    }
}

/// Fails when there are no pixels, or more than fit.
pub fn ensure_fits(columns: usize, rows: usize) -> Result<()> {
    let pixels = columns.saturating_mul(rows);
    ensure!(pixels > 0, "{columns} x {rows} pixels are none");
    ensure!(pixels <= MOST_PIXELS, "{columns} x {rows} pixels are more than {MOST_PIXELS}");
    Ok(())
}

/// Returns the brightness of a pixel, before white.
fn brightness(channels: &[f32]) -> f32 {
    let over_white = |light: f32, opacity: f32| light * opacity + 1.0 - opacity;
    let of_colours = |colours: &[f32]| colours.iter().zip(SHARES).map(|(colour, share)| colour * share).sum::<f32>();
    match channels {
        [grey] => *grey,
        [grey, opacity] => over_white(*grey, *opacity),
        [colours @ .., opacity] if colours.len() == SHARES.len() => over_white(of_colours(colours), *opacity),
        colours => of_colours(colours),
    }
}

/// Returns the means of so many equal parts of a row.
fn means(row: &[f32], count: usize) -> Vec<f32> {
    if row.len() == count {
        return row.to_vec();
    }
    let mut sums = Vec::with_capacity(row.len() + 1);
    sums.push(0.0);
    let mut sum = 0.0;
    for light in row {
        sum += f64::from(*light);
        sums.push(sum);
    }
    let part = row.len() as f64 / count as f64;
    let before = |place: f64| {
        let whole = (place as usize).min(row.len());
        sums[whole] + row.get(whole).map_or(0.0, |light| f64::from(*light) * (place - whole as f64))
    };
    let mean = |index: usize| (before((index + 1) as f64 * part) - before(index as f64 * part)) / part;
    (0..count).map(|index| mean(index).clamp(0.0, 1.0) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Cursor;

    const PLAIN: Tone = Tone { brightness: 0.0, contrast: 1.0, gamma: 1.0, inverts: false, mirrors: false };

    fn png(columns: u32, color: ColorType, depth: BitDepth, palette: Option<(&[u8], &[u8])>, bytes: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, columns, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if let Some((colours, opacities)) = palette {
            encoder.set_palette(colours);
            encoder.set_trns(opacities);
        }
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(bytes).expect("a row");
        writer.finish().expect("an end");
        file
    }

    fn decoded(file: Vec<u8>) -> Vec<f32> {
        Picture::decode(Cursor::new(file)).expect("a picture").light
    }

    fn is_near(light: &[f32], wanted: &[f32]) -> bool {
        light.len() == wanted.len() && light.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-5)
    }

    #[test]
    fn every_kind_of_png_is_read() {
        use BitDepth::{Eight, One, Sixteen, Two};
        use ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
        let grey = |depth, bytes: &[u8], columns| decoded(png(columns, Grayscale, depth, None, bytes));
        assert!(is_near(&grey(Eight, &[0, 51, 255], 3), &[0.0, 0.2, 1.0]));
        assert!(is_near(&grey(Sixteen, &[0, 0, 0x33, 0x33, 255, 255], 3), &[0.0, 0.2, 1.0]));
        assert!(is_near(&grey(One, &[0b0110_0000], 4), &[0.0, 1.0, 1.0, 0.0]));
        assert!(is_near(&decoded(png(2, GrayscaleAlpha, Eight, None, &[0, 255, 0, 51])), &[0.0, 0.8]));
        assert!(is_near(&decoded(png(2, Rgb, Eight, None, &[0, 255, 0, 255, 255, 255])), &[0.7152, 1.0]));
        assert!(is_near(&decoded(png(2, Rgba, Eight, None, &[255, 0, 0, 255, 9, 9, 9, 0])), &[0.2126, 1.0]));
        let palette: (&[u8], &[u8]) = (&[255, 0, 0, 0, 0, 0], &[255, 102]);
        assert!(is_near(&decoded(png(2, Indexed, Two, Some(palette), &[0b0001_0000])), &[0.2126, 0.6]));
    }

    #[test]
    fn what_is_no_png_is_said() {
        let why = |bytes: &[u8]| format!("{:#}", Picture::decode(Cursor::new(bytes)).expect_err("no picture"));
        assert!(why(b"\xff\xd8\xff\xe0JFIF").contains("ignature"), "{}", why(b"\xff\xd8\xff\xe0JFIF"));
        let whole = png(200, ColorType::Grayscale, BitDepth::Eight, None, &[7; 200]);
        assert!(!why(&whole[..whole.len() / 2]).is_empty());
        let mut vast = whole;
        vast[16..20].copy_from_slice(&200_000_u32.to_be_bytes());
        vast[20..24].copy_from_slice(&200_000_u32.to_be_bytes());
        assert!(!why(&vast).is_empty());
        let error = Picture::read(Path::new("/no/such.png")).expect_err("no file");
        assert!(format!("{error:#}").contains("cannot read /no/such.png"));
    }

    #[test]
    fn tones_change_as_asked() {
        let row = |tone: Tone| {
            let picture = Picture { columns: 3, rows: 1, light: vec![0.0, 0.25, 1.0] };
            picture.darkness(&tone).light
        };
        assert!(is_near(&row(PLAIN), &[1.0, 0.75, 0.0]));
        assert!(is_near(&row(Tone { inverts: true, ..PLAIN }), &[0.0, 0.25, 1.0]));
        assert!(is_near(&row(Tone { mirrors: true, ..PLAIN }), &[0.0, 0.75, 1.0]));
        assert!(is_near(&row(Tone { gamma: 2.0, ..PLAIN }), &[1.0, 0.5, 0.0]));
        assert!(is_near(&row(Tone { brightness: 0.1, ..PLAIN }), &[0.9, 0.65, 0.0]));
        assert!(is_near(&row(Tone { contrast: 2.0, ..PLAIN }), &[1.0, 1.0, 0.0]));
    }

    proptest! {
        #[test]
        fn another_size_keeps_the_mean(
            (columns, rows, light) in (1..20_usize, 1..20_usize)
                .prop_flat_map(|(x, y)| (Just(x), Just(y), proptest::collection::vec(0.0..1.0_f32, x * y))),
            to in (1..40_usize, 1..40_usize),
        ) {
            let mean = |light: &[f32]| light.iter().sum::<f32>() / light.len() as f32;
            let picture = Picture { columns, rows, light };
            let resized = picture.resized(to.0, to.1);
            prop_assert_eq!((resized.columns, resized.rows, resized.light.len()), (to.0, to.1, to.0 * to.1));
            prop_assert!((mean(&resized.light) - mean(&picture.light)).abs() < 1e-4);
            prop_assert_eq!(picture.resized(columns, rows), picture.clone());
            let thrice = picture.resized(3 * columns, 3 * rows);
            for (index, light) in thrice.light.iter().enumerate() {
                let source = index / (9 * columns) * columns + index % (3 * columns) / 3;
                prop_assert!((light - picture.light[source]).abs() < 1e-4);
            }
        }
    }
}
