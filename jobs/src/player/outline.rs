//! Outlines of objects, `POLYGON=[[x,y],[x,y],...]`, in lines of a file that are longer than any other: the
//! rectangle around one, read from the file a second time.

use core::fmt::Write as _;
use core::ops::Range;

use base::ports::{FileHandle, Storage, StorageError};
use base::sessions::LineBytes;
use heapless::String;

/// Number of bytes read at a time.
const CHUNK: usize = 64;
const KEY: &[u8] = b"POLYGON=";

/// Least X and Y, greatest X and Y, mm.
pub(super) type Around = [f64; 4];

/// Returns the rectangle around the outline in these bytes of a file; `None` where there is no whole one.
pub(super) fn around(
    storage: &mut impl Storage,
    file: FileHandle,
    bytes: Range<u32>,
) -> Result<Option<Around>, StorageError> {
    let mut outline = Outline::default();
    storage.seek(file, bytes.start)?;
    let mut left = bytes.len();
    while left > 0 {
        let mut chunk = [0; CHUNK];
        let room = chunk.get_mut(..left.min(CHUNK)).unwrap_or_default();
        let count = storage.read(file, room)?;
        if count == 0 {
            break;
        }
        left = left.saturating_sub(count);
        chunk.iter().take(count).for_each(|byte| outline.push(*byte));
    }
    Ok(outline.finish())
}

/// Returns the line with the rectangle in place of its outline.
pub(super) fn shortened(line: &str, [left, near, right, far]: Around) -> Option<LineBytes> {
    let at = line.as_bytes().windows(KEY.len()).position(|window| window.eq_ignore_ascii_case(KEY))?;
    let mut text = String::<{ gcode::MAX_LINE_LENGTH }>::new();
    text.push_str(line.get(..at)?).ok()?;
    write!(text, "POLYGON=[[{left:.3},{near:.3}],[{right:.3},{far:.3}]]").ok()?;
    LineBytes::from_slice(text.as_bytes()).ok()
}

/// Reader of an outline, letter by letter.
#[derive(Debug, Default)]
struct Outline {
    /// Number of letters of the key that have been seen.
    key: usize,
    /// Number of brackets that are open.
    depth: u32,
    number: String<24>,
    /// X of a point whose Y comes next.
    x: Option<f64>,
    around: Option<Around>,
    is_whole: bool,
    is_wrong: bool,
}

impl Outline {
    fn push(&mut self, byte: u8) {
        if self.key < KEY.len() {
            let expected = KEY.get(self.key).copied().unwrap_or(0);
            // The key's first letter does not come again within it.
            self.key = if byte.eq_ignore_ascii_case(&expected) { self.key + 1 } else { usize::from(byte == b'P') };
            return;
        }
        match byte {
            _ if self.is_whole => {}
            b'[' => self.depth += 1,
            b']' | b',' => {
                self.end_number();
                if byte == b']' {
                    // A point has two coordinates.
                    self.is_wrong |= self.x.is_some();
                    self.depth = self.depth.saturating_sub(1);
                    self.is_whole = self.depth == 0;
                }
            }
            b' ' => {}
            _ => self.is_wrong |= self.number.push(byte as char).is_err(),
        }
    }

    fn end_number(&mut self) {
        if self.number.is_empty() {
            return;
        }
        let number = gcode::read_f64(&self.number).filter(|number| number.is_finite());
        self.number.clear();
        let Some(number) = number else {
            self.is_wrong = true;
            return;
        };
        let Some(x) = self.x.take() else {
            self.x = Some(number);
            return;
        };
        let [left, near, right, far] = self.around.unwrap_or([x, number, x, number]);
        self.around = Some([left.min(x), near.min(number), right.max(x), far.max(number)]);
    }

    fn finish(self) -> Option<Around> {
        self.around.filter(|_| self.is_whole && !self.is_wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::Card;
    use base::ports::OpenMode;
    use proptest::prelude::*;

    fn found(line: &str) -> Option<Around> {
        let mut card = Card::with(&[]);
        let text = format!("G28\n{line}\nG1 X5\n");
        card.put("/sd/a.g", text.as_bytes());
        let file = card.open("/sd/a.g", OpenMode::Read).unwrap();
        around(&mut card, file, 4..4 + line.len() as u32).unwrap()
    }

    proptest! {
        #[test]
        fn the_rectangle_around_any_outline_is_found(points in prop::collection::vec((-200.0..500.0_f64, -200.0..500.0_f64), 1..80)) {
            let text: Vec<std::string::String> = points.iter().map(|(x, y)| format!("[{x:.3},{y:.3}]")).collect();
            let line = format!("EXCLUDE_OBJECT_DEFINE NAME=Part_1 CENTER=1,2 POLYGON=[{}]", text.join(","));
            let [left, near, right, far] = found(&line).expect("an outline");
            let ends = |of: fn(&(f64, f64)) -> f64| {
                points.iter().map(of).fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(at), high.max(at)))
            };
            let ((l, r), (n, f)) = (ends(|at| at.0), ends(|at| at.1));
            for (found, wanted) in [(left, l), (right, r), (near, n), (far, f)] {
                prop_assert!((found - wanted).abs() < 6e-4);
            }
            let shorter = shortened(&line[..line.len().min(255)], [left, near, right, far]).expect("it is shorter");
            let shorter = core::str::from_utf8(&shorter).unwrap();
            prop_assert!(shorter.starts_with("EXCLUDE_OBJECT_DEFINE NAME=Part_1 CENTER=1,2 POLYGON=[["), "{shorter}");
        }

        #[test]
        fn any_letters_are_read_or_passed_over(text in "POLYGON=[\\[\\],0-9.e-]{0,60}") {
            let _ = found(&text);
        }
    }

    #[test]
    fn what_is_no_outline_gives_none() {
        for line in
            ["", "NAME=a", "POLYGON=", "POLYGON=[[1,2],[3,4]", "POLYGON=[[1,2],[3]]", "POLYGON=[[1,x]]", "POLYGON=[]"]
        {
            assert_eq!(found(line), None, "{line}");
        }
        assert_eq!(found("A=PPOLYGON=[[1,2],[3,-4.5]] NAME=x"), Some([1.0, -4.5, 3.0, 2.0]));
    }
}
