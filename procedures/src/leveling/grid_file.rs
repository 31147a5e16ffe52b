//! Grids on the card, in Smoothieware's format: M374 saves, M374.1 deletes, M375 loads, M421 changes a point.
//!
//! `/sd/cartesian.grid`: points along X (a byte), points along Y (another, where the configuration has not
//! the same count along both), size along X and along Y, heights row by row; behind them X and Y of a start
//! that is not the origin, which Smoothieware does not have. `/sd/delta.grid`: points along a side (a byte),
//! radius, heights. Numbers are single precision, the low byte first.

use base::failure::{Answer, Failure, FailureKind, Outcome, Texts};
use base::ports::{FileHandle, OpenMode, Storage, StorageError, Wake};
use base::safe_file::{self, Draft};
use base::sessions::Reply;
use config::{Leveling, LevelingConfig, MachineConfig};
use motion::GridShape;
use program::Words;
use units::Axis;

use super::compensation::{adopt_grid, shape_in_force};
use super::grid;
use base::hands::Hands;

/// Greatest difference, mm, of sizes in a file that count as the configuration's: they are rounded to single
/// precision.
const SAME_SIZE: f64 = 1e-3;
/// Number of heights read or written at a time.
const CHUNK: usize = 32;

/// Returns the path of a strategy's file.
const fn file_path(strategy: Leveling) -> Option<&'static str> {
    match strategy {
        Leveling::CartesianGrid => Some("/sd/cartesian.grid"),
        Leveling::DeltaGrid => Some("/sd/delta.grid"),
        Leveling::ThreePoint => None,
    }
}

/// Header of a grid file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Header {
    bytes: [u8; 10],
    length: usize,
}

impl Header {
    /// Creates the header of a grid with this shape: the sizes are those of the area, or the radius.
    pub(super) fn of(strategy: Leveling, shape: &GridShape) -> Self {
        let ([nx, ny], [sx, sy]) = (shape.count, shape.step);
        let [width, depth] = [sx * (nx.saturating_sub(1)) as f64, sy * (ny.saturating_sub(1)) as f64];
        let mut header = Self { bytes: [0; 10], length: 0 };
        header.put(&[nx as u8]);
        if strategy == Leveling::DeltaGrid {
            header.put(&((0.5 * width) as f32).to_le_bytes());
            return header;
        }
        if nx != ny {
            header.put(&[ny as u8]);
        }
        header.put(&(width as f32).to_le_bytes());
        header.put(&(depth as f32).to_le_bytes());
        header
    }

    fn put(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if let Some(slot) = self.bytes.get_mut(self.length) {
                *slot = *byte;
                self.length += 1;
            }
        }
    }

    fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }

    fn byte(&self, index: usize) -> u8 {
        self.bytes.get(index).copied().unwrap_or(0)
    }

    /// Returns the number at the end of the header, or `back` numbers before it.
    fn number(&self, back: usize) -> f64 {
        let from = self.length.saturating_sub(4 * (back + 1));
        let bytes = self.bytes.get(from..from + 4).and_then(|bytes| bytes.try_into().ok());
        f64::from(f32::from_le_bytes(bytes.unwrap_or_default()))
    }

    /// Checks the header of a file against the configuration's; returns the shape of the grid, and whether
    /// its radius differs.
    pub(super) fn matches(
        &self,
        texts: &Texts,
        strategy: Leveling,
        wanted: &GridShape,
    ) -> Result<(GridShape, bool), Failure> {
        let expected = Self::of(strategy, wanted);
        let counts = if strategy == Leveling::CartesianGrid && wanted.count[0] != wanted.count[1] { 2 } else { 1 };
        for index in 0..counts {
            let (found, configured) = (self.byte(index), expected.byte(index));
            if found != configured {
                let along = if index == 0 { 'X' } else { 'Y' };
                let text = format_args!("the file has {found} points along {along}, the configuration {configured}");
                return Err(texts.refused(text));
            }
        }
        let is_same = |back: usize| {
            // A NaN in the file compares false.
            libm::fabs(self.number(back) - expected.number(back)) <= SAME_SIZE
        };
        if strategy == Leveling::DeltaGrid {
            let radius = self.number(0);
            if !(1.0..=10_000.0).contains(&radius) {
                return Err(Failure::refused(&"the radius in the file is no radius: save the grid again"));
            }
            let shape = if is_same(0) { *wanted } else { grid::around(radius, self.byte(0)) };
            return Ok((shape, !is_same(0)));
        }
        for (back, along) in [(1, 'x'), (0, 'y')] {
            if !is_same(back) {
                let (found, configured) = (self.number(back), expected.number(back));
                let text =
                    format_args!("{along}_size in the file is {found:.3} mm, in the configuration {configured:.3}");
                return Err(texts.refused(text));
            }
        }
        Ok((*wanted, false))
    }
}

/// Returns the end of a grid's file: the start of a cartesian grid that does not begin at the origin.
fn end_of(strategy: Leveling, shape: &GridShape) -> heapless::Vec<u8, 8> {
    if strategy != Leveling::CartesianGrid || shape.origin == [0.0; 2] {
        return heapless::Vec::new();
    }
    shape.origin.into_iter().flat_map(|start| (start as f32).to_le_bytes()).collect()
}

