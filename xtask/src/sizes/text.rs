//! Counts the image's constants by kind (text, addresses, zeros, the rest), and finds repeated texts.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use object::{Object, ObjectSection};

use crate::memory;

/// So many letters in a row are text.
const TEXT: usize = 6;
/// So long a text is worth finding twice.
const REPEATED: usize = 24;
/// So many of these are listed.
const LISTED: usize = 20;

/// Bytes of `.rodata` by kind.
#[derive(Debug, Default, PartialEq, Eq)]
struct Kinds {
    text: usize,
    /// Words that are addresses of the chip's memories.
    addresses: usize,
    zeros: usize,
    rest: usize,
}

/// Prints the kinds, and the longest texts that are there more than once.
pub fn report(elf: &[u8]) -> Result<()> {
    let file = object::File::parse(elf).context("not an ELF file")?;
    let section = file.section_by_name(".rodata").context("no .rodata")?;
    let data = section.data()?;
    let is_text = text_of(data);
    let Kinds { text, addresses, zeros, rest } = kinds(data, &is_text);
    for (kind, bytes) in [("text", text), ("addresses", addresses), ("zeros", zeros), ("rest", rest)] {
        println!("{kind:>10} {bytes:>8} bytes");
    }
    println!("{:>10} {:>8} bytes", ".rodata", data.len());
    println!("\ntexts that are there more than once");
    for (text, times) in repeated(data, &is_text).into_iter().take(LISTED) {
        println!("{:>4} bytes {times} times  {text:?}", text.len());
    }
    Ok(())
}

/// Whether a byte is text.
fn text_of(data: &[u8]) -> Vec<bool> {
    let is_letter = |byte: &u8| matches!(byte, b' '..=b'~' | b'\n' | b'\t');
    let mut marks = Vec::with_capacity(data.len());
    for run in data.chunk_by(|a, b| is_letter(a) == is_letter(b)) {
        let is_text = run.len() >= TEXT && run.first().is_some_and(is_letter);
        marks.resize(marks.len() + run.len(), is_text);
    }
    marks
}

fn kinds(data: &[u8], is_text: &[bool]) -> Kinds {
    let mut kinds = Kinds::default();
    for (word, marks) in data.chunks(4).zip(is_text.chunks(4)) {
        let texts = marks.iter().filter(|mark| **mark).count();
        kinds.text += texts;
        let value = word.try_into().map(u32::from_le_bytes).unwrap_or_default();
        if texts > 0 {
            kinds.rest += word.len() - texts;
        } else if word.iter().all(|byte| *byte == 0) {
            kinds.zeros += word.len();
        } else if memory::REGIONS.iter().any(|(name, range)| *name != "itcm" && range.contains(&u64::from(value))) {
            kinds.addresses += word.len();
        } else {
            kinds.rest += word.len();
        }
    }
    kinds
}

/// Texts of [`REPEATED`] bytes and more that begin the same in several places, longest first: each as far as
/// two of them agree.
fn repeated(data: &[u8], is_text: &[bool]) -> Vec<(String, usize)> {
    let mut places: BTreeMap<&[u8], Vec<usize>> = BTreeMap::new();
    for (at, window) in data.windows(REPEATED).enumerate() {
        // A line of blanks repeats itself.
        let is_line = window.windows(2).all(|pair| pair[0] == pair[1]);
        if !is_line && is_text[at..at + REPEATED].iter().all(|mark| *mark) {
            places.entry(window).or_default().push(at);
        }
    }
    let mut found = Vec::new();
    for at in places.values().filter(|at| at.len() > 1) {
        let (first, second) = (at[0], at[1]);
        // Only where they begin: every later window repeats as well.
        if first > 0 && data[first - 1] == data[second - 1] && is_text[first - 1] {
            continue;
        }
        let same = data[first..].iter().zip(&data[second..]).zip(&is_text[first..]);
        let length = same.take_while(|((a, b), is_text)| a == b && **is_text).count();
        found.push((String::from_utf8_lossy(&data[first..first + length]).into_owned(), at.len()));
    }
    found.sort_by_key(|(text, times)| std::cmp::Reverse(text.len() * (times - 1)));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_is_of_one_kind() {
        let data = *b"a text!!\0\0\0\0\x00\x00\x00\x24\x01\x02\x03\x04";
        assert_eq!(kinds(&data, &text_of(&data)), Kinds { text: 8, addresses: 4, zeros: 4, rest: 4 });
    }

    #[test]
    fn a_text_is_found_twice_from_where_it_begins() {
        let data =
            [b"one: the axis is not homed, home it first\0" as &[u8], b"two: the axis is not homed, home it first\0"]
                .concat();
        assert_eq!(repeated(&data, &text_of(&data)), [(": the axis is not homed, home it first".to_owned(), 2)]);
    }
}
