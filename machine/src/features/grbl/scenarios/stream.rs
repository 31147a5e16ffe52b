//! A file from a sender that counts characters.

use std::collections::VecDeque;

use scenarios::Bench;

use super::start;

/// A sender that counts characters: it keeps the machine's buffer as full as it may, and takes one line off
/// its count with each answer. A report every so often must not confuse it.
fn stream(bench: &mut Bench, lines: &[String], buffer: usize) -> Vec<String> {
    let (mut sent, mut counts, mut answers) = (0, VecDeque::new(), Vec::new());
    let (mut heard, mut reports, end) = (String::new(), 0, bench.now_s() + 600.0);
    while answers.len() < lines.len() {
        assert!(bench.now_s() < end, "{} of {} answers", answers.len(), lines.len());
        while sent < lines.len() && counts.iter().sum::<usize>() + lines[sent].len() < buffer {
            bench.type_in(&format!("{}\n", lines[sent]));
            counts.push_back(lines[sent].len() + 1);
            sent += 1;
        }
        if answers.len() / 10 > reports {
            bench.type_in("?");
            reports += 1;
        }
        heard += &bench.hear(0.001);
        while let Some((line, rest)) = heard.split_once('\n') {
            if line == "ok" || line.starts_with("error:") {
                assert!(counts.pop_front().is_some(), "an answer to nothing");
                answers.push(line.to_owned());
            } else {
                assert!(line.starts_with(['<', '[']), "{line}");
            }
            heard = rest.to_owned();
        }
    }
    assert!(bench.hear(0.2).lines().all(|line| line.starts_with('<')), "more answers than lines");
    answers
}

#[test]
fn a_sender_that_counts_characters_never_loses_step() {
    // GRBL's own buffer, and the one that `$I` and `Bf` state.
    for buffer in [127, 4_095] {
        let mut bench = start();
        bench.run(&["$H", "G21 G91"]);
        let mut lines = Vec::new();
        for n in 0..600 {
            lines.push(match n % 20 {
                7 => "(a comment)".into(),
                11 => "G999".into(),
                13 => "$J=X1 F100 Q1".into(),
                17 => format!("G1 X{} F3000 ; {}", if n % 40 < 20 { 0.1 } else { -0.1 }, "y".repeat(100)),
                19 if buffer > 300 => "X1".repeat(150),
                n => format!("G1 X{} F3000", if n % 2 == 0 { 0.2 } else { -0.2 }),
            });
        }
        let answers = stream(&mut bench, &lines, buffer);
        for (line, answer) in lines.iter().zip(&answers) {
            let expected = match line.as_bytes() {
                b"G999" => "error:20",
                [b'$', ..] => "error:16",
                [b'X', ..] => "error:11",
                _ => "ok",
            };
            assert_eq!(answer, expected, "{line}");
        }
        assert!(bench.status().contains("Idle") || bench.moves());
    }
}
