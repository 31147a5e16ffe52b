use super::*;
use crate::{Block, Code};
use proptest::prelude::*;

fn numbered(number: i32, text: &str) -> String {
    let line = format!("N{number} {text}");
    let sum = checksum_of(line.as_bytes());
    format!("{line}*{sum}")
}

fn decode<'a>(decoder: &mut Decoder, line: &'a str) -> Result<Line<'a>, Refusal> {
    decoder.decode(line.as_bytes())
}

fn blocks(line: Line<'_>) -> Vec<Block<'_>> {
    match line {
        Line::Code(blocks) => blocks.map(Result::unwrap).collect(),
        other => panic!("not G-code: {other:?}"),
    }
}

fn is_code(line: &str) -> bool {
    matches!(decode(&mut Decoder::new(), line), Ok(Line::Code(_)))
}

fn console(line: &str) -> Option<&str> {
    match decode(&mut Decoder::new(), line) {
        Ok(Line::Console(text)) => Some(text),
        _ => None,
    }
}

#[test]
fn commands_by_name_are_neither_code_nor_console() {
    let name = |line: &str| match decode(&mut Decoder::new(), line) {
        Ok(Line::Extended(command)) => Some(command.name().to_owned()),
        _ => None,
    };
    let numbered = numbered(1, "PAUSE");
    for (line, expected) in [("PRINT_START BED=60", "PRINT_START"), ("  NEXT_PART", "NEXT_PART"), (&numbered, "PAUSE")]
    {
        assert_eq!(name(line).as_deref(), Some(expected), "{line}");
    }
    for line in ["set_velocity_limit", "G1 X1", "N5 G28", "T1", "M117 PAUSE", "pause"] {
        assert_eq!(name(line), None, "{line}");
    }
}

#[test]
fn numbered_lines_in_turn_are_executed() {
    let mut decoder = Decoder::new();
    for number in 1..5 {
        let line = numbered(number, "G1 X5");
        assert_eq!(blocks(decode(&mut decoder, &line).unwrap()), [Block::new(Some(Code::g(1)), 4).with('X', 5.0)]);
    }
    assert_eq!(decoder.expected(), 5);
}

#[test]
fn a_lost_or_repeated_line_asks_for_the_next_one_and_changes_nothing() {
    let mut decoder = Decoder::new();
    decode(&mut decoder, &numbered(1, "G28")).unwrap();
    for wrong in [0, 1, 3, -7] {
        let refusal = decode(&mut decoder, &numbered(wrong, "G28")).unwrap_err();
        assert_eq!(refusal, Refusal::Resend { expected: 2 });
        assert_eq!(refusal.to_string(), "rs N2");
    }
    decode(&mut decoder, &numbered(2, "G28")).unwrap();
}

#[test]
fn m110_sets_the_count_in_both_forms() {
    let mut decoder = Decoder::new();
    decode(&mut decoder, &numbered(100, "M110")).unwrap();
    assert_eq!(decoder.expected(), 101);
    decode(&mut decoder, "M110 N7").unwrap();
    assert_eq!(decoder.expected(), 8);
    decode(&mut decoder, &numbered(0, "m110 N5")).unwrap();
    assert_eq!(decoder.expected(), 6);
    decoder.counts_from_before = true;
    decode(&mut decoder, &numbered(0, "M110 N5")).unwrap();
    assert_eq!(decoder.expected(), 1);
    decode(&mut decoder, "M110 N7").unwrap();
    assert_eq!(decoder.expected(), 8);
    decode(&mut decoder, "N-1 M110*15").unwrap();
    assert_eq!(decoder.expected(), 0);
    decode(&mut decoder, "M1100").unwrap();
    assert_eq!(decoder.expected(), 0);
}

#[test]
fn a_star_in_brackets_multiplies_on_a_numbered_line_too() {
    let mut decoder = Decoder::new();
    for line in ["N5 G1 X[2*3]", "N5 #1=[2 * [1 ** 2]]", "N5 G1 X[2*3] (4*5)", "N5 G1 X[2*3] ; 4*", "N5 G1 Y1 X[2*3]F7"]
    {
        assert!(decode(&mut decoder, line).is_ok(), "{line}");
    }
    assert!(decode(&mut decoder, &numbered(1, "G1 X[2*3]")).is_ok());
    for line in ["N5 G1 X[2*3]*1", "N5 G1 X[2]*3 Y1", "N5 G1 X1*"] {
        assert!(decode(&mut decoder, line).is_err(), "{line}");
    }
}

#[test]
fn numbers_without_a_checksum_are_labels() {
    let mut decoder = Decoder::new();
    for line in ["N100 G1 X1", "N20 G1 X1", "n30g1x1", "N 40 G1 X1", "/N50 G1 X1", "G1 X1"] {
        assert_eq!(blocks(decode(&mut decoder, line).unwrap()).len(), 1, "{line}");
    }
    assert_eq!(decoder.expected(), 1);
}

#[test]
fn a_checksum_holds_without_a_number_and_before_a_comment() {
    let sum = checksum_of(b"G1 X5");
    assert!(is_code(&format!("G1 X5*{sum}")));
    assert!(is_code(&format!("G1 X5*{sum} ; fast*1")));
    let with_comment = numbered(1, "G1 X5 ; two*3 ");
    assert!(is_code(&with_comment), "{with_comment}");
    assert!(is_code("G1 X5 ; a comment with *99"));
    let wrong = format!("G1 X5*{}", sum ^ 1);
    let bad = Refusal::Syntax(SyntaxError { column: 6, problem: Problem::BadChecksum });
    assert_eq!(decode(&mut Decoder::new(), &wrong).unwrap_err(), bad, "it has no number to be asked for");
    let mut numbering = Decoder::new();
    decode(&mut numbering, &numbered(1, "G28")).unwrap();
    assert_eq!(decode(&mut numbering, &wrong).unwrap_err(), Refusal::Resend { expected: 2 });
}

#[test]
fn a_star_in_a_text_is_no_checksum() {
    let mut numbering = Decoder::new();
    decode(&mut numbering, &numbered(1, "G28")).unwrap();
    for mut decoder in [Decoder::new(), numbering] {
        for line in [
            "M117 Pass 3*4",
            "M118 5*3",
            "M117 *** Test ****15",
            "M486 Abox 2*2",
            "M23 a*1.g",
            "M0 Turn 2*3",
            "M16 Box*2",
            "G1 X1 M117 3*4",
            "echo 5*3",
            "RESPOND MSG=3*4",
            "M30 part*7",
        ] {
            assert!(decode(&mut decoder, line).is_ok(), "{line}");
        }
    }
    let texts = blocks(decode(&mut Decoder::new(), "M117 Pass 3*4").unwrap());
    assert_eq!(texts[0].text, Some("Pass 3*4"));
}

#[test]
fn an_unreadable_number_is_a_syntax_error_unless_a_checksum_was_meant() {
    let refused = |line| decode(&mut Decoder::new(), line).unwrap_err();
    let syntax = |column, problem| Refusal::Syntax(SyntaxError { column, problem });
    for line in ["N1 G28*x", "N1 G28*300", "N1 G28*18x", "N1 G28*", "N G28*18"] {
        assert_eq!(refused(line), Refusal::Resend { expected: 1 }, "{line}");
    }
    assert_eq!(refused("N1 M117 2*x"), syntax(10, Problem::BadChecksum));
    assert_eq!(refused(" N-X G28"), syntax(2, Problem::BadLineNumber));
    assert_eq!(refused("N9999999999 G28"), syntax(1, Problem::BadLineNumber));
}

#[test]
fn what_is_left_of_a_line_with_a_checksum_is_asked_for_again() {
    let mut decoder = Decoder::new();
    assert!(is_code("N1 G1 X5"), "a label");
    decode(&mut decoder, &numbered(1, "G28")).unwrap();
    for line in ["N2 G1 X5", "N2 G1 X5*", "N2", "N2 ls", "N G1 X5", "N2x7", "N2 M117 2*x", "N99999999999 G1"] {
        assert_eq!(decode(&mut decoder, line).unwrap_err(), Refusal::Resend { expected: 2 }, "{line}");
    }
    for line in ["N7 G1 X5", "G1 X5", "M117 2*x"] {
        assert!(decode(&mut decoder, line).is_ok(), "{line}: no number of this stream");
    }
    assert!(decode(&mut decoder, "N2 M110").is_ok(), "a sender that begins anew");
    assert!(decode(&mut decoder, &numbered(3, "G28")).is_ok());
}

#[test]
fn lower_case_gcode_is_gcode_and_words_are_console_commands() {
    for line in ["g1 x10", "m105", "t1", "x10 y5", "x-5", "f+100", "y.5", "n5 g1x1", "G28", "M105"] {
        assert!(is_code(line), "{line}");
    }
    for line in ["ls -1 /sd", "$H", "$X", "get pos", "mem", "m", "go *.g", "echo 5*3", "version", "net -n", "n"] {
        assert_eq!(console(line), Some(line));
    }
    assert_eq!(console("  help\t"), Some("help"));
    assert_eq!(console(&numbered(1, "play /sd/a.g")), Some("play /sd/a.g"));
    let refusal = Decoder::new().decode(b"cat \xff").unwrap_err();
    assert_eq!(refusal, Refusal::Syntax(SyntaxError { column: 5, problem: Problem::NotText }));
}

#[test]
fn lines_without_a_command_are_blank() {
    for line in ["", "   ", "; comment", "%", "% program 5", "\t"] {
        assert!(matches!(decode(&mut Decoder::new(), line), Ok(Line::Blank)), "{line}");
    }
    assert!(matches!(Decoder::new().decode(b"\xEF\xBB\xBF; first line"), Ok(Line::Blank)));
    assert!(blocks(decode(&mut Decoder::new(), "(only a comment)").unwrap()).is_empty());
}

#[test]
fn deleted_blocks_are_skipped_only_when_the_switch_is_on() {
    let mut decoder = Decoder::new();
    assert_eq!(blocks(decode(&mut decoder, "/G1 X1").unwrap()).len(), 1);
    decoder.block_delete = true;
    assert!(matches!(decode(&mut decoder, "/G1 X1"), Ok(Line::Blank)));
}

#[test]
fn text_codes_lose_only_their_checksum() {
    let line = numbered(1, "M117 2*3 is six");
    let mut decoder = Decoder::new();
    assert_eq!(blocks(decode(&mut decoder, &line).unwrap())[0].text, Some("2*3 is six"));
}

proptest! {
    #[test]
    fn any_changed_byte_of_a_checksummed_line_is_noticed(
        words in "G1( [XYZ]-?[0-9]{1,3}(\\.[0-9]{1,3})?){1,4}", at in any::<prop::sample::Index>(), bit in 0_u8..7,
    ) {
        let line = numbered(1, &words);
        let star = line.rfind('*').unwrap();
        let mut bytes = line.clone().into_bytes();
        let at = at.index(star);
        bytes[at] ^= 1 << bit;
        // A changed N, or a byte turned into one that ends the line, makes another kind of line; none may
        // be executed as if nothing had happened.
        let mut decoder = Decoder::new();
        let executed = matches!(decoder.decode(&bytes), Ok(Line::Code(blocks)) if blocks.clone().all(|b| b.is_ok()));
        prop_assert!(!executed, "{:?}", String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_bytes_make_it_panic(lines in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..80), 1..20)) {
        let mut decoder = Decoder::new();
        for line in &lines {
            if let Ok(Line::Code(blocks)) = decoder.decode(line) {
                prop_assert!(blocks.count() <= line.len());
            }
        }
    }

    #[test]
    fn a_line_that_begins_with_a_g_code_is_read_as_all_others(line in "G[0-9]{0,3}[ GMXYZ0-9.*;()N-]{0,20}") {
        let read = format!("{:?}", Decoder::new().decode(line.as_bytes()));
        prop_assert_eq!(read, format!("{:?}", Decoder::new().decode_any(line.as_bytes())));
    }

    #[test]
    fn no_plausible_line_makes_it_panic(line in "[/%]?[ N0-9-]{0,8}[GMTX0-9 .*;()a-z$-]{0,40}") {
        if let Ok(Line::Code(blocks)) = Decoder::new().decode(line.as_bytes()) {
            let _ = blocks.count();
        }
    }
}
