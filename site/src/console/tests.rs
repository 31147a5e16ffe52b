//! The site's console against lines of a machine.

use super::*;
use crate::calls::IdValue;

/// Makes a console that nothing was said on.
fn console() -> Console {
    Console::new(Box::leak(Box::new([0; SAID_BYTES])))
}

const ASKER: Asker = Asker { place: 1, visit: 7 };
const OTHER: Asker = Asker { place: 2, visit: 1 };

fn text(console: &Console, at: u32) -> Option<(String<LINE_BYTES>, u32)> {
    console.line(at).map(|said| (said.text, said.next))
}

/// Returns the next line of visitors who may operate the machine.
fn next_line(console: &mut Console) -> Option<String<SCRIPT_BYTES>> {
    console.next_line(0, |_| Role::Operate).map(|(line, _)| line)
}

fn take(console: &mut Console, asker: Asker, id: Option<Id>, text: &str, listeners: Listeners) -> bool {
    console.take(asker, Pass::None, id, text, listeners)
}

#[test]
fn a_line_has_the_role_that_its_sender_has_when_it_is_handed_over() {
    let mut console = console();
    let (owner, guest) = (Pass::Session(1), Pass::None);
    assert!(console.take(ASKER, owner, Some(Id::of(IdValue::Number(1))), "M500\nM501", Listeners::All));
    assert!(console.take(ASKER, guest, Some(Id::of(IdValue::Number(2))), "M114", Listeners::All));
    let with = |owns| move |pass| if pass == guest { Role::Operate } else { owns };
    let (line, role) = console.next_line(0, with(Role::Own)).expect("a line");
    assert_eq!((line.as_str(), role), ("M500\n", Role::Own));
    console.hear(&[DONE], 5_000);
    let (line, role) = console.next_line(0, with(Role::Nobody)).expect("a line of who still may");
    assert_eq!((line.as_str(), role), ("M114\n", Role::Operate), "the owner has logged out: M501 is dropped");
    let outcome = console.take_outcome().expect("an outcome");
    assert_eq!((outcome.id, outcome.ending), (Some(Id::of(IdValue::Number(1))), Ending::Refused(None)));
    console.hear(&[DONE], 5_000);
    let outcome = console.take_outcome().expect("an outcome");
    assert_eq!((outcome.id, outcome.ending), (Some(Id::of(IdValue::Number(2))), Ending::Done));
}

#[test]
fn a_script_is_handed_over_line_by_line_and_done_with_the_last() {
    let mut console = console();
    assert!(take(&mut console, ASKER, Some(Id::of(IdValue::Number(5))), "G28\n\n M104 S200 \nG1 X1", Listeners::All));
    assert_eq!(next_line(&mut console).as_deref(), Some("G28\n"));
    assert_eq!(next_line(&mut console), None, "one at a time");
    console.hear(b"ok\n\x06", 5_000);
    assert_eq!(next_line(&mut console).as_deref(), Some("M104 S200\n"));
    console.hear(b"error:too hot\n\x15", 5_000);
    assert!(console.take_outcome().is_none());
    assert_eq!(next_line(&mut console).as_deref(), Some("G1 X1\n"));
    console.hear(b"ok\n\x06", 5_000);
    let outcome = console.take_outcome().expect("an outcome");
    assert_eq!((outcome.asker, outcome.id, outcome.said), (ASKER, Some(Id::of(IdValue::Number(5))), 57));
    assert_eq!(outcome.ending, Ending::Refused(Some(24)), "with the place of the reason");
    assert_eq!(console.line(24).as_ref().map(Said::reason), Some("too hot"));
    assert_eq!(text(&console, 24), Some(("!! error:too hot".try_into().unwrap(), 46)));
    assert_eq!(text(&console, 57), None);
}

#[test]
fn a_script_that_has_no_room_is_not_begun() {
    let mut console = console();
    let long = "G1 X1\n".repeat(80);
    assert!((0..2).all(|_| take(&mut console, ASKER, None, &long, Listeners::All)));
    assert!(!take(&mut console, ASKER, None, &long, Listeners::All));
    assert!(take(&mut console, ASKER, None, "M105", Listeners::All), "a short one fits");
    next_line(&mut console);
    console.drop_waiting();
    assert_eq!(next_line(&mut console), None);
    assert!(console.take_outcome().is_none(), "the first line is still in work");
    console.hear(b"\x15", 5_000);
    let endings: Vec<_> = (0..4).filter_map(|_| console.take_outcome()).map(|outcome| outcome.ending).collect();
    assert_eq!(endings, [Ending::Refused(None); 3]);
}

#[test]
fn a_listener_who_is_behind_misses_whole_lines() {
    let mut console = console();
    for number in 0..500 {
        console.hear(format!("line {number}\n").as_bytes(), 5_000);
    }
    let (first, mut at) = text(&console, 0).expect("a line");
    assert!(first.starts_with("line ") && first.len() == 8, "{first}");
    let mut last = first;
    while let Some((line, next)) = text(&console, at) {
        (last, at) = (line, next);
    }
    assert_eq!((last.as_str(), at), ("line 499", console.end()));
}

