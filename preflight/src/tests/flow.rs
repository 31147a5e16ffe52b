//! Loops, subroutines, and where a file ends.

use super::{Desk, Found, Kind, assert_near, look, places};
use crate::{MOST_LINES, read};
use jobs::player::TOO_DEEP;

/// Reads a file beside others that hold subroutines.
fn beside(subs: &[(&str, &'static str)], text: &str) -> (Result<(), &'static str>, Found) {
    let mut found = Found::default();
    let sub = |name: &str| subs.iter().find(|(known, _)| *known == name).map(|(_, text)| text.as_bytes());
    let ended =
        Desk::new().preflight(text, |preflight, motion| read(preflight, text.as_bytes(), &sub, motion, &mut found));
    (ended, found)
}

#[test]
fn lines_of_a_loop_count_as_often_as_they_are_carried_out() {
    let (_, totals) = look("G28\nG91\nO1 repeat [3]\nG1 X5 F6000\nO1 endrepeat\n");
    assert_near(totals.travelled, 15.0);
    assert!(totals.lines > 5 + 2, "{} lines", totals.lines);
}

#[test]
fn a_finding_in_a_subroutine_names_its_file_and_line() {
    let sub = "O<far> sub\n\nG1 X999 F6000\nO<far> endsub\n";
    let (ended, found) = beside(&[("far", sub)], "G28\nO<far> call\nG1 Y999\n");
    assert_eq!(ended, Ok(()));
    let names: Vec<_> = found.0.iter().map(|finding| finding.sub.as_ref().map(ToString::to_string)).collect();
    assert_eq!(names, [Some("far".to_owned()), None]);
    assert_eq!(places(&found.0), [(3, Kind::OutOfTravel), (3, Kind::OutOfTravel)]);
    assert!(found.0[0].to_string().starts_with("far.ngc, line 3: stops: machine X 999.000"));
    assert!(found.0[1].to_string().starts_with("line 3: stops: machine Y 999.000"));
}

#[test]
fn files_that_call_each_other_too_deep_are_given_up() {
    let sub = "O<again> sub\nO<again> call\nO<again> endsub\n";
    let deep: Vec<(String, &'static str)> = (1..6)
        .map(|number| {
            let text = format!("O<s{number}> sub\nO<s{}> call\nO<s{number}> endsub\n", number + 1);
            (format!("s{number}"), &*Box::leak(text.into_boxed_str()))
        })
        .collect();
    let subs: Vec<(&str, &'static str)> = deep.iter().map(|(name, text)| (name.as_str(), *text)).collect();
    assert_eq!(beside(&subs, "O<s1> call\n").0, Err(TOO_DEEP));
    let (ended, found) = beside(&[("again", sub)], "O<again> call\n");
    assert!(ended == Err(TOO_DEEP) || places(&found.0)[0].1 == Kind::Flow, "a subroutine that calls itself");
}

#[test]
fn the_rest_behind_the_end_of_the_program_is_not_read() {
    for end in ["M2", "M30", "%\nG28\n%", "M99"] {
        let (found, totals) = look(&format!("{end}\nG777\n"));
        assert!(found.is_empty(), "{end}: {found:?}");
        assert_eq!(totals.lines as usize, end.lines().count(), "{end}");
    }
}

#[test]
fn what_is_left_open_at_the_end_is_said_but_not_behind_m2() {
    assert_eq!(places(&look("O1 if [1]\nG4 P1\n").0), [(2, Kind::Flow)]);
    assert!(look("O1 if [1]\nG4 P1\nM2\n").0.is_empty());
}

#[test]
fn an_endless_file_is_given_up_in_words() {
    Desk::new().preflight("", |preflight, _| {
        let mut found = Found::default();
        preflight.totals.lines = MOST_LINES;
        assert!(!preflight.is_endless(&mut found));
        preflight.totals.lines += 1;
        assert!(preflight.is_endless(&mut found));
        assert_eq!(places(&found.0), [(0, Kind::Unforeseen)]);
    });
}

#[test]
fn lines_that_cannot_be_read_are_damage_or_slips() {
    let long = format!("G1 X{}", "1".repeat(300));
    for (line, kind) in [
        (long.as_str(), Kind::Damage),
        ("N5 G1 X1*1", Kind::Damage),
        ("G1 \u{1}5", Kind::Damage),
        ("G1 X1.2.3", Kind::Text),
    ] {
        let (found, totals) = look(&format!("G28\n{line}\n"));
        assert_eq!((places(&found), totals.stops), (vec![(2, kind)], 1), "{line}");
    }
    let comment = format!("; {}", "x".repeat(300));
    assert!(look(&comment).0.is_empty(), "nobody reads a comment");
}

#[test]
fn branches_that_are_not_taken_are_passed_over() {
    let (found, totals) = look("G28\nO1 if [0]\nG777\nG1 X999 F600\nO1 endif\nG1 X5 F600\n");
    assert!(found.is_empty(), "{found:?}");
    assert_near(totals.travelled, 5.0);
}

#[test]
fn states_are_kept_by_their_names() {
    let (found, totals) = look(
        "G28\nG90\nG1 X100 F6000\nSAVE_GCODE_STATE NAME=out\nG91\nSAVE_GCODE_STATE NAME=in\nG1 X20\n\
         RESTORE_GCODE_STATE NAME=OUT MOVE=1 MOVE_SPEED=50\nG1 X0\nRESTORE_GCODE_STATE NAME=in\nG1 X150\n",
    );
    assert_eq!(found, Vec::new());
    assert_near(totals.travelled, 100.0 + 20.0 + 20.0 + 100.0 + 150.0);
    let many: String = (0..30).map(|name| format!("SAVE_GCODE_STATE NAME=n{name}\n")).collect();
    let (found, _) = look(&format!("{many}RESTORE_GCODE_STATE NAME=n29\nRESTORE_GCODE_STATE NAME=n1\n"));
    assert_eq!(places(&found), [(32, Kind::Unforeseen)], "a name that is not known stops no job: {found:?}");
}
