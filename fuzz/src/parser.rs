//! Bytes to words: whatever arrives, every line is read to its end in bounded work, every number is one,
//! every place named is on the line.

use gcode::realtime::{Heard, Receiver};
use gcode::{Decoder, Gathered, Line, LineBuffer, MAX_LINE_LENGTH, Refusal};

/// Reads the bytes as a console in each dialect and as a file.
///
/// # Panics
/// When a condition of this module does not hold.
pub fn run(bytes: &[u8]) {
    read(bytes, Some(false), false);
    read(bytes, Some(true), true);
    read(bytes, None, false);
}

/// Reads the bytes. `console`: bytes that act at once are taken out first; true if GRBL's are among them.
fn read(bytes: &[u8], console: Option<bool>, block_delete: bool) {
    let mut receiver = Receiver::new();
    let mut gathering = LineBuffer::new();
    let mut decoder = Decoder::new();
    decoder.block_delete = block_delete;
    for &byte in bytes {
        let heard = console.map_or(Heard::Byte, |extended| receiver.hear(byte, extended));
        if matches!(heard, Heard::Request(_) | Heard::Nothing) {
            continue;
        }
        if heard == Heard::Letter {
            let _no_end_of_a_line = gathering.push(0xC2);
        }
        if let Some(Gathered::Line(line)) = gathering.push(byte) {
            look(line, &mut decoder);
        }
    }
    if let Some(Gathered::Line(line)) = gathering.finish() {
        look(line, &mut decoder);
    }
}

fn look(line: &[u8], decoder: &mut Decoder) {
    assert!(line.len() <= MAX_LINE_LENGTH, "a line of {} bytes", line.len());
    let expected = decoder.expected();
    match decoder.decode(line) {
        Ok(Line::Blank) => assert_eq!(decoder.expected(), expected, "a blank line counts"),
        Ok(Line::Console(text)) => assert!(text.len() <= line.len(), "text out of nothing"),
        Ok(Line::Extended(command)) => {
            assert!(!command.name().is_empty(), "a command without a name");
            assert!(command.parameters().count() <= line.len(), "parameters out of nothing");
        }
        Ok(Line::Code(blocks)) => {
            let mut count = 0;
            let mut ended = false;
            for block in blocks {
                assert!(!ended, "a block behind an error");
                match block {
                    Ok(block) => look_at_block(&block, line),
                    Err(error) => {
                        ended = true;
                        assert!(usize::from(error.column) <= line.len() + 1, "{error} of {} columns", line.len());
                        assert!(!error.to_string().is_empty(), "an error without words");
                    }
                }
                count += 1;
                assert!(count <= line.len(), "more blocks than bytes");
            }
        }
        Ok(Line::Flow(flow)) => {
            assert!(!flow.label.is_empty(), "a subroutine without a name");
            // Without parameters some words have no values.
            let _ = flow.values(&gcode::NoParameters, |value| assert!(value.is_finite(), "{value}"));
        }
        Err(Refusal::Resend { expected: wanted }) => {
            assert_eq!((wanted, decoder.expected()), (expected, expected), "a refused line counts");
        }
        Err(Refusal::Syntax(error)) => {
            assert!(usize::from(error.column) <= line.len() + 1, "{error} of {} columns", line.len());
        }
    }
}

fn look_at_block(block: &gcode::Block<'_>, line: &[u8]) {
    assert!((1..=line.len()).contains(&usize::from(block.column)), "a block at column {}", block.column);
    for (letter, value) in block.words() {
        assert!(value.is_none_or(f64::is_finite), "{letter} is {value:?}");
        let column = usize::from(block.column_of(letter));
        let written = line.get(column.wrapping_sub(1)).copied().unwrap_or_default();
        assert_eq!(char::from(written).to_ascii_uppercase(), letter, "column {column}");
    }
    // A printed line reads back as itself. Text may hold anything but the beginning of a comment.
    if block.text.is_none() {
        let printed = block.to_string();
        let mut again = gcode::Blocks::new(printed.as_bytes());
        assert_eq!(
            again.next().and_then(Result::ok).as_ref(),
            Some(block).filter(|_| !printed.is_empty()),
            "{printed}"
        );
    }
}
