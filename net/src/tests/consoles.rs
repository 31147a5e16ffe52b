//! Visitors at the consoles.

use crate::testing::{Bench, DESK, MS, SECOND};
use crate::{Role, Service, Visitor};

#[test]
fn a_line_goes_to_the_console_and_an_answer_comes_back() {
    let mut bench = Bench::with_address();
    let client = bench.connect(23);
    bench.run(10 * MS);
    let visitor = Visitor { service: Service::Telnet, role: Role::Operate, from: DESK };
    assert_eq!(bench.lines[0].visitor, Some(visitor));
    bench.desk.send(client, b"M115\n");
    bench.run(20 * MS);
    assert_eq!(bench.lines[0].text(), "M115\n");
    bench.write(0, b"ok\n");
    assert_eq!(bench.hear(client, 20 * MS), "ok\n");
    bench.desk.tcp(client).close();
    bench.run(3 * SECOND);
    assert_eq!(bench.lines[0].visitor, None);
}

#[test]
fn two_visitors_of_a_service_have_a_console_each_and_the_third_is_told_so() {
    let mut bench = Bench::with_address();
    let (first, second) = (bench.connect(23), bench.connect(23));
    bench.run(10 * MS);
    assert!(bench.lines[0].visitor.is_some() && bench.lines[1].visitor.is_some());
    let third = bench.connect(23);
    assert_eq!(bench.hear(third, 100 * MS), "All consoles are in use.\r\n");
    let grbl = bench.connect(2323);
    bench.run(10 * MS);
    assert_eq!(bench.lines[2].visitor.map(|visitor| visitor.service), Some(Service::Grbl));
    bench.desk.tcp(first).abort();
    bench.desk.tcp(grbl).abort();
    bench.run(SECOND);
    assert!(bench.lines[0].visitor.is_none() && bench.lines[1].visitor.is_some());
    let again = bench.connect(23);
    bench.run(10 * MS);
    assert_eq!((bench.lines[0].visits, bench.lines[1].visits), (2, 1));
    for handle in [second, again] {
        assert!(bench.desk.tcp(handle).is_active());
    }
}

#[test]
fn a_sender_is_held_back_until_the_console_has_room_and_loses_nothing() {
    let mut bench = Bench::with_address();
    (bench.lines[0].size, bench.reads) = (64, 0);
    let client = bench.connect(23);
    let text: Vec<u8> = (0..20_000_u32).map(|index| b'a' + (index % 23) as u8).collect();
    let mut sent = 0;
    for turn in 0..40_000 {
        sent += bench.desk.send(client, &text[sent..]);
        bench.reads = usize::from(turn % 3 == 0) * 5;
        bench.step();
    }
    bench.reads = usize::MAX;
    assert!(bench.until(60 * SECOND, |bench| bench.lines[0].received.len() == text.len()));
    assert_eq!(sent, text.len());
    let received = &bench.lines[0].received;
    let same = received.iter().zip(&text).take_while(|(a, b)| a == b).count();
    assert_eq!((same, received.len()), (text.len(), text.len()));
}

#[test]
fn what_acts_at_once_does_so_before_lines_that_have_no_room() {
    let mut bench = Bench::with_address();
    (bench.lines[2].size, bench.reads) = (16, 0);
    let client = bench.connect(2323);
    bench.desk.send(client, b"G1 X1\nG1 X2\nG1 X3\nG1 X4\n?G1 X5\n!!?G1 X6\n");
    bench.run(100 * MS);
    assert_eq!(bench.lines[2].acted, b"?!!?");
    bench.desk.send(client, b"G1 X7\n?\n");
    bench.run(100 * MS);
    assert_eq!(bench.lines[2].acted, b"?!!??");
    bench.reads = 3;
    bench.run(SECOND);
    assert_eq!(bench.lines[2].text(), "G1 X1\nG1 X2\nG1 X3\nG1 X4\nG1 X5\nG1 X6\nG1 X7\n\n");
    assert_eq!(bench.lines[2].acted, b"?!!??", "each once");
}

#[test]
fn a_reset_overtakes_the_lines_before_it_and_drops_them() {
    let mut bench = Bench::with_address();
    (bench.lines[2].size, bench.reads) = (16, 0);
    let client = bench.connect(2323);
    bench.desk.send(client, b"G1 X1\nG1 X2\nG1 X3\nG1 X4\n?G1 X5\n\x18$X\n");
    bench.run(100 * MS);
    assert_eq!(bench.lines[2].acted, b"?\x18");
    bench.reads = 3;
    bench.run(SECOND);
    assert_eq!(bench.lines[2].text(), "$X\n");
}

#[test]
fn who_only_sends_hears_the_answers_and_does_not_keep_the_next_one_out() {
    let mut bench = Bench::with_address();
    for turn in 0..20 {
        let client = bench.connect(23);
        bench.desk.send(client, b"M115\n");
        bench.desk.tcp(client).close();
        let line = bench.until(SECOND, |bench| bench.lines.iter().any(|line| line.text() == "M115\n"));
        assert!(line, "visit {turn}");
        let line = bench.lines.iter().position(|line| line.text() == "M115\n").unwrap();
        bench.lines[line].received.clear();
        bench.write(line, b"ok\n");
        assert_eq!(bench.hear(client, 150 * MS), "ok\n", "visit {turn}");
    }
}
