//! Klipper's macros from a printer.cfg on the card, carried out by a whole machine.

mod force_move;
mod homing;
mod looks;
mod templates;
mod variables;
mod z_offset;

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta};

/// Returns a plan for a machine with these macros.
pub(crate) fn with(text: &str) -> Plan {
    Plan::new(CARTESIAN).adding("\n[macros]\nfile = printer.cfg\n").file("printer.cfg", text)
}

/// Returns the places of the carriages, relative to their start, rounded to hundredths of a millimetre.
#[track_caller]
fn place(bench: &Bench) -> [i64; 2] {
    let begun = Plan::new(CARTESIAN).start();
    [Alpha, Beta].map(|motor| ((bench.carriage(motor) - begun.carriage(motor)) * 100.0).round() as i64)
}

const START: &str = "\
[gcode_macro PRINT_START]
description: Begins a print
gcode:
    {% set bed = params.BED|default(50)|int %}
    # a comment
    M140 S{bed}
    G91
    {% for turn in range(2) %}
        G1 X{ bed / 20 } F3000
    {% endfor %}
    RESPOND MSG=\"bed {bed}\"
";

#[test]
fn a_macro_is_rendered_with_its_parameters_and_carried_out() {
    let mut bench = with(START).start();
    assert_eq!(bench.say("PRINT_START BED=60"), "echo: bed 60\nok\n");
    bench.say("M400");
    assert_eq!(place(&bench), [600, 0]);
    assert!(bench.say("get temp bed").contains("/60.0"));
    assert_eq!(bench.say("print_start"), "echo: bed 50\nok\n", "in lower case too");
}

#[test]
fn viewers_are_told_of_macros_and_of_others_after_a_reload() {
    let text = "[printer]\n[gcode_macro First]\ndescription: says é\n  and\tmore\ngcode:\n G4\n[delayed_gcode x]\ngcode:\n G4\n\
                [gcode_macro AGAIN]\ngcode:\n G4\n[gcode_macro _hidden]\ngcode:\n G4\n\
                [gcode_macro again]\ndescription: the later one\n";
    let mut bench = with(text).start();
    let macros = |bench: &mut Bench| {
        bench.network(|network| (network.wants_macros, network.macros, network.is_viewed) = (true, Vec::new(), true));
        bench.hear(0.1);
        bench.network(|network| {
            assert!(!network.wants_macros, "the end is told");
            let number = network.shown.as_ref().expect("a machine that is looked at").macros;
            (number, std::mem::take(&mut network.macros))
        })
    };
    let row = |name: &str, about: &str| (name.to_owned(), about.to_owned());
    let (before, told) = macros(&mut bench);
    assert_eq!(told, [row("First", "says é and more"), row("_hidden", ""), row("again", "the later one")]);
    let long = format!("[gcode_macro LONG]\ndescription: {}\ngcode:\n G4\n", "é".repeat(100));
    bench.write_card("printer.cfg", long.as_bytes());
    assert_eq!(bench.say("macros reload"), "1 macros in 1 sections\nok\n");
    let (after, told) = macros(&mut bench);
    assert_eq!(told, [row("LONG", &"é".repeat(48))]);
    assert_ne!(before, after);
}

#[test]
fn an_error_is_named_with_its_place_and_nothing_is_carried_out() {
    let text = "[printer]\n[gcode_macro ONE]\ngcode:\n  G91\n  G1 X5 F3000\n\n  ; no\n    G1 X{ nothing.more }\n\
                [gcode_macro TWO]\ngcode:\n G91\n G1 X5 F3000\n {% if %}\n[gcode_macro THREE]\ngcode:\n G91\n G1 X5\n \
                {action_raise_error('no bed')}\n";
    let mut bench = with(text).start();
    let said = bench.say("ONE");
    assert!(said.starts_with("error:printer.cfg line 8 column 9: nothing"), "{said}");
    let said = bench.say("TWO");
    assert!(said.starts_with("error:printer.cfg line 13 column"), "{said}");
    assert_eq!(bench.say("THREE"), "error:no bed\n");
    bench.say("M400");
    assert_eq!(place(&bench), [0, 0]);
    assert!(bench.say("NOT_THERE").starts_with("error:NOT_THERE is not known here"));
}

