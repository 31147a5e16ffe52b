use super::*;
use proptest::prelude::*;
use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

/// Makes the inbox of a serial line.
fn serial() -> Box<Inbox> {
    Box::<InboxOf<INBOX_BYTES>>::default()
}

/// Takes all that waits; appends the lines that ended, and `lost` for each lost one.
fn read(inbox: &Inbox, line: &mut String, lines: &mut Vec<String>) {
    while let Some(received) = inbox.take(inbox.received()) {
        match received {
            Received::ForgetLine => line.clear(),
            Received::LoseLine => {
                line.clear();
                lines.push("lost".into());
            }
            Received::Byte(b'\n' | b'\r') => lines.push(core::mem::take(line)),
            Received::Byte(byte) => line.push(char::from(byte)),
        }
    }
    lines.extend((0..inbox.take_lost()).map(|_| "lost".into()));
}

#[test]
fn realtime_characters_leave_the_stream_even_when_it_is_full() {
    let (inbox, mut intake) = (serial(), Intake::new());
    while inbox.room() > 0 {
        assert!(inbox.receive(&mut intake, b'a'));
    }
    assert!(!inbox.receive(&mut intake, b'b'), "a full inbox must refuse");
    assert!(inbox.receive(&mut intake, b'?') && inbox.receive(&mut intake, b'!') && inbox.receive(&mut intake, 0x18));
    assert_eq!(inbox.take_request(), Some(Realtime::Abort));
    assert_eq!(inbox.take_request(), Some(Realtime::Hold));
    assert_eq!(inbox.take_request(), Some(Realtime::Status));
    assert_eq!(inbox.take_request(), None);
}

#[test]
fn grbls_reset_drops_what_was_sent_before_it_and_nothing_behind() {
    let (inbox, mut intake) = (serial(), Intake::new());
    inbox.set_extended(true);
    b"G1 X1\nG1 (X\x18G0 X2\n".iter().for_each(|byte| assert!(inbox.receive(&mut intake, *byte)));
    assert_eq!(inbox.take_request(), Some(Realtime::Abort));
    inbox.drop_before_reset();
    let mut lines = Vec::new();
    read(&inbox, &mut String::new(), &mut lines);
    assert_eq!(lines, ["G0 X2"]);
    inbox.drop_before_reset();
    b"G0 X3\n".iter().for_each(|byte| assert!(inbox.receive(&mut intake, *byte)));
    inbox.drop_before_reset();
    read(&inbox, &mut String::new(), &mut lines);
    assert_eq!(lines, ["G0 X2", "G0 X3"], "a reset long ago drops nothing");
}

#[test]
fn who_comes_back_in_the_middle_of_a_line_has_lost_that_line_and_no_other() {
    let (inbox, mut intake) = (serial(), Intake::new());
    let send = |intake: &mut Intake, text: &[u8]| {
        text.iter().for_each(|byte| {
            let _kept = inbox.receive(intake, *byte);
        });
    };
    let (mut line, mut lines) = (String::new(), Vec::new());
    send(&mut intake, b"G1 X1\nG1 X");
    inbox.set_open(false);
    inbox.open_again(&mut intake);
    send(&mut intake, b"200\nG1 X3\n");
    read(&inbox, &mut line, &mut lines);
    send(&mut intake, b"G1 X4\n");
    inbox.set_open(false);
    inbox.open_again(&mut intake);
    send(&mut intake, b"G1 X5\n");
    read(&inbox, &mut line, &mut lines);
    assert_eq!(lines, ["G1 X1", "lost", "G1 X3", "G1 X4", "G1 X5"]);
}

