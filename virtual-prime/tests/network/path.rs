//! The path as the machine makes it, asked for four times a second by a page.

use super::page::{OPEN, PAGE, call, socket};
use super::{Net, plan};
use crate::common::velvet::SECOND;

/// Radius and moves of a turn of the job, 0.13 mm each: 800 moves a second at 100 mm/s.
const RADIUS: f64 = 20.0;
const MOVES: u32 = 1_000;
const TURNS: u32 = 4;

/// Makes a spiral of short moves.
fn job() -> String {
    let mut job = String::from("G92 E0\nG1 F6000\n");
    for number in 1..=MOVES * TURNS {
        let angle = f64::from(number) / f64::from(MOVES) * std::f64::consts::TAU;
        let (x, y) = (60.0 + RADIUS * angle.cos(), 60.0 + RADIUS * angle.sin());
        job += &format!("G1 X{x:.3} Y{y:.3} E{:.4}\n", f64::from(number) * 0.005);
    }
    job
}

/// Reads the answer to a question for the path: its number to go on from, and its points.
fn read(answer: &str) -> (u32, Vec<[f64; 4]>) {
    assert!(answer.contains(r#""lost":false"#), "{answer}");
    let next = answer.split(r#""next":"#).nth(1).and_then(|rest| rest.split(',').next()).expect("next");
    let points = answer.split(r#""points":["#).nth(1).and_then(|rest| rest.split("]}").next()).expect("points");
    let numbers = |text: &str| -> [f64; 4] {
        let numbers: Vec<f64> = text.split(',').map(|number| number.parse().expect("a number")).collect();
        numbers.try_into().expect("four numbers")
    };
    let points = points.split(['[', ']']).filter(|text| text.contains(|letter: char| letter.is_ascii_digit()));
    (next.parse().expect("a number"), points.map(numbers).collect())
}

/// Takes the frames' heads out of what was sent: none is text.
fn ask(net: &mut Net, visitor: virtual_prime::net_desk::peer::Connection, seq: u32) -> (u32, Vec<[f64; 4]>) {
    net.peer.receive(visitor);
    call(net, visitor, "velvet.path.since", &format!(r#""seq":{seq}"#), 77);
    let (mut heard, end) = (Vec::new(), net.velvet.now_ms() + 2 * SECOND);
    while !heard.windows(7).any(|end| end == b"\"id\":77") {
        assert!(net.velvet.now_ms() < end, "no answer");
        net.run(1);
        heard.extend(net.peer.receive(visitor));
    }
    let text = texts(&heard);
    let answer = text.split(r#"{"jsonrpc""#).find(|message| message.contains(r#""id":77"#)).expect("an answer");
    read(answer)
}

/// Puts a server's frames of text together (RFC 6455 section 5.2); a last one that is not whole is left out.
fn texts(bytes: &[u8]) -> String {
    let (mut rest, mut text) = (bytes, Vec::new());
    while rest.len() >= 4 {
        let short = usize::from(rest[1]);
        let (length, head) =
            if short == 126 { (usize::from(rest[2]) << 8 | usize::from(rest[3]), 4) } else { (short, 2) };
        let Some(content) = rest.get(head..head + length) else { break };
        text.extend(content);
        rest = &rest[head + length..];
    }
    String::from_utf8_lossy(&text).into_owned()
}

#[test]
fn a_page_that_asks_four_times_a_second_gets_the_whole_path() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]).file("job.g", &job()));
    net.ask("G28.3 X80 Y60 Z10");
    let visitor = socket(&mut net);
    let (mut seq, points) = ask(&mut net, visitor, 0);
    assert!(seq == 0 && points.is_empty());
    net.ask("M23 job.g");
    let before = net.velvet.said().len();
    net.velvet.type_in("M24");
    let (mut path, mut most) = (Vec::new(), 0);
    let end = net.velvet.now_ms() + 30 * SECOND;
    while !net.velvet.said()[before..].contains("Done printing file") {
        assert!(net.velvet.now_ms() < end, "the job is not done");
        net.run(250);
        let (next, points) = ask(&mut net, visitor, seq);
        assert_eq!(next - seq, points.len() as u32);
        (seq, most) = (next, most.max(points.len()));
        path.extend(points);
    }
    path.extend(ask(&mut net, visitor, seq).1);
    assert_eq!(path[0], [80.0, 60.0, 10.0, 0.0], "where the job begins");
    println!("{} points for {} moves, {most} at the most in an answer", path.len(), MOVES * TURNS);
    assert!(path.len() > 200, "{} points", path.len());
    let mut turned = 0.0;
    for pair in path.windows(2) {
        let [one, other] = [pair[0], pair[1]].map(|at| (at[0] - 60.0, at[1] - 60.0));
        let middle = f64::hypot((one.0 + other.0) / 2.0, (one.1 + other.1) / 2.0);
        assert!((middle - RADIUS).abs() < 0.04 && pair[1][3] == 1.0, "the way to {:?} is off the circle", pair[1]);
        turned += (one.0 * other.1 - one.1 * other.0).atan2(one.0 * other.0 + one.1 * other.1);
    }
    assert!((turned / std::f64::consts::TAU - f64::from(TURNS)).abs() < 0.02, "{turned} rad of the whole way");
    assert!(net.ask("get steps").contains("late: 0 ("));
}