#[test]
fn macros_call_each_other_and_not_themselves() {
    let text = "[gcode_macro OUTER]\ngcode:\n  G91\n  INNER BY=2\n  G1 Y{2} F3000\n  INNER BY=3\n\
                [gcode_macro INNER]\ngcode:\n  G1 X{params.BY} F3000\n\
                [gcode_macro LOOPS]\ngcode:\n  G91\n  G1 X1 F3000\n  AGAIN\n  G1 X100\n[gcode_macro AGAIN]\ngcode: LOOPS\n";
    let mut bench = with(text).start();
    bench.run(&["OUTER", "M400"]);
    assert_eq!(place(&bench), [500, 200]);
    let said = bench.say("LOOPS");
    assert!(said.contains("LOOPS: a macro that is under way is called recursively"), "{said}");
    bench.run(&["M400", "OUTER"]);
    bench.say("M400");
    assert_eq!(place(&bench), [1100, 400]);
}

#[test]
fn a_macro_sees_the_machine_as_it_was_when_it_was_called() {
    let tell = "RESPOND MSG=\"{printer.extruder.temperature|round|int} {printer.extruder.target|int}\"";
    let text = std::format!("[gcode_macro HEAT]\ngcode:\n  M109 S50\n  {tell}\n[gcode_macro TELL]\ngcode: {tell}\n");
    let mut bench = with(&text).start();
    let said = bench.say("HEAT");
    assert!(said.contains("echo: 22 0\n"), "{said}");
    let said = bench.say("TELL");
    let told: Vec<u32> = said.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    assert!(told.len() == 2 && (45..=55).contains(&told[0]) && told[1] == 50, "{said}");
}

#[test]
fn a_job_calls_macros_and_is_aborted_within_one() {
    let text = std::format!("{START}[gcode_macro HEAT]\ngcode:\n  M109 S200\n  G1 X100\n");
    let plan = with(&text).file("a.g", "G91\nPRINT_START BED=20\nG1 Y3 F3000\n").file("b.g", "HEAT\nG1 X50 F3000\n");
    let mut bench = plan.start();
    bench.type_in("M32 a.g\n");
    bench.hear_until("Done printing file", 60.0);
    assert_eq!(place(&bench), [200, 300]);
    bench.type_in("M32 b.g\n");
    bench.hear(2.0);
    assert!(bench.say("get temp hotend").contains("/200.0"));
    let begun = bench.now_s();
    bench.type_in("abort\n");
    bench.hear_until("abort to complete", 1.0);
    assert!(bench.now_s() - begun < 0.05, "{}", bench.now_s() - begun);
    bench.hear(0.5);
    assert_eq!(place(&bench), [200, 300]);
    assert_eq!(bench.say("PRINT_START"), "echo: bed 50\nok\n");
}

#[test]
fn a_line_that_is_refused_ends_the_macro_and_pauses_the_job() {
    let text = "[gcode_macro ONE]\ngcode:\n  G91\n  G1 X1 F3000\n  SET_FAN_SPEED FAN=none SPEED=1\n  G1 X50\n";
    let mut bench = with(text).file("a.g", "ONE\nG1 X70\n").start();
    let said = bench.say("ONE");
    assert!(said.contains("names no switch") && said.contains("// the macro ONE has ended"), "{said}");
    bench.type_in("M32 a.g\n");
    let said = bench.hear_until("paused", 10.0);
    assert!(said.contains("names no switch"), "{said}");
    bench.hear(0.5);
    assert_eq!(place(&bench), [200, 0]);
}

#[test]
fn macros_take_codes_and_leave_them_another_name() {
    let text = "[gcode_macro M109]\nrename_existing: M109.1\ngcode:\n  RESPOND MSG=\"heats to {params.S}\"\n  \
                M109.1 S{params.S}\n[gcode_macro G28.1]\ngcode: RESPOND MSG=\"parks {rawparams}\"\n\
                [gcode_macro M117]\nrename_existing: M117.1\ngcode:\n  RESPOND MSG=\"{rawparams}\"\n\
                [gcode_macro PAUSE]\nrename_existing: BASE_PAUSE\ngcode:\n  RESPOND MSG=pauses\n  BASE_PAUSE\n";
    let mut bench = with(text).file("a.g", "G91\nG1 X1 F600\nPAUSE\nG1 X1\n").start();
    let said = bench.say("M109 S40");
    assert!(said.contains("echo: heats to 40\n"), "{said}");
    assert!(bench.say("get temp hotend").contains("/40.0"));
    assert_eq!(bench.say("G28.1 X"), "echo: parks X\nok\n");
    assert_eq!(bench.say("M117 Hello you"), "echo: Hello you\nok\n");
    bench.type_in("M32 a.g\n");
    let said = bench.hear_until("resume to continue", 10.0);
    assert!(said.contains("echo: pauses\n"), "{said}");
    bench.run(&["M109.1 S0"]);
    bench.type_in("resume\n");
    bench.hear_until("Done printing file", 30.0);
    assert_eq!(place(&bench), [200, 0]);
}