#[test]
fn an_answer_to_one_is_heard_by_nobody_else_and_news_are_heard_by_all() {
    let mut console = console();
    assert!(take(&mut console, ASKER, None, "version", Listeners::Asker));
    next_line(&mut console);
    console.hear(b"Velvet\n\x07// the cable is out\nBuild\nok\n\x06\x07// it is in\n", 5_000);
    let mut heard = Vec::new();
    let mut at = 0;
    while let Some(said) = console.line(at) {
        at = said.next;
        heard.push((said.text.to_string(), said.is_for(ASKER.place), said.is_for(OTHER.place)));
    }
    let lines = [("Velvet", false), ("// the cable is out", true), ("Build", false), ("// it is in", true)];
    assert_eq!(heard, lines.map(|(line, all)| (line.to_owned(), true, all)));
}

#[test]
fn the_machine_waits_for_who_listens_alone_but_not_for_long() {
    let mut console = console();
    assert!(take(&mut console, ASKER, None, "help", Listeners::Asker));
    next_line(&mut console);
    let mut said = 0;
    while let room @ 2.. = console.room(Some(0), 100) {
        // The shortest lines there are, of which the most fit.
        console.hear("a\n".repeat(room / 2).as_bytes(), 5_000);
        said += room / 2 * 2;
    }
    console.hear(b"a\n", 5_000);
    said += 2;
    assert!(said > SAID_BYTES / 5, "{said}");
    let mut at = 0;
    let heard = std::iter::from_fn(|| console.line(at).inspect(|said| at = said.next)).count();
    assert_eq!(heard, said / 2, "nothing was overwritten");
    assert_eq!((console.room(Some(0), 100), console.room(Some(0), 100 + PATIENCE_MS - 1)), (0, 0));
    assert_eq!(console.room(Some(0), 100 + PATIENCE_MS), usize::MAX);
    assert_eq!((console.room(Some(at), 101) > 0, console.room(None, 101)), (true, usize::MAX));
}

#[test]
fn a_long_answer_to_one_makes_way_for_lines_of_others() {
    let mut console = console();
    assert!(take(&mut console, ASKER, None, "check /sd/a.g", Listeners::Asker));
    next_line(&mut console);
    assert!(!console.breaks_off(10_000, false), "nobody waits");
    assert!(take(&mut console, OTHER, None, "check /sd/b.g", Listeners::Asker));
    assert!(!console.breaks_off(10_000, false), "who asks waits");
    assert!(take(&mut console, OTHER, None, "G28", Listeners::All));
    assert!(!console.breaks_off(LONG_ANSWER_MS - 1, true));
    assert!(console.breaks_off(LONG_ANSWER_MS, false) && !console.breaks_off(10_000, true), "once");
    console.hear(b"ok\n\x06", 5_000);
    assert_eq!(console.take_outcome().map(|outcome| outcome.ending), Some(Ending::BrokenOff));
}

#[test]
fn who_comes_later_is_told_what_all_heard_and_what_was_sent() {
    let mut console = console();
    let kept = |console: &Console, count| -> Vec<_> {
        let mut at = console.last(count);
        std::iter::from_fn(|| console.next_kept(at).inspect(|said| at = said.next))
            .map(|said| (said.text.as_str().to_owned(), said.is_sent(), said.at_s))
            .collect()
    };
    assert_eq!(kept(&console, 9), []);
    for (line, answer) in [("M105", "T:20"), ("password wordpass", "it is set"), ("  PassWord x", "it is set")] {
        assert!(take(&mut console, ASKER, None, line, Listeners::All));
        console.next_line(77_000, |_| Role::Operate);
        console.hear(format!("{answer}\nok\n\x06").as_bytes(), 600_000);
    }
    assert!(take(&mut console, ASKER, None, "version", Listeners::Asker));
    next_line(&mut console);
    console.hear(b"for one alone\nok\n\x06\x07// news\n", 600_000);
    // Jogs come many a second.
    assert!(take(&mut console, Asker { place: JOG_PLACE, visit: 1 }, None, "$J=X1", Listeners::All));
    next_line(&mut console);
    console.hear(b"ok\n\x06", 600_000);
    let line = |text: &str, is_sent, at_s| (text.to_owned(), is_sent, at_s);
    let all = [
        line("M105", true, 77),
        line("T:20", false, 600),
        line("it is set", false, 600),
        line("it is set", false, 600),
    ];
    let all: Vec<_> = all.into_iter().chain([line("// news", false, 600)]).collect();
    assert_eq!(kept(&console, 9), all, "no secret, and nothing that was for one alone");
    assert_eq!(kept(&console, 2), all[3..]);
    // The oldest are overwritten, and the first of the rest is whole.
    (0..2_000).for_each(|number| console.hear(format!("line {number}\n").as_bytes(), 600_000));
    let rest = kept(&console, usize::MAX);
    assert!(rest.len() > 200 && rest.iter().all(|(text, ..)| text.starts_with("line 1")), "{rest:?}");
    assert_eq!(rest.last().unwrap().0, "line 1999");
}
