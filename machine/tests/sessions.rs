//! Transports in memory beside the serial lines: each of a kind, with rights and a dialect of its own. The
//! executor knows none of it.

use base::sessions::{ConsoleKind, SessionProfile};
use base::sessions::{Rights, SessionId};
use program::Dialect;
use scenarios::{Bench, CARTESIAN, Plan};

/// Session of an open web page: looks, and stops the machine.
const WATCHER: SessionId = SessionId(2);
/// A sender over the network, in a dialect of its own.
const SENDER: SessionId = SessionId(3);

const WATCHERS: SessionProfile =
    SessionProfile { kind: ConsoleKind::Network, rights: Rights::Watch, dialect: None, greeting: "watching\n" };
const SENDERS: SessionProfile = SessionProfile {
    kind: ConsoleKind::Memory,
    rights: Rights::Operate,
    dialect: Some(Dialect::Grbl),
    greeting: "of no use: its dialect has its own\n",
};

fn start() -> Bench {
    Plan::new(CARTESIAN).visitor(WATCHERS).visitor(SENDERS).start()
}

#[test]
fn who_comes_is_greeted_and_finds_nothing_of_who_was_there_before() {
    let mut bench = start();
    assert_eq!(bench.hear_on(SENDER, 0.1), "", "nobody is there");
    bench.set_open(SENDER, true);
    assert_eq!(bench.hear_on(SENDER, 0.1), "Grbl 1.1f ['$' for help]\n");
    bench.type_on(SENDER, "G1 X1");
    bench.hear(0.1);
    bench.set_open(SENDER, false);
    bench.hear(0.1);
    bench.set_open(SENDER, true);
    assert_eq!(bench.hear_on(SENDER, 0.1), "Grbl 1.1f ['$' for help]\n");
    bench.type_on(SENDER, "00\n");
    let answer = bench.hear_on(SENDER, 0.1);
    assert!(answer.ends_with("error:1\n"), "half a line of the one before was kept: {answer}");
}

#[test]
fn each_is_answered_alone_and_in_its_dialect() {
    let mut bench = start();
    bench.set_open(SENDER, true);
    bench.set_open(WATCHER, true);
    bench.hear(0.1);
    let _greetings = (bench.hear_on(SENDER, 0.01), bench.hear_on(WATCHER, 0.01));
    bench.type_on(SENDER, "$G\n?");
    let answer = bench.hear_on(SENDER, 0.1);
    assert!(answer.contains("[GC:") && answer.contains("<Idle"), "{answer}");
    assert_eq!(bench.hear(0.1), "", "the console hears what it did not ask");
    assert_eq!(bench.hear_on(WATCHER, 0.1), "");
    bench.type_on(SENDER, "M112\n");
    bench.hear(0.1);
    bench.type_on(SENDER, "G0 X1\n");
    assert!(bench.hear_on(SENDER, 0.1).ends_with("error:9\n"));
    assert_eq!(bench.say("G0 X1"), "!!\n");
}

#[test]
fn who_only_watches_may_ask_and_stop_and_no_more() {
    let mut bench = start();
    bench.set_open(WATCHER, true);
    assert_eq!(bench.hear_on(WATCHER, 0.1), "watching\n");
    bench.type_on(WATCHER, "M105\n");
    let answer = bench.hear_on(WATCHER, 0.1);
    assert!(answer.starts_with("ok ") && answer.contains(" T:"), "{answer}");
    bench.type_on(WATCHER, "M104 S200\n");
    assert!(bench.hear_on(WATCHER, 0.1).starts_with("error:this session may ask"));
    bench.hear(0.5);
    assert_eq!(bench.duty("hotend"), 0.0);
    bench.type_on(WATCHER, "M112\n");
    bench.hear(0.1);
    assert!(bench.status().starts_with("<Alarm"), "{}", bench.status());
    bench.type_on(WATCHER, "$X\n");
    bench.hear(0.1);
    assert!(bench.status().starts_with("<Alarm"), "a watcher unlocked the machine");
}

#[test]
fn one_who_takes_three_bytes_at_a_time_loses_nothing_and_holds_up_nobody() {
    let mut bench = start();
    bench.set_open(SENDER, true);
    let _greeting = bench.hear_on(SENDER, 0.1);
    bench.set_room(SENDER, 3);
    bench.type_on(SENDER, "help\n");
    let (mut slow, mut answers) = (String::new(), 0);
    while !slow.ends_with("\nok\n") {
        slow += &bench.hear_on(SENDER, 0.001);
        answers += usize::from(bench.ask("M105").contains(" T:"));
        assert!(answers < 2_000, "{slow}");
    }
    assert!(answers > 10, "{answers}: {slow}");
    let mut quick = bench.ask("help");
    while !quick.ends_with("\nok\n") {
        quick += &bench.hear(0.1);
    }
    // In its dialect each line is a message.
    let quick: String = quick
        .lines()
        .map(|line| if line == "ok" || line.starts_with('$') { format!("{line}\n") } else { format!("[MSG:{line}]\n") })
        .collect();
    assert_eq!(slow, quick);
}

/// What M500 would save is said part by part: each waits until the one before it has been taken.
#[test]
fn settings_come_whole_to_one_who_takes_three_bytes_at_a_time() {
    let mut bench = start();
    bench.set_open(SENDER, true);
    let _greeting = bench.hear_on(SENDER, 0.1);
    bench.set_room(SENDER, 3);
    bench.type_on(SENDER, "M503\n");
    let (mut slow, mut answers) = (String::new(), 0);
    while !slow.ends_with("\nok\n") {
        slow += &bench.hear_on(SENDER, 0.001);
        answers += usize::from(bench.ask("M105").contains(" T:"));
        assert!(answers < 4_000, "{slow}");
    }
    assert!(answers > 10, "others are answered meanwhile: {answers}");
    bench.set_room(SENDER, usize::MAX);
    assert_eq!(slow, bench.say_on(SENDER, "M503"));
    let parts = ["M92 ", "M204 ", "M205 ", "M203 ", "M301 ", "M907 "];
    let places: Vec<_> = parts.iter().map(|part| slow.find(part)).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}: {slow}");
}