#[test]
fn moves_can_be_taken_too() {
    let text = "[gcode_macro G1]\nrename_existing: G1.1\ngcode:\n  G1.1 {rawparams|replace('X', 'Y')}\n";
    let mut bench = with(text).start();
    bench.run(&["G91", "G1 X2.5 F3000", "G0 X1", "M400"]);
    assert_eq!(place(&bench), [100, 250]);
}

#[test]
fn the_file_is_listed_and_read_anew() {
    let mut bench = with(START).start();
    assert_eq!(bench.say("macros"), "PRINT_START - Begins a print\nok\n");
    assert_eq!(bench.say("macros reload"), "1 macros in 1 sections\nok\n");
    let mut bench = Plan::new(CARTESIAN).start();
    assert!(bench.say("macros").starts_with("error:there are no macros"));
    let mut bench = Plan::new(CARTESIAN).adding("\n[macros]\nfile = printer.cfg\n").start();
    assert!(bench.greeting().contains("WARNING: macros: printer.cfg: no such file"), "{}", bench.greeting());
    assert!(bench.say("macros reload").contains("no such file"));
}

#[test]
fn a_macro_is_held_and_goes_on() {
    let text = "[gcode_macro MOVES]\ngcode:\n  G91\n  {% for turn in range(4) %}\n    G1 X5 F600\n  {% endfor %}\n";
    let mut bench = with(text).start();
    bench.type_in("MOVES\n");
    bench.hear(0.7);
    bench.type_in("!");
    bench.hear(1.0);
    let held = place(&bench);
    bench.hear(1.0);
    assert_eq!(place(&bench), held);
    assert!((100..2000).contains(&held[0]), "{held:?}");
    bench.type_in("~");
    bench.hear(4.0);
    assert_eq!(place(&bench), [2000, 0]);
}

#[test]
fn a_macro_stops_the_machine() {
    let text = "[gcode_macro STOPS]\ngcode:\n  G91\n  G1 X5 F600\n  {action_emergency_stop('too hot')}\n";
    let mut bench = with(text).start();
    bench.type_in("STOPS\n");
    let heard = bench.hear_until("too hot", 1.0);
    assert!(heard.contains("ALARM: too hot"), "{heard}");
    bench.hear(1.0);
    assert_eq!(place(&bench), [0, 0]);
    assert!(bench.status().starts_with("<Alarm"));
    bench.type_in("M999\n");
    bench.hear(0.5);
    assert!(bench.say("NOTHING").starts_with("error:NOTHING is not known"));
}

#[test]
fn programs_with_o_words_call_macros() {
    let text = "[gcode_macro STEP_ASIDE]\ngcode:\n  G1 Y{params.BY} F3000\n";
    let program = "G91\nO1 repeat [3]\nSTEP_ASIDE BY=2\nG1 X1 F3000\nO1 endrepeat\n";
    let mut bench = with(text).file("a.ngc", program).start();
    bench.type_in("M32 a.ngc\n");
    let heard = bench.hear_until("Done printing file", 20.0);
    assert!(!heard.contains("error"), "{heard}");
    assert_eq!(place(&bench), [300, 600]);
}

#[test]
fn many_macros_within_each_other_are_refused_and_forgotten() {
    let mut text = String::from("[gcode_macro DEEP_14]\ngcode: G4 P1\n");
    for depth in 0..14 {
        text += &std::format!("[gcode_macro DEEP_{depth}]\ngcode: DEEP_{}\n", depth + 1);
    }
    let mut bench = with(&text).start();
    let said = bench.say("DEEP_0");
    assert!(said.contains("more than 12 deep"), "{said}");
    bench.run(&["DEEP_4", "DEEP_3"]);
}

#[test]
fn what_is_too_large_is_refused_with_its_size() {
    let text = "[gcode_macro LINES]\ngcode:\n  {% for turn in range(2000) %}\n    G1 X{turn}\n  {% endfor %}\n\
                [gcode_macro LONG]\ngcode: M117 {'x' * 300}\n[gcode_macro ASKS]\n\
                gcode: M117 {printer.configfile.config.big.text}\n[big]\ntext: "
        .to_string()
        + &"word ".repeat(400);
    let mut bench = with(&text).start();
    let said = bench.say("LINES");
    assert!(said.contains("11264"), "{said}");
    let said = bench.say("LONG");
    assert!(said.contains("more than 255 bytes"), "{said}");
    let said = bench.say("ASKS");
    assert!(said.contains("more than 1024 bytes"), "{said}");
}