/// Returns the strategy, its file, and the grid that the configuration describes.
fn grid_wanted(leveling: &LevelingConfig) -> Result<(Leveling, &'static str, GridShape), Failure> {
    let named = leveling.strategy.and_then(|strategy| file_path(strategy).map(|path| (strategy, path)));
    let (strategy, path) = named.ok_or_else(|| {
        Failure::refused(&"no grid strategy is configured: write leveling = cartesian grid in [zprobe]")
    })?;
    let shape = grid::configured(leveling).ok_or_else(|| {
        Failure::refused(&"with only_by_two_corners a grid belongs to its probing: it is neither saved nor loaded")
    })?;
    Ok((strategy, path, shape))
}

/// M374 without a name: saves the grid.
pub(super) fn save_grid<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    let (strategy, path, wanted) = grid_wanted(&hands.config().leveling)?;
    let shape = shape_in_force(hands).ok_or_else(|| Failure::refused(&"no grid to save"))?;
    if strategy == Leveling::CartesianGrid && !is_same(&shape, &wanted) {
        return Err(Failure::refused(
            &"the grid in force is not the configured one: save it with a name, M374 P\"name\"",
        ));
    }
    let written = write_grid(hands, strategy, path, &shape);
    written.map_err(|error| hands.texts().about_file(path, error.text()))?;
    hands.say(format_args!("grid saved to {path}\n"));
    Ok(Answer::Ok)
}

/// Compares with a tolerance, since an offset that was added and taken away again leaves its rounding.
fn is_same(one: &GridShape, other: &GridShape) -> bool {
    let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| libm::fabs(a - c) < SAME_SIZE && libm::fabs(b - d) < SAME_SIZE;
    one.count == other.count && near(one.origin, other.origin) && near(one.step, other.step)
}

/// Writes the grid to a draft first, so that a power cut leaves the old file or the new.
fn write_grid<'c>(
    hands: &mut impl Hands<'c>,
    strategy: Leveling,
    path: &str,
    shape: &GridShape,
) -> Result<(), StorageError> {
    let mut draft = Draft::begin(hands.storage(), path)?;
    let mut written = draft.write(hands.storage(), Header::of(strategy, shape).as_slice()).map(|_| ());
    let mut done = 0;
    while written.is_ok() && done < shape.points() {
        let bytes = heights_from(hands, done);
        done += CHUNK;
        hands.card_at_rest();
        written = draft.write(hands.storage(), &bytes).map(|_| ());
        hands.wait(Wake::Any).whatever_happens();
    }
    if written.is_ok() {
        written = draft.write(hands.storage(), &end_of(strategy, shape)).map(|_| ());
    }
    if let Err(error) = written {
        draft.give_up(hands.storage());
        return Err(error);
    }
    hands.put_in_place(draft)
}

/// Returns the bytes of the next heights in force.
fn heights_from<'c>(hands: &mut impl Hands<'c>, done: usize) -> heapless::Vec<u8, { 4 * CHUNK }> {
    let mut bytes = heapless::Vec::new();
    hands.motion(|motion| {
        let heights = motion.compensation().grid().map_or(&[][..], |grid| grid.heights());
        for height in heights.iter().skip(done).take(CHUNK) {
            // The buffer has room for a chunk.
            let _ = bytes.extend_from_slice(&height.to_le_bytes());
        }
    });
    bytes
}

/// M374.1 without a name: deletes the grid's file.
///
/// # Errors
/// When no grid is configured, or the card refuses.
pub(super) fn delete_grid(
    texts: &Texts,
    config: &MachineConfig,
    storage: &mut impl Storage,
    reply: &mut Reply<'_>,
) -> Outcome {
    let (_, path, _) = grid_wanted(&config.leveling)?;
    let removed = safe_file::remove(storage, path);
    removed.map_err(|error| texts.about_file(path, error.text()))?;
    reply.say(format_args!("{path} deleted\n"));
    Ok(Answer::Ok)
}

/// M375 without a name: loads the grid.
pub(super) fn load_grid<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    let texts = hands.texts();
    let (strategy, path, wanted) = grid_wanted(&hands.config().leveling)?;
    // Motion's draft is about to be filled: no move may be on its way.
    hands.standstill()?;
    let about = |failure: Failure| match failure.kind {
        FailureKind::Refused => texts.refused(format_args!("{path}: {}", texts.of(failure))),
        _ => failure,
    };
    let failed = |error: StorageError| texts.about_file(path, error.text());
    safe_file::settle(hands.storage(), path).map_err(failed)?;
    let file = hands.storage().open(path, OpenMode::Read).map_err(failed)?;
    let read = read_grid(hands, file, strategy, &wanted);
    // The file was only read: a failing close loses nothing.
    let _ = hands.storage().close(file);
    let (shape, other_radius) = read.map_err(about)?;
    adopt_grid(hands, &shape).map_err(about)?;
    if other_radius {
        let radius = -shape.origin[0];
        hands.say(format_args!("// WARNING: the grid's radius is {radius:.3} mm, not the configured one\n"));
    }
    let ([nx, ny], [sx, sy]) = (shape.count, shape.step);
    let (width, depth) = (sx * (nx - 1) as f64, sy * (ny - 1) as f64);
    hands.say(format_args!("grid loaded, {nx} x {ny} points on {width:.3} x {depth:.3} mm\n"));
    Ok(Answer::Ok)
}

