//! Sessions of the board's own web server: each line is answered by one mark, whatever is said before it.

use base::sessions::{ConsoleKind, Rights, SessionId, SessionProfile};
use scenarios::{Bench, CARTESIAN, Plan};

const PAGE: SessionId = SessionId(2);
const DONE: &str = "\u{6}";
const REFUSED: &str = "\u{15}";
const NEWS: &str = "\u{7}";

fn page() -> Bench {
    page_with(Rights::Operate)
}

fn page_with(rights: Rights) -> Bench {
    let profile = SessionProfile { kind: ConsoleKind::Web, rights, dialect: None, greeting: "" };
    let mut bench = Plan::new(CARTESIAN).file("sub.g", "M118 hello\n").visitor(profile).start();
    bench.set_open(PAGE, true);
    bench.hear_on(PAGE, 0.1);
    bench
}

fn ask(bench: &mut Bench, line: &str) -> String {
    bench.type_on(PAGE, &format!("{line}\n"));
    bench.hear_on(PAGE, 0.5)
}

#[test]
fn each_line_is_answered_by_one_mark() {
    let mut bench = page();
    for line in [
        "M105",
        "G28.3 X0 Y0 Z0",
        "G1 X1 F6000",
        "M114",
        "?",
        "help",
        "version",
        "M503",
        "ls",
        "M23 sub.g",
        "; a comment",
        "",
    ] {
        let said = ask(&mut bench, line);
        assert!(said.ends_with(DONE) && said.matches(DONE).count() == 1 && !said.contains(REFUSED), "{line}: {said:?}");
    }
}

#[test]
fn a_refused_line_has_another_mark() {
    let mut bench = page();
    for line in ["M104 S9999", "rm sub.g", "nonsense here"] {
        let said = ask(&mut bench, line);
        assert!(
            said.ends_with(REFUSED) && said.matches(REFUSED).count() == 1 && !said.contains(DONE),
            "{line}: {said:?}"
        );
        assert!(said.len() > 5, "{line}: says why: {said:?}");
    }
}

#[test]
fn a_mark_comes_when_the_line_is_done() {
    let mut bench = page();
    bench.type_on(PAGE, "G4 P1500\n");
    assert_eq!(bench.hear_on(PAGE, 1.0).replace("ok\n", ""), "");
    assert!(bench.hear_on(PAGE, 1.0).ends_with(DONE));
}

#[test]
fn no_text_has_a_mark_in_it() {
    let mut bench = page();
    bench.say("M118 a\u{6}b\u{15}c\u{7}d");
    let said = bench.hear_on(PAGE, 0.2);
    assert!(said.contains("\u{7}abcd\n") && !said.contains(DONE) && !said.contains(REFUSED), "{said:?}");
}

/// The page hands over lines of who may only watch, too: the machine decides which of them are questions.
#[test]
fn who_watches_may_ask_and_move_nothing() {
    let mut bench = page_with(Rights::Watch);
    for question in ["version", "M114", "M105", "help"] {
        assert!(ask(&mut bench, question).ends_with(DONE), "{question}");
    }
    for change in
        ["G28.3 X0", "M104 S50", "play sub.g", "config-set planner planner_queue_size 48", "flash", "M500", "M78"]
    {
        assert!(ask(&mut bench, change).ends_with(REFUSED), "{change}");
    }
    assert_eq!(bench.read_card("config.ini").as_deref(), Some(CARTESIAN));
}

#[test]
fn news_are_told_apart_from_answers() {
    let mut bench = page();
    assert!(!ask(&mut bench, "version").contains(NEWS));
    // A line from another console, and what everybody is told of it.
    bench.say("M112");
    let said = bench.hear_on(PAGE, 0.2);
    assert!(said.contains("\u{7}ALARM: Emergency stop (M112)"), "{said:?}");
}