#[test]
fn of_whoever_is_forgotten_nothing_more_is_taken() {
    let (inbox, mut intake) = (serial(), Intake::new());
    let send = |intake: &mut Intake, text: &[u8]| {
        text.iter().for_each(|byte| {
            let _kept = inbox.receive(intake, *byte);
        });
    };
    let (mut line, mut lines) = (String::new(), Vec::new());
    // The peer has gone before the rest of its bytes arrives.
    send(&mut intake, b"of a file\nand");
    inbox.set_open(false);
    let gone = inbox.visits();
    inbox.forget_visit(gone);
    send(&mut intake, b" more \x18!\n");
    assert_eq!((inbox.take_request(), inbox.has_news()), (None, false));
    inbox.open(&mut intake);
    send(&mut intake, b"G28\n");
    read(&inbox, &mut line, &mut lines);
    // Another peer has come before the former one's leaving is seen.
    send(&mut intake, b"of a file\n");
    inbox.set_open(false);
    let gone = inbox.visits();
    inbox.open(&mut intake);
    send(&mut intake, b"G29\n");
    inbox.forget_visit(gone);
    read(&inbox, &mut line, &mut lines);
    assert_eq!(lines, ["G28", "G29"]);
}

#[test]
fn what_comes_behind_a_look_is_not_taken_by_it() {
    let (inbox, mut intake) = (serial(), Intake::new());
    inbox.receive(&mut intake, b'a');
    let end = inbox.received();
    inbox.receive(&mut intake, b'b');
    assert_eq!((inbox.take(end), inbox.take(end)), (Some(Received::Byte(b'a')), None));
    assert_eq!(inbox.take(inbox.received()), Some(Received::Byte(b'b')));
}

#[test]
fn at_most_eight_queries_wait() {
    let inbox = serial();
    for _ in 0..20 {
        inbox.request(Realtime::Status);
    }
    let answered = core::iter::from_fn(|| inbox.take_request()).count();
    assert_eq!(answered, 8);
}

#[test]
fn carriage_returns_and_line_feeds_end_one_line_together() {
    let (inbox, mut intake) = (serial(), Intake::new());
    b"a\r\nb\rc\n\nd\r\n".iter().for_each(|byte| assert!(inbox.receive(&mut intake, *byte)));
    let mut lines = Vec::new();
    read(&inbox, &mut String::new(), &mut lines);
    assert_eq!(lines, ["a", "b", "c", "", "d"]);
}

/// Changes an inbox between two packets, in the way of this number.
/// What a sender that is held back has sent acts as it would have with room, wherever it is cut.
#[test]
fn bytes_held_back_act_at_once_and_only_once() {
    let sent = b"G1 X1 (x)\nG1 X2!\n~?M112\nG1 X3\n";
    for cut in 0..sent.len() {
        let (inbox, mut intake) = (serial(), Intake::new());
        let _first = inbox.receive_all(&mut intake, &sent[..cut]);
        let mut acted = Vec::new();
        while let Some(request) = inbox.take_request() {
            acted.push(request);
        }
        let (mut waiting, mut looked) = (sent[cut..].to_vec(), 0);
        while let Some(gone) = inbox.look_ahead(&mut intake, &waiting, looked) {
            looked = gone.start;
            waiting.drain(gone);
        }
        while let Some(request) = inbox.take_request() {
            acted.push(request);
        }
        acted.sort_by_key(|request| *request as u32);
        let mut all = [Realtime::Hold, Realtime::Resume, Realtime::Status, Realtime::Emergency];
        all.sort_by_key(|request| *request as u32);
        assert_eq!(acted, all, "cut at {cut}");
        // M112 alone stays among the lines.
        let _rest = inbox.receive_all(&mut intake, &waiting);
        assert!(inbox.take_request().is_none_or(|request| request == Realtime::Emergency), "cut at {cut}");
        let (mut line, mut lines) = (String::new(), Vec::new());
        read(&inbox, &mut line, &mut lines);
        assert_eq!(lines, ["G1 X1 (x)", "G1 X2", "M112", "G1 X3"], "cut at {cut}");
    }
}

#[test]
fn a_reset_of_grbl_held_back_drops_what_was_sent_before_it() {
    let (inbox, mut intake) = (serial(), Intake::new());
    inbox.set_extended(true);
    let _first = inbox.receive_all(&mut intake, b"G1 X1\nG1 ");
    let waiting = b"X2\nG1 X3\xC2\x85\n\x18G1 X4\n";
    assert_eq!(inbox.look_ahead(&mut intake, waiting, 0), Some(8..10), "a jog's end, as a letter");
    assert_eq!(inbox.take_request(), Some(Realtime::JogCancel));
    let waiting = b"X2\nG1 X3\n\x18G1 X4\n";
    assert_eq!(inbox.look_ahead(&mut intake, waiting, 8), Some(0..10));
    assert_eq!(inbox.take_request(), Some(Realtime::Abort));
    inbox.drop_before_reset();
    let _rest = inbox.receive_all(&mut intake, &waiting[10..]);
    let (mut line, mut lines) = (String::new(), Vec::new());
    read(&inbox, &mut line, &mut lines);
    assert_eq!(lines, ["G1 X4"]);
}