/// Reads header and heights; the heights are then in the draft.
fn read_grid<'c>(
    hands: &mut impl Hands<'c>,
    file: FileHandle,
    strategy: Leveling,
    wanted: &GridShape,
) -> Result<(GridShape, bool), Failure> {
    let texts = hands.texts();
    let failed = |error: StorageError| texts.because(error.text());
    let mut header = Header::of(strategy, wanted);
    let length = header.length;
    let begin = header.bytes.get_mut(..length).unwrap_or_default();
    if !fill(hands.storage(), file, begin).map_err(failed)? {
        return Err(Failure::refused(&"the file is too short to be a grid"));
    }
    let shape = header.matches(texts, strategy, wanted)?;
    let end = end_of(strategy, wanted);
    let expected = length + 4 * wanted.points() + end.len();
    let size = hands.storage().size(file).map_err(failed)? as usize;
    if size != expected {
        let text = format_args!("the file has {size} bytes, such a grid has {expected}: save it again");
        return Err(texts.refused(text));
    }
    let mut done = 0;
    while done < wanted.points() {
        let count = (wanted.points() - done).min(CHUNK);
        let mut bytes = [0; 4 * CHUNK];
        let chunk = bytes.get_mut(..4 * count).unwrap_or_default();
        if !fill(hands.storage(), file, chunk).map_err(failed)? {
            return Err(Failure::refused(&"the file ends before its grid does"));
        }
        hands.motion(|motion| {
            for (to, bytes) in motion.draft().iter_mut().skip(done).zip(chunk.chunks_exact(4)) {
                *to = f32::from_le_bytes(bytes.try_into().unwrap_or_default());
            }
        });
        done += count;
        hands.wait(Wake::Any).whatever_happens();
    }
    let mut bytes = [0; 8];
    let begin = bytes.get_mut(..end.len()).unwrap_or_default();
    if !fill(hands.storage(), file, begin).map_err(failed)? || *begin != *end {
        return Err(Failure::refused(&"the grid in the file begins elsewhere: x_start and y_start were others"));
    }
    Ok(shape)
}

/// Fills a buffer; returns false when the file ends before.
fn fill(storage: &mut impl Storage, file: FileHandle, mut buffer: &mut [u8]) -> Result<bool, StorageError> {
    while !buffer.is_empty() {
        match storage.read(file, buffer)? {
            0 => return Ok(false),
            count => buffer = buffer.get_mut(count..).unwrap_or_default(),
        }
    }
    Ok(true)
}

/// M421: changes a height of the grid in force, or of a flat grid, at column I and row J counted from 0, at
/// the point nearest to X and Y, or at that nearest to the tool (C): Z is the height, Q is added to it.
pub fn grid_point<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    let (_, _, wanted) = grid_wanted(&hands.config().leveling)?;
    hands.standstill()?;
    let shape = shape_in_force(hands).unwrap_or(wanted);
    let here = hands.position();
    let point = named_point(&shape, words, [here[Axis::X], here[Axis::Y]]);
    let (height, more) = (words.get('Z'), words.get('Q'));
    let (Some(point), true) = (point, height.is_some() != more.is_some()) else {
        return Err(Failure::refused(&"M421 takes I and J (column and row from 0), X and Y, or C; and Z or Q"));
    };
    hands.motion(|motion| {
        motion.copy_to_draft();
        if let Some(to) = motion.draft().get_mut(point) {
            *to = height.unwrap_or(f64::from(*to) + more.unwrap_or(0.0)) as f32;
        }
    });
    adopt_grid(hands, &shape)
}

/// Returns the index of the point that the words of M421 mean.
fn named_point(shape: &GridShape, words: &Words<'_>, here: [f64; 2]) -> Option<usize> {
    let [nx, ny] = shape.count;
    let index = |letter: char, count: usize| {
        let word = words.get(letter)?;
        (0..count).find(|index| *index as f64 == word)
    };
    let nearest = |axis: usize, place: f64| {
        let get = |of: [f64; 2]| of.get(axis).copied().unwrap_or(0.0);
        let cells = (place - get(shape.origin)) / get(shape.step);
        let last = shape.count.get(axis).copied().unwrap_or(1).saturating_sub(1);
        units::within(libm::round(cells), 0.0, last as f64) as usize
    };
    let (column, row) = if words.has('C') {
        (nearest(0, here[0]), nearest(1, here[1]))
    } else if let (Some(x), Some(y)) = (words.get('X'), words.get('Y')) {
        (nearest(0, x), nearest(1, y))
    } else {
        (index('I', nx)?, index('J', ny)?)
    };
    Some(row * nx + column)
}
