//! Order in which the codes of a line are carried out (NIST RS-274/NGC, table 8), for dialects that read
//! lines so.

use gcode::{Code, Letter, MOST_CODES, WholeLine, letter_bit};
use heapless::Vec;

use crate::codes::{self, CodeInfo, Group};
use crate::fault::{Fault, Problem};

/// Axis words, which several codes of a line could claim.
const AXES: u32 = bits("XYZABC@^");
/// Words that alone make a move by the motion code in force, and all words that a move takes.
const PLACE_WORDS: u32 = bits("XYZABCE@^");
const MOVE_WORDS: u32 = bits("XYZABCEIJKRPQFSL@^");
/// Words of feed rate and speed, which need no move.
const RATES: u32 = bits("FS");
/// Rank of tool offsets.
const TOOL_OFFSETS: u8 = 14;
/// Ranks of codes that set a mode, and nothing else.
const MODES: [u8; 6] = [2, 11, 12, 15, 17, 18];
/// Rank of codes that use the axes without being motion codes.
const PLACES: u8 = 19;
/// Rank of G53, which says how a move reads its words.
const MACHINE_COORDINATES: u8 = 20;
/// Rank of G80, which may stand beside another motion code and runs before it: many programs begin with such
/// a line.
const CANCEL: u8 = 21;
/// Rank of motion codes.
const MOTION: u8 = 22;
/// Rank of codes that stop the program.
const STOPS: u8 = 23;

/// Returns the rank of a code in a line; `None` for codes outside RS-274, whose lines are carried out as
/// written.
fn rank(code: Code) -> Option<u8> {
    Some(match (code.letter, code.number) {
        (Letter::G, 93..=95) => 2,
        (Letter::T, _) => 5,
        (Letter::M, 6 | 61) => 6,
        (Letter::G, 96 | 97) => 4,
        (Letter::M, 3..=5 | 19) => 7,
        (Letter::M, 7..=9) => 8,
        (Letter::M, 48..=53 | 62..=68 | 70..=73 | 98..=99) => 9,
        (Letter::G, 4) => 10,
        (Letter::G, 17..=19) => 11,
        (Letter::G, 7 | 8 | 20 | 21) => 12,
        (Letter::G, 40..=42) => 13,
        (Letter::G, 43 | 49) => TOOL_OFFSETS,
        (Letter::G, 54..=59) => 15,
        (Letter::G, 61 | 64) => 16,
        (Letter::G, 90 | 91) => 17,
        (Letter::G, 98 | 99) => 18,
        (Letter::G, 10 | 28 | 30 | 52 | 92) => PLACES,
        (Letter::G, 53) => MACHINE_COORDINATES,
        (Letter::G, 0..=3 | 5 | 33 | 38 | 70..=74 | 76 | 81..=89) => MOTION,
        (Letter::G, 80) => CANCEL,
        (Letter::M, 0 | 1 | 2 | 30 | 60) => STOPS,
        _ => return None,
    })
}

/// Part of a line: a code, or the motion code in force, with the letters of its words.
#[derive(Clone, Debug)]
pub struct Part {
    /// Code of the part; `None` for the motion code in force.
    pub code: Option<Code>,
    /// Letters of the words that belong to it: [`letter_bit`] each.
    pub letters: u32,
}

/// Parts of a line, in order.
pub type Parts = Vec<Part, { MOST_CODES + 1 }>;

/// Returns the set of these letters' bits.
const fn bits(letters: &str) -> u32 {
    let (mut all, mut left) = (0, letters.as_bytes());
    while let [letter, rest @ ..] = left {
        all |= letter_bit(*letter as char);
        left = rest;
    }
    all
}

fn row_of(code: Code) -> Option<&'static CodeInfo> {
    if code.letter == Letter::T {
        return Some(codes::TOOL);
    }
    codes::find_in(code, crate::Dialect::Grbl).or_else(|| codes::find(code))
}

