//! Changes of an input as text: lines come, go and change places, words and numbers are exchanged. The
//! engine changes bytes.

use crate::dice::Dice;
use crate::grammar;

/// Changes `input` in a single place, to `most` bytes at most.
pub fn mutate(input: &mut Vec<u8>, dice: &mut Dice, directions: &[&str], most: usize) {
    let mut lines: Vec<Vec<u8>> = input.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let at = dice.below(lines.len());
    match dice.below(9) {
        0 | 1 => lines.insert(at, grammar::line(dice, directions)),
        2 => lines[at] = grammar::line(dice, directions),
        3 => drop(lines.remove(at)),
        4 => {
            let copy = lines[at].clone();
            lines.insert(dice.below(lines.len()), copy);
        }
        5 => {
            let other = dice.below(lines.len());
            lines.swap(at, other);
        }
        6 => {
            let place = dice.below(lines[at].len() + 1);
            let token = grammar::token(dice);
            lines[at].splice(place..place, token);
        }
        7 => exchange_number(&mut lines[at], dice),
        _ => {
            // Two lines become one.
            if at + 1 < lines.len() {
                let next = lines.remove(at + 1);
                lines[at].extend(next);
            }
        }
    }
    *input = lines.join(&b'\n');
    input.truncate(most);
}

/// Replaces a number in the line by another.
fn exchange_number(line: &mut Vec<u8>, dice: &mut Dice) {
    let is_number = |byte: u8| byte.is_ascii_digit() || byte == b'.' || byte == b'-';
    let starts: Vec<usize> =
        (0..line.len()).filter(|at| is_number(line[*at]) && (*at == 0 || !is_number(line[*at - 1]))).collect();
    if starts.is_empty() {
        return;
    }
    let start = *dice.pick(&starts);
    let length = line[start..].iter().take_while(|byte| is_number(**byte)).count();
    let number = grammar::number(dice, program::codes::Bounds::Any, program::codes::Unit::Length);
    line.splice(start..start + length, number.into_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mutation_changes_something_and_keeps_its_bounds() {
        let mut dice = Dice::new(3);
        let mut changed = 0;
        let mut input = b"G28\nG1 X10 F600\nM400\n".to_vec();
        for _ in 0..2_000 {
            let before = input.clone();
            mutate(&mut input, &mut dice, &["@wait 5"], 300);
            assert!(input.len() <= 300);
            changed += usize::from(before != input);
        }
        assert!(changed > 1_500, "{changed}");
        mutate(&mut Vec::new(), &mut dice, &[], 100);
    }
}
