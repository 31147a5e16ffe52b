//! Any bytes, in any pieces.

mod common;

use common::{Findings, SAMPLE, edited, read};
use config::{BoardId, MachineConfig};
use proptest::prelude::*;

proptest! {
    // A whole file a case: fewer are enough.
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn how_the_file_is_cut_into_pieces_does_not_matter(cuts in proptest::collection::vec(1_usize..300, 1..60)) {
        let text = edited("fan.output_pin = PE1 ", "fan.output_pin = PE3");
        let mut pieces = Findings::new();
        let mut config = MachineConfig::default();
        let mut reader = config::Reader::new(&mut config, BoardId::Prime2590, &mut pieces);
        let mut rest = text.as_bytes();
        for cut in cuts.into_iter().cycle() {
            let (piece, after) = rest.split_at(cut.min(rest.len()));
            reader.feed(piece);
            rest = after;
            if rest.is_empty() {
                break;
            }
        }
        let summary = reader.finish();
        prop_assert_eq!(summary.errors, 1);
        prop_assert_eq!(format!("{config:?}"), format!("{:?}", read(&text).0));
        prop_assert_eq!(pieces[0].to_string(), read(&text).1[0].to_string());
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..2_000)) {
        let mut findings = Findings::new();
        let (_, summary) = config::parse(&bytes, BoardId::Prime2660, &mut findings);
        prop_assert!(summary.fatals > 0, "no random bytes are a machine");
    }

    #[test]
    fn no_damaged_file_makes_it_panic(
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..40),
        length in any::<prop::sample::Index>(),
    ) {
        let mut bytes = SAMPLE.as_bytes().to_vec();
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        bytes.truncate(length.index(bytes.len()));
        let mut findings = Findings::new();
        let (_, summary) = config::parse(&bytes, BoardId::Prime2590, &mut findings);
        let listed = summary.total() as usize;
        prop_assert_eq!(findings.len(), listed.min(64));
        for finding in &findings {
            prop_assert!(!finding.reason.is_empty() && (finding.line == 0) == (finding.column == 0));
        }
    }

    #[test]
    fn no_lines_of_known_words_make_it_panic(
        lines in proptest::collection::vec(
            "(\\[(switch|actuator|endstops|tmc2590|temperature control|mpg|pwm1)\\]|(alpha|delta|fan|common|x)?\\.?(enable|pin|output_pin|tool_id|max_rate|microsteps|slaved_to) ?=? ?(true|PE1|-?[0-9]{1,12}|alpha|1e309)?)",
            0..60,
        ),
    ) {
        let mut findings = Findings::new();
        config::parse(lines.join("\n").as_bytes(), BoardId::Prime2590, &mut findings);
    }
}

/// Any setting of the schema with any value, right or not.
fn any_line() -> impl Strategy<Value = String> {
    let rows: Vec<(&str, String)> = config::schema::SECTIONS
        .iter()
        .flat_map(|section| {
            section.settings.iter().map(|row| {
                let key = match section.form {
                    config::schema::Form::Plain => row.key.to_owned(),
                    config::schema::Form::Keyed(_) => "vmotor".to_owned(),
                    config::schema::Form::Named(_) if row.is_common => format!("common.{}", row.key),
                    config::schema::Form::Named(_) => format!("alpha.{}", row.key),
                };
                (section.name, key)
            })
        })
        .collect();
    let value = "(true|false|nc|-?[0-9]{1,9}(\\.[0-9]{1,6})?|0x[0-9A-F]{1,8}|P[A-L][0-9]{1,2}[!o^v-]{0,2}|ADC[13]_[0-9]|PWM[12]_[1-5]|M[0-9]{1,4}|[XYZABC]{0,6}|[a-z_ ,]{0,40}|\\PC{0,20})";
    (proptest::sample::select(rows), value, any::<bool>()).prop_map(|((section, key), value, opens)| {
        if opens { format!("[{section}]\n{key} = {value}\n") } else { format!("{key} = {value}\n") }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The largest file the board takes, in pieces of a sector.
    #[test]
    fn no_file_of_64_kib_makes_it_panic_or_hang(lines in proptest::collection::vec(any_line(), 50..500)) {
        let bytes: Vec<u8> = lines.concat().bytes().cycle().take(64 * 1024).collect();
        let mut findings = Findings::new();
        let mut config = MachineConfig::default();
        let mut reader = config::Reader::new(&mut config, BoardId::Prime2660, &mut findings);
        bytes.chunks(512).for_each(|piece| reader.feed(piece));
        let summary = reader.finish();
        prop_assert!(!summary.is_complete() && findings.len() <= 64);
    }
}

/// `velvet check` answers at once, whatever the machine. The time is printed, not judged, as it depends on
/// the computer that runs the test. `cargo test -p config --release --test robustness -- --nocapture
/// long_configuration`
#[test]
fn a_long_configuration_has_no_finding() {
    let switches: String = (0..14)
        .flat_map(|i| {
            ["enable = false", "output_pin = PJ1", "output_type = digital", "input_on_command = M106"]
                .map(move |line| format!("s{i}.{line}\n"))
        })
        .chain((0..60).map(|i| format!("# comment {i}\n")))
        .collect();
    let text = SAMPLE.replace("[endstops]", &format!("{switches}[endstops]"));
    assert!(text.lines().count() > 300);
    let best = (0..5)
        .map(|_| {
            let since = std::time::Instant::now();
            assert!(read(&text).1.is_empty());
            since.elapsed()
        })
        .min();
    println!("{} lines in {best:?}, the best of five", text.lines().count());
}

#[test]
fn long_comments_are_fine_and_long_lines_are_not() {
    let (_, findings) = read(&edited("# mm/min, G1 until an F word", &format!("# {}", "x".repeat(5_000))));
    assert!(findings.is_empty(), "{findings:#?}");
    let (_, findings) = read(&format!("{SAMPLE}{}\n", "x".repeat(251)));
    assert!(findings[0].reason.contains("more than 250"), "{}", findings[0]);
}

#[test]
fn line_ends_and_marks_of_other_systems_are_fine() {
    let dos = format!("\u{feff}{}", SAMPLE.replace('\n', "\r\n"));
    let (config, findings) = read(&dos);
    assert!(findings.is_empty(), "{findings:#?}");
    assert_eq!(format!("{config:?}"), format!("{:?}", read(SAMPLE).0));
}

#[test]
fn a_full_list_keeps_errors_rather_than_warnings() {
    let many: String = (0..70).map(|i| format!("leftover_{i} = 1\n")).collect();
    let (_, findings) = read(
        &SAMPLE
            .replace("[planner]\n", &format!("[planner]\n{many}"))
            .replace("fan.output_pin = PE1 ", "fan.output_pin = PE3 "),
    );
    assert_eq!(findings.len(), 64);
    assert!(findings[63].reason.contains("PE3 is used"), "{}", findings[63]);
}

#[test]
fn too_many_instances_are_counted_not_lost() {
    let many: String = (0..16).map(|i| format!("s{i}.enable = false\n")).collect();
    let (_, findings) = read(&SAMPLE.replace("[endstops]", &format!("{many}[endstops]")));
    assert_eq!(findings.len(), 1, "{findings:#?}");
    assert!(findings[0].reason.contains("no room for switch 's15'"), "{}", findings[0]);
}
