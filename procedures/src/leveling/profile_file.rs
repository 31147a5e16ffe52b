//! Bed mesh as a file of text, `/sd/NAME.mesh`:
//!
//! ```text
//! ; Velvet bed mesh: mm; rows along X, the first has the first Y
//! mesh 1
//! points 3 2
//! origin 10 20.5
//! step 40 55
//! heights
//! 0 0.0125 -0.03
//! 0.021 0.04 0
//! ```
//!
//! Words stand apart by blanks or line ends; `;` begins a comment. Numbers read back to the last bit.

use core::fmt::Write as _;

use heapless::String;
use motion::GridShape;

/// Version of the format that is written and read.
const VERSION: f64 = 1.0;
/// Length of the longest word.
const WORD: usize = 32;

/// Returns the text before the heights.
#[must_use]
pub fn heading(shape: &GridShape) -> String<192> {
    let ([nx, ny], [x, y], [sx, sy]) = (shape.count, shape.origin, shape.step);
    let mut text = String::new();
    // The text has room for four numbers of at most 24 letters.
    let _ = write!(
        text,
        "; Velvet bed mesh: mm; rows along X, the first has the first Y\nmesh 1\npoints {nx} {ny}\norigin {x} {y}\nstep {sx} {sy}\nheights\n"
    );
    text
}

/// Returns a height of the file, with the blank or line end behind it.
#[must_use]
pub fn height(shape: &GridShape, index: usize, height: f32) -> String<32> {
    let ends_row = (index + 1).is_multiple_of(shape.count[0].max(1));
    let mut text = String::new();
    let _ = write!(text, "{height}{}", if ends_row { '\n' } else { ' ' });
    text
}

/// Flaw of a file, with its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileFlaw {
    /// Number of the line, from 1.
    pub line: u32,
    /// Description of the flaw.
    pub what: &'static str,
}

impl core::fmt::Display for FileFlaw {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "line {}: {}", self.line, self.what)
    }
}

/// State of the parser: the kind of the next words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Expects {
    /// A key is expected.
    Key,
    /// The value with this number of the key is expected.
    Value(Key, usize),
    Heights,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Key {
    Version,
    Points,
    Origin,
    Step,
}

impl Key {
    const fn values(self) -> usize {
        match self {
            Self::Version => 1,
            _ => 2,
        }
    }
}

/// Parser of a mesh file, byte by byte.
#[derive(Debug)]
pub struct ProfileReader {
    word: String<WORD>,
    in_comment: bool,
    line: u32,
    expects: Expects,
    shape: GridShape,
    heights: usize,
}

impl Default for ProfileReader {
    fn default() -> Self {
        Self {
            word: String::new(),
            in_comment: false,
            line: 1,
            expects: Expects::Key,
            shape: GridShape { origin: [f64::NAN; 2], step: [f64::NAN; 2], count: [0; 2] },
            heights: 0,
        }
    }
}

impl ProfileReader {
    /// Takes the next byte; passes heights to `height`, in their order from 0, as they come.
    ///
    /// # Errors
    /// The flaw of the file.
    pub fn push(&mut self, byte: u8, height: &mut impl FnMut(usize, f32)) -> Result<(), FileFlaw> {
        match byte {
            b'\n' => {
                self.end_word(height)?;
                (self.in_comment, self.line) = (false, self.line.saturating_add(1));
            }
            _ if self.in_comment => {}
            b';' => {
                self.end_word(height)?;
                self.in_comment = true;
            }
            b' ' | b'\t' | b'\r' => self.end_word(height)?,
            0x21..=0x7E => {
                let pushed = self.word.push(byte as char);
                pushed.map_err(|_| self.flaw("this is no mesh: a word is too long"))?;
            }
            _ => return Err(self.flaw("this is no mesh: it is no text")),
        }
        Ok(())
    }

    /// Ends the file; returns the grid whose heights were passed.
    ///
    /// # Errors
    /// The missing part of the file.
    pub fn finish(mut self, height: &mut impl FnMut(usize, f32)) -> Result<GridShape, FileFlaw> {
        self.end_word(height)?;
        match self.expects {
            Expects::Heights if self.heights == self.shape.points() => Ok(self.shape),
            Expects::Heights => Err(self.flaw("heights are missing: the file was cut")),
            _ => Err(self.flaw("this is no mesh: it has no heights")),
        }
    }

    const fn flaw(&self, what: &'static str) -> FileFlaw {
        FileFlaw { line: self.line, what }
    }

    fn end_word(&mut self, height: &mut impl FnMut(usize, f32)) -> Result<(), FileFlaw> {
        if self.word.is_empty() {
            return Ok(());
        }
        let word = core::mem::take(&mut self.word);
        match self.expects {
            Expects::Key => self.begin_key(&word),
            Expects::Value(key, index) => self.take_value(key, index, &word),
            Expects::Heights => {
                if self.heights >= self.shape.points() {
                    return Err(self.flaw("there are more heights than points"));
                }
                height(self.heights, self.number(&word)? as f32);
                self.heights += 1;
                Ok(())
            }
        }
    }

