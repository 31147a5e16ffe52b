//! The web server's protocols: whatever arrives, in whatever pieces, comes to the same.

pub mod form;
pub mod http;
pub mod json;
mod server;
pub mod websocket;

use crate::dice::Dice;

/// Makes an input out of pieces of a protocol.
pub fn input(dice: &mut Dice, pieces: &[&[u8]]) -> Vec<u8> {
    let count = 1 + dice.below(14);
    (0..count).flat_map(|_| piece(dice, pieces)).collect()
}

/// Changes `input` in a single place, to `most` bytes at most.
pub fn mutate(input: &mut Vec<u8>, dice: &mut Dice, pieces: &[&[u8]], most: usize) {
    let at = dice.below(input.len() + 1);
    let until = at + dice.below((input.len() - at).min(40) + 1);
    match dice.below(5) {
        0 | 1 => drop(input.splice(at..at, piece(dice, pieces))),
        2 => drop(input.splice(at..until, piece(dice, pieces))),
        3 => drop(input.drain(at..until)),
        _ => {
            let copy = input[at..until].to_vec();
            let to = dice.below(input.len() + 1);
            input.splice(to..to, copy);
        }
    }
    input.truncate(most);
}

fn piece(dice: &mut Dice, pieces: &[&[u8]]) -> Vec<u8> {
    match dice.below(16) {
        0 => vec![dice.below(256) as u8],
        1 => vec![dice.below(256) as u8; dice.below(300)],
        2 => dice.below(70_000).to_string().into_bytes(),
        _ => dice.pick(pieces).to_vec(),
    }
}

/// Cuts an input into pieces, in the same way each time.
fn cut(input: &[u8], seed: u64) -> Vec<&[u8]> {
    let mut dice = Dice::new(seed ^ input.len() as u64);
    let mut rest = input;
    let mut pieces = Vec::new();
    while !rest.is_empty() {
        let most = if dice.once_in(3) { 200 } else { 6 };
        let (piece, later) = rest.split_at((1 + dice.below(most)).min(rest.len()));
        pieces.push(piece);
        rest = later;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mutation_changes_something_and_keeps_its_bounds() {
        let mut dice = Dice::new(3);
        let mut changed = 0;
        let mut input = b"GET / HTTP/1.1".to_vec();
        for _ in 0..2_000 {
            let before = input.clone();
            mutate(&mut input, &mut dice, http::PIECES, 300);
            assert!(input.len() <= 300);
            changed += usize::from(before != input);
        }
        assert!(changed > 1_500, "{changed}");
        mutate(&mut Vec::new(), &mut dice, http::PIECES, 100);
    }

    #[test]
    fn pieces_join_to_the_input() {
        let input: Vec<u8> = (0..=255).collect();
        for seed in 0..50 {
            assert_eq!(cut(&input, seed).concat(), input);
        }
    }
}