#[test]
fn nothing_acts_in_a_file_or_a_text_that_is_held_back() {
    let (inbox, mut intake) = (serial(), Intake::new());
    inbox.set_raw(true);
    assert_eq!(inbox.look_ahead(&mut intake, b"?!\x18", 0), None);
    inbox.set_raw(false);
    inbox.set_text(true);
    assert_eq!(inbox.look_ahead(&mut intake, b"?!\x18", 0), Some(2..3));
}

fn change(inbox: &Inbox, intake: &mut Intake, what: u8) {
    match what {
        0 => inbox.set_raw(true),
        1 => inbox.set_raw(false),
        2 => inbox.set_text(true),
        3 => inbox.set_text(false),
        4 => inbox.set_extended(true),
        5 => {
            inbox.set_open(false);
            inbox.forget_visit(inbox.visits());
        }
        6 => inbox.open(intake),
        7 => while inbox.take(inbox.received()).is_some() {},
        _ => drop(inbox.take_lost()),
    }
}

proptest! {
    /// Bytes received together leave the same as bytes received singly.
    #[test]
    fn a_packet_is_its_bytes(
        packets in prop::collection::vec(("[GMX0-9 .(;*?!\\x18\n\r\u{C2}\u{85}]{0,16}", 0_u8..14, 1_usize..40), 1..40),
    ) {
        let (one_by_one, together) = (serial(), serial());
        let (mut intake, mut whole) = (Intake::new(), Intake::new());
        for (text, what, times) in packets {
            change(&one_by_one, &mut intake, what);
            change(&together, &mut whole, what);
            for _ in 0..times {
                let kept = text.bytes().filter(|byte| one_by_one.receive(&mut intake, *byte)).count();
                prop_assert_eq!(together.receive_all(&mut whole, text.as_bytes()), kept == text.len());
            }
            prop_assert_eq!(whole, intake);
            prop_assert_eq!(std::format!("{:?}", together), std::format!("{:?}", one_by_one));
        }
    }

    /// However lines come and are read, each is read whole or counted as lost, in order.
    #[test]
    fn each_line_is_read_whole_or_counted(
        rounds in prop::collection::vec((0_usize..900, any::<bool>(), 1_usize..40), 1..30),
    ) {
        let (inbox, mut intake) = (serial(), Intake::new());
        let (mut line, mut lines, mut sent) = (String::new(), Vec::new(), Vec::new());
        for (burst, returns, length) in rounds {
            for _ in 0..burst {
                let text = std::format!("{}:{}", sent.len(), "x".repeat(length));
                let end: &[u8] = if returns { b"\r\n" } else { b"\n" };
                for byte in text.bytes().chain(end.iter().copied()) {
                    let _kept = inbox.receive(&mut intake, byte);
                }
                sent.push(text);
            }
            read(&inbox, &mut line, &mut lines);
        }
        prop_assert_eq!(lines.len(), sent.len());
        for (read, sent) in lines.iter().zip(&sent) {
            prop_assert!(read == sent || read == "lost", "{read} is not {sent}");
        }
        // Nothing is lost unless the inbox was full.
        let lost = lines.iter().filter(|line| *line == "lost").count();
        prop_assert!(lost == 0 || sent.iter().map(|line| line.len() + 1).sum::<usize>() >= INBOX_BYTES - 1);
    }
}

#[test]
fn a_transport_ends_jogs_of_the_lines_that_it_sent_before() {
    let (inbox, mut intake) = (serial(), Intake::new());
    let _kept = inbox.receive_all(&mut intake, b"$J -c X1\n");
    inbox.cancel_jogs();
    let _kept = inbox.receive_all(&mut intake, b"$J -c X-1\n");
    assert_eq!((inbox.take_request(), inbox.stopped_at()), (Some(Realtime::JogCancel), 9));
}