/// Puts the codes of a line in order, and assigns words to each. `None` when a code is unknown or outside
/// RS-274: then the line is carried out as written.
///
/// # Errors
/// When two codes share a modal group, two need the axes, or no code takes a word.
pub fn arrange(line: &WholeLine<'_>) -> Option<Result<Parts, Fault>> {
    let mut ranked: Vec<(u8, Code, &CodeInfo), MOST_CODES> = Vec::new();
    for code in line.codes() {
        // The list has room for the codes of a line.
        let _ = ranked.push((rank(*code)?, *code, row_of(*code)?));
    }
    if let Some(letter) = line.twice() {
        return Some(Err(Problem::WordTwice(letter).refused(0)));
    }
    units::sort_short(&mut ranked, |(one, ..), (other, ..)| one.cmp(other));
    Some(give_words(line, &ranked))
}

fn give_words(line: &WholeLine<'_>, ranked: &[(u8, Code, &CodeInfo)]) -> Result<Parts, Fault> {
    for (place, (_, code, row)) in ranked.iter().enumerate() {
        let before = ranked.get(..place).unwrap_or(&[]);
        let is_rival = |rank: u8, other: &CodeInfo| rank != CANCEL && other.group == row.group;
        let rival = before.iter().find(|(rank, _, other)| row.group != Group::NonModal && is_rival(*rank, other));
        if let Some((_, other, _)) = rival {
            return Err(Problem::SameGroup(*other, *code).refused(0));
        }
    }
    let written = line.words().letters();
    let is_place = |rank: u8, row: &CodeInfo| rank == PLACES || rank == TOOL_OFFSETS && row.letters & AXES != 0;
    let places = || ranked.iter().filter(|(rank, _, row)| is_place(*rank, row)).map(|(_, code, _)| *code);
    let motion = ranked.iter().find(|(rank, ..)| *rank == MOTION).map(|(_, code, _)| *code);
    let (place, second) = (places().next(), places().nth(1).or(motion));
    if let (Some(one), Some(other)) = (place, second)
        && written & AXES != 0
    {
        return Err(Problem::AxesTwice(one, other).refused(0));
    }
    let (mut parts, mut left) = (Parts::new(), written);
    for (rank, code, row) in ranked {
        let mut letters = row.letters & written;
        if *code == Code::g(4) && line.words().has('P') {
            // S beside P belongs to the spindle; alone it is a time, as in Smoothieware.
            letters &= !letter_bit('S');
        }
        let may_have_axes = is_place(*rank, row)
            || *rank == MOTION
            || *rank == MACHINE_COORDINATES && motion.is_none() && place.is_none();
        if !may_have_axes {
            letters &= !AXES;
        }
        // A mode takes no words here; its row lists words for lines that are read as written.
        if MODES.contains(rank) || *rank == MACHINE_COORDINATES && motion.is_some() {
            letters = 0;
        }
        left &= !letters;
        // The list has room for the codes of a line.
        let _ = parts.push(Part { code: Some(*code), letters });
    }
    if left != 0 {
        give_rest(&mut parts, ranked, left, place.is_some() && motion.is_none())?;
    }
    Ok(parts)
}

/// Gives words that no code of the line takes, a position or a rate, to the motion code in force.
fn give_rest(
    parts: &mut Parts,
    ranked: &[(u8, Code, &CodeInfo)],
    left: u32,
    axes_are_taken: bool,
) -> Result<(), Fault> {
    let has_motion = ranked.iter().any(|(rank, ..)| matches!(*rank, CANCEL | MOTION));
    let moves = left & PLACE_WORDS != 0 && !axes_are_taken;
    let known = if moves { MOVE_WORDS } else { RATES };
    let strange = if has_motion { left } else { left & !known };
    if let Some(letter) = gcode::WORD_LETTERS.into_iter().find(|letter| strange & letter_bit(*letter) != 0) {
        return Err(Problem::UnusedWord(letter).refused(0));
    }
    // Moves go before codes that stop the program, behind everything else.
    let place = ranked.iter().take_while(|(rank, ..)| *rank < MOTION).count();
    let _ = parts.insert(place, Part { code: None, letters: left });
    Ok(())
}
