//! The table of `docs/safety.md`, made of the fault table and of tests elsewhere. No row can be without its
//! test: those of the table are run, those elsewhere are looked for in their files.

use std::fmt::Write as _;
use std::path::PathBuf;

use super::TABLE;

/// A fault that is tested on the native runner, beside its code or in another file here.
struct Elsewhere {
    what: &'static str,
    does: &'static str,
    /// Files and functions of the tests.
    tests: &'static [(&'static str, &'static str)],
}

const ELSEWHERE: &[Elsewhere] = &[
    Elsewhere {
        what: "another sensor open, shorted, without supply, or of another kind than described; a part of a combined one",
        does: "the same as for a thermistor, with words that say what to check",
        tests: &[
            ("tests/tests/sensors.rs", "every_analogue_kind_heats_to_its_target_and_stops_with_its_own_words"),
            ("tests/tests/sensors.rs", "a_heater_by_a_combined_sensor_halts_when_a_part_fails_and_says_which"),
        ],
    },
    Elsewhere {
        what: "heaters of twelve kinds, broken in eleven ways at any moment; sound ones in bad weather",
        does: "every broken one is found, no sound one is stopped ([heat-safety.md](heat-safety.md))",
        tests: &[
            ("tests/tests/heat_plants/mod.rs", "every_broken_heater_is_found"),
            ("tests/tests/heat_plants/mod.rs", "no_sound_heater_is_stopped"),
        ],
    },
    Elsewhere {
        what: "a reading that freezes while its heater holds, whose converter goes on",
        does: "halt as soon as the output is another, for so long that the reading would be",
        tests: &[
            ("thermal/src/safety/tests.rs", "a_reading_that_stands_while_the_output_changes_is_nobodys"),
            ("thermal/src/safety/tests.rs", "a_reading_may_stand_as_long_as_its_output_does"),
        ],
    },
    Elsewhere {
        what: "a single wire of a platinum sensor open or at ground, behind a MAX31865",
        does: "found by the chip's own test within five seconds: the heater off, halt after four looks, with what to check",
        tests: &[
            (
                "tests/tests/spi_sensors.rs",
                "a_single_wire_of_platinum_that_is_open_or_at_ground_is_found_by_the_chips_test",
            ),
            ("virtual-prime/tests/spi_sensors.rs", "a_max31865_tests_its_wires"),
        ],
    },
    Elsewhere {
        what: "a sensor that slides out, or drifts, so slowly that control follows; the heater has a model",
        does: "told when its heater takes 40 % more heat, or less, than the model explains, for a minute",
        tests: &[(
            "tests/tests/heat_control/codes.rs",
            "a_sensor_that_slides_out_slowly_is_told_by_what_its_heater_takes",
        )],
    },
    Elsewhere {
        what: "heater too slow",
        does: "halt when `runaway_heating_timeout` is over",
        tests: &[("machine/tests/faults.rs", "a_heater_that_is_too_slow_is_given_up_when_its_time_is_over")],
    },
    Elsewhere {
        what: "a fan with a tachometer that has no power",
        does: "nothing: that is no fault",
        tests: &[(
            "machine/src/features/automatic_outputs/scenarios.rs",
            "a_fan_that_stops_is_told_once_or_halts_and_one_without_power_is_not",
        )],
    },
    Elsewhere {
        what: "a mistake of control: a pin on without a target",
        does: "outputs closed and halt after two looks, 0.1 s",
        tests: &[("thermal/src/safety/tests.rs", "a_pin_that_is_on_for_nobody_is_told_and_closed")],
    },
    Elsewhere {
        what: "heater at full output, or at one target, for too long",
        does: "halt, where `full_power_timeout` or `hold_timeout` says so",
        tests: &[("thermal/src/safety/tests.rs", "time_limits_count_from_the_last_pause_and_from_the_target")],
    },
    Elsewhere {
        what: "executor silent for ten seconds",
        does: "heaters off",
        tests: &[("thermal/src/control/tests.rs", "a_dead_executor_cools_the_machine")],
    },
    Elsewhere {
        what: "heat control stops ticking and the rest goes on",
        does: "outputs off within a second",
        tests: &[(
            "thermal/src/control/tests.rs",
            "a_stalled_control_tick_switches_heaters_off_but_leaves_fans_turning",
        )],
    },
    Elsewhere {
        what: "halt while a probe is out, in a paper test, in a calibration",
        does: "nothing of it goes on and nothing was changed; the probe stays out, which is said",
        tests: &[
            ("machine/src/features/paper/scenarios.rs", "a_halt_in_any_state_ends_it_and_changes_nothing"),
            ("tests/tests/probe_scripts.rs", "after_a_halt_anywhere_nothing_moves_and_m402_stows"),
        ],
    },
    Elsewhere {
        what: "a probe that does not come out, or comes off, where an input tells",
        does: "refused; nothing is probed",
        tests: &[
            ("tests/tests/probe_scripts.rs", "a_probe_that_does_not_come_out_probes_nothing"),
            ("tests/tests/probe_scripts.rs", "a_probe_that_comes_off_is_noticed"),
        ],
    },
    Elsewhere {
        what: "sparks on the probe's wire",
        does: "with `debounce_ms` the search goes on; after three of them, halt",
        tests: &[
            ("tests/tests/probing/faults.rs", "with_debounce_a_spark_does_not_count_and_the_search_goes_on"),
            ("tests/tests/probing/faults.rs", "a_contact_that_never_stays_is_the_wirings_fault"),
        ],
    },
    Elsewhere {
        what: "a frame's sensor reads nonsense",
        does: "Z is shifted by `max_adjust` at most, with moves that name Z",
        tests: &[("tests/tests/thermal_adjust.rs", "no_more_than_max_adjust_whatever_the_sensor_says")],
    },
    Elsewhere {
        what: "a move of a homed axis out of its travel, or an arc or spline that bulges out",
        does: "refused before it starts, and a file being played waits there; halt with `[soft endstop] halt`, which `grbl_mode` implies",
        tests: &[
            ("machine/tests/soft_endstops.rs", "a_move_out_of_the_travel_is_refused_and_nothing_moves"),
            ("machine/tests/soft_endstops.rs", "a_file_waits_at_the_line_that_would_leave_the_travel"),
            ("machine/tests/soft_endstops.rs", "a_halt_where_it_is_asked_for"),
        ],
    },
    Elsewhere {
        what: "a heater, switch, extruder or the probe wrong in the configuration",
        does: "that part is not wired and stays off; asking for it is refused, and halts a file being played",
        tests: &[
            ("machine/tests/out_of_service.rs", "a_broken_bed_stays_cold_and_the_machine_prints_without_it"),
            ("machine/tests/out_of_service.rs", "a_job_that_needs_a_part_that_is_off_halts"),
        ],
    },
    Elsewhere {
        what: "another card, another file or the file edited meanwhile",
        does: "refused, and the job waits; nothing is made",
        tests: &[
            ("virtual-prime/tests/card.rs", "a_job_whose_card_was_out_goes_on_when_its_own_is_back"),
            ("machine/src/features/power_loss/scenarios/mod.rs", "one_digit_of_the_file_is_noticed"),
        ],
    },
    Elsewhere {
        what: "file, card or configuration changed before going on after a power cut",
        does: "refused, with what changed; nothing moves or heats",
        tests: &[
            ("machine/src/features/power_loss/scenarios/mod.rs", "another_file_of_this_name_is_refused"),
            (
                "machine/src/features/power_loss/scenarios/mod.rs",
                "another_configuration_is_refused_and_another_comment_is_none",
            ),
        ],
    },
    Elsewhere {
        what: "card that takes no writes, or takes 250 ms for each",
        does: "told, and the job is made without a journal; no step moves",
        tests: &[
            ("virtual-prime/tests/card.rs", "a_protected_card_has_no_journal_and_the_job_is_played"),
            ("virtual-prime/tests/card.rs", "a_slow_card_delays_no_step"),
        ],
    },
    Elsewhere {
        what: "power cut at any block write of a job with a journal: the write kept, torn or lost",
        does: "what is offered afterwards goes on with the same part, or nothing is offered; nothing moves or heats by itself",
        tests: &[
            (
                "machine/src/features/power_loss/scenarios/mod.rs",
                "a_part_is_the_same_after_a_cut_at_some_of_its_writes",
            ),
            ("virtual-prime/tests/power_cuts.rs", "a_part_is_the_same_after_a_write_that_was_lost"),
        ],
    },
    Elsewhere {
        what: "brown-out: the motor supply falls under a job with a journal",
        does: "heaters off, then the motors brake, and the job is noted twice before the voltage is gone",
        tests: &[("virtual-prime/tests/power_cuts.rs", "a_supply_that_falls_is_noted_before_it_is_gone")],
    },
    Elsewhere {
        what: "halt in any step of homing, probing, leveling, alignment, a change of filament or tools, going on behind it, a test of an axis",
        does: "heaters off, motors without current, halted; after M999 it homes and moves, and nothing of it comes back",
        tests: &[
            ("machine/tests/halt_walk.rs", "homing"),
            ("machine/tests/halt_walk.rs", "probing_and_leveling"),
            ("machine/tests/halt_walk.rs", "changes_of_tools"),
        ],
    },
    Elsewhere {
        what: "halt in any step of going on with a job",
        does: "outputs off; what is offered afterwards is right",
        tests: &[(
            "machine/src/features/power_loss/scenarios/mod.rs",
            "a_halt_in_any_step_leaves_an_offer_that_is_right",
        )],
    },
    Elsewhere {
        what: "M112, Ctrl-X or the kill button in every state",
        does: "nothing heats, burns or turns within a millisecond",
        tests: &[
            ("machine/tests/state_walk.rs", "wherever_it_is_it_is_safe_within_a_millisecond"),
            ("virtual-prime/tests/operation/halts.rs", "m112_stops_the_machine_in_every_state"),
            ("virtual-prime/tests/operation/halts.rs", "the_kill_button_stops_the_machine_in_every_state"),
        ],
    },
    Elsewhere {
        what: "filament runs out at any moment of a job, beside one, or while halted",
        does: "told once; the job is suspended and waits for filament",
        tests: &[
            (
                "machine/src/features/filament/scenarios/mod.rs",
                "filament_that_runs_out_at_any_moment_of_a_job_is_told_and_all_is_printed",
            ),
            (
                "machine/src/features/filament/scenarios/mod.rs",
                "filament_that_runs_out_beside_a_job_is_told_once_or_not",
            ),
        ],
    },
];