    fn begin_key(&mut self, word: &str) -> Result<(), FileFlaw> {
        let key = match word {
            "mesh" => Key::Version,
            "points" => Key::Points,
            "origin" => Key::Origin,
            "step" => Key::Step,
            "heights" => {
                let has_place = self.shape.origin.iter().chain(&self.shape.step).all(|number| number.is_finite());
                if self.shape.points() == 0 || !has_place {
                    return Err(self.flaw("points, origin and step come before the heights"));
                }
                self.expects = Expects::Heights;
                return Ok(());
            }
            _ => return Err(self.flaw("this is no mesh: mesh, points, origin, step or heights was expected")),
        };
        self.expects = Expects::Value(key, 0);
        Ok(())
    }

    fn take_value(&mut self, key: Key, index: usize, word: &str) -> Result<(), FileFlaw> {
        let number = self.number(word)?;
        match key {
            Key::Version if number != VERSION => return Err(self.flaw("the mesh is of another version")),
            Key::Version => {}
            Key::Points => {
                if !(2.0..=motion::MOST_SIDE as f64).contains(&number) || libm::floor(number) != number {
                    return Err(self.flaw("a mesh has 2 to 50 points along X and along Y"));
                }
                set(&mut self.shape.count, index, number as usize);
            }
            Key::Origin => set(&mut self.shape.origin, index, number),
            Key::Step => set(&mut self.shape.step, index, number),
        }
        let next = index + 1;
        self.expects = if next == key.values() { Expects::Key } else { Expects::Value(key, next) };
        Ok(())
    }

    fn number(&self, word: &str) -> Result<f64, FileFlaw> {
        let number = gcode::read_f64(word).filter(|number| number.is_finite());
        number.ok_or_else(|| self.flaw("a number was expected"))
    }
}

fn set<T>(pair: &mut [T; 2], index: usize, value: T) {
    if let Some(slot) = pair.get_mut(index) {
        *slot = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::string::String as Text;
    use std::vec::Vec;

    fn read(text: &[u8]) -> Result<(GridShape, Vec<f32>), FileFlaw> {
        let (mut reader, mut heights) = (ProfileReader::default(), Vec::new());
        let mut take = |index: usize, height: f32| {
            assert_eq!(index, heights.len());
            heights.push(height);
        };
        for byte in text {
            reader.push(*byte, &mut take)?;
        }
        let shape = reader.finish(&mut take)?;
        Ok((shape, heights))
    }

    fn written(shape: &GridShape, heights: &[f32]) -> Text {
        let mut text = Text::from(heading(shape).as_str());
        heights.iter().enumerate().for_each(|(index, z)| text.push_str(&height(shape, index, *z)));
        text
    }

    fn meshes() -> impl Strategy<Value = (GridShape, Vec<f32>)> {
        let places = prop::array::uniform2(-300.0..300.0_f64);
        (2_usize..12, 2_usize..12, places.clone(), places).prop_flat_map(|(nx, ny, origin, step)| {
            let shape = GridShape { origin, step, count: [nx, ny] };
            (Just(shape), prop::collection::vec(-5.0..5.0_f32, nx * ny))
        })
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back_to_the_last_bit((shape, heights) in meshes()) {
            let text = written(&shape, &heights);
            prop_assert_eq!(read(text.as_bytes()), Ok((shape, heights)));
        }

        #[test]
        fn a_file_that_was_cut_or_grew_is_no_mesh((shape, heights) in meshes(), at in 0.0..1.0_f64) {
            let text = written(&shape, &heights);
            let cut = &text[..(at * (text.len() - 2) as f64) as usize];
            // Only a cut within the last number may leave a number.
            if cut.len() < text.trim_end().rfind([' ', '\n']).unwrap_or(0) {
                prop_assert!(read(cut.as_bytes()).is_err(), "{}", cut);
            }
            prop_assert!(read((text + "0.1\n").as_bytes()).is_err());
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = read(&bytes);
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, told) in [
            ("", "line 1: this is no mesh: it has no heights"),
            ("G1 X2\n", "line 1: this is no mesh: mesh, points, origin, step or heights was expected"),
            ("mesh 2", "line 1: the mesh is of another version"),
            ("mesh 1\npoints 1 3", "line 2: a mesh has 2 to 50 points along X and along Y"),
            ("mesh 1\npoints 2 2.5", "line 2: a mesh has 2 to 50 points along X and along Y"),
            ("mesh 1\npoints 2 2\nheights", "line 3: points, origin and step come before the heights"),
            ("mesh 1\norigin 0 x", "line 2: a number was expected"),
            ("points 2 2 origin 0 0 step 9 9 heights\n0 0\n0 nan", "line 3: a number was expected"),
            ("points 2 2 origin 0 0 step 9 9 heights\n0 0\n0\n", "line 4: heights are missing: the file was cut"),
            ("\u{e4}", "line 1: this is no mesh: it is no text"),
        ] {
            let flaw = read(text.as_bytes()).expect_err(text);
            assert_eq!(std::format!("{flaw}"), told);
        }
        let text = "; by hand\nmesh 1 ; first\nstep 10 -20\r\norigin 1 2\npoints 2 2\nheights 0 .5 ; a row\n-1 1e-2";
        let shape = GridShape { origin: [1.0, 2.0], step: [10.0, -20.0], count: [2, 2] };
        assert_eq!(read(text.as_bytes()), Ok((shape, std::vec![0.0, 0.5, -1.0, 0.01])));
    }
}