const BEGIN: &str = "<!-- The fault table: written by WRITE_SAFETY=1, see virtual-prime/tests/faults. -->\n";
const END: &str = "<!-- End of the fault table. -->\n";

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Formats a limit in tenths below a millisecond, in whole milliseconds below a second, in tenths of a second
/// above.
fn limit(ms: f64) -> String {
    match ms {
        ..1.0 => format!("{ms:.1} ms"),
        1.0..1_000.0 => format!("{ms:.0} ms"),
        _ => format!("{:.1} s", ms / 1e3),
    }
}

fn table() -> String {
    let mut text = String::from(BEGIN);
    for (part, classes) in TABLE {
        let _ =
            write!(text, "\n### {part}\n\n| what fails | what the machine does | while; at most |\n|---|---|---|\n");
        for class in *classes {
            let words = |case: &super::Case| match case.within_ms {
                0.0 => case.state.words().to_owned(),
                within => format!("{} {}", case.state.words(), limit(within)),
            };
            let cases: Vec<String> = class.cases.iter().map(words).collect();
            let _ = writeln!(text, "| {} | {} | {} |", class.what, class.does, cases.join("; "));
        }
    }
    text += "\n### Tested elsewhere\n\n| what fails | what the machine does | tested in |\n|---|---|---|\n";
    for row in ELSEWHERE {
        let mut files: Vec<&str> = row.tests.iter().map(|(file, _)| *file).collect();
        files.dedup();
        let _ = writeln!(text, "| {} | {} | `{}` |", row.what, row.does, files.join("`, `"));
    }
    text + "\n" + END
}

#[test]
fn the_safety_document_is_this_table() {
    let path = root().join("docs/safety.md");
    let page = std::fs::read_to_string(&path).expect("docs/safety.md");
    let (before, rest) = page.split_once(BEGIN).expect("where the table begins");
    let (_, after) = rest.split_once(END).expect("where the table ends");
    let made = format!("{before}{}{after}", table());
    if std::env::var_os("WRITE_SAFETY").is_some() {
        std::fs::write(&path, made).expect("docs/safety.md");
    } else {
        assert!(page == made, "docs/safety.md is not the fault table: WRITE_SAFETY=1 writes it");
    }
}

#[test]
fn every_row_that_is_tested_elsewhere_has_its_test() {
    for row in ELSEWHERE {
        assert!(!row.tests.is_empty(), "{}", row.what);
        for (file, test) in row.tests {
            let source = std::fs::read_to_string(root().join(file)).expect(file);
            let place = source.find(&format!("fn {test}()")).unwrap_or_else(|| panic!("{file} has no {test}"));
            let attributes = source[..place].rsplit("\n\n").next().expect("what stands before it");
            assert!(attributes.contains("#[test]"), "{file}: {test} is no test");
        }
    }
}
