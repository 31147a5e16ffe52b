//! Files on the SD card under long names, as written by the image and as seen by a PC.

use crate::common::velvet::{CONFIG, Plan, SECOND, Velvet};
use virtual_prime::sd_image;

const ONE: &str = "benchy_part_one.gcode";
const TWO: &str = "benchy_part_two.gcode";

/// Sends a file over the console.
#[track_caller]
fn upload(velvet: &mut Velvet, name: &str, lines: &[&str]) {
    assert_eq!(velvet.ask(&format!("M28 {name}"), SECOND), format!("Writing to file: {name}\nok\n"));
    for line in lines {
        velvet.ask(line, SECOND);
    }
    assert_eq!(velvet.ask("M29", SECOND), "Done saving file.\nok\n");
}

/// Returns the names that `ls -1` lists.
fn listed(velvet: &mut Velvet) -> Vec<String> {
    velvet.type_in("ls -1");
    let mut names: Vec<_> = velvet.hear(SECOND).lines().filter(|line| *line != "ok").map(str::to_owned).collect();
    names.sort();
    names
}

/// Returns the card's bytes, as if it were taken out.
fn card(velvet: &mut Velvet) -> Vec<u8> {
    let card = velvet.bench.vm.with(|stopped| {
        let card = stopped.session.board().mcu.sdmmc.card();
        card.map(|card| card.content().to_vec())
    });
    card.flatten().expect("a card in the slot")
}

/// Reads a file of the card as a PC does.
#[track_caller]
fn read(card: &[u8], name: &str) -> String {
    String::from_utf8(sd_image::read(card, name).expect("a file on the card")).expect("text")
}

/// M21 looks for the card anew, but only once everything is written to it: here a directory, whose entry is
/// written last, and the card takes its time.
#[test]
fn looking_for_the_card_loses_nothing() {
    let mut velvet = Plan::new().start();
    velvet.bench.vm.with(|stopped| {
        let card = stopped.session.board_mut().mcu.sdmmc.card_mut().expect("a card in the slot");
        card.trouble().slow_writes = (250 * 1_000_000, 1);
    });
    velvet.send_through(b"mkdir parts\nM21\n");
    velvet.hear_until("SD card ok\n", 10 * SECOND);
    assert!(listed(&mut velvet).contains(&"parts/".to_owned()), "{}", velvet.said());
    assert!(!velvet.said().contains("WARNING"), "{}", velvet.said());
}

#[test]
fn no_name_falls_on_the_file_of_another() {
    let mut velvet = Plan::new().start();
    upload(&mut velvet, "config.initial", &["; not the configuration"]);
    upload(&mut velvet, ONE, &["G1 X1"]);
    upload(&mut velvet, TWO, &["G1 X2"]);
    // The same name in another case is the same file.
    upload(&mut velvet, &TWO.to_uppercase(), &["G1 X3"]);
    assert_eq!(listed(&mut velvet), [ONE, TWO, "config.ini", "config.initial"]);
    let bytes = card(&mut velvet);
    assert_eq!(read(&bytes, "config.ini"), CONFIG);
    assert_eq!(read(&bytes, "config.initial"), "; not the configuration\n");
    assert_eq!(read(&bytes, ONE), "G1 X1\n");
    assert_eq!(read(&bytes, TWO), "G1 X3\n");
    velvet.type_in("rm config.inia");
    velvet.hear_until("Could not delete config.inia: no such file\n", SECOND);
    velvet.type_in("rm config.initial");
    velvet.hear_until("deleted config.initial\n", SECOND);
    assert_eq!(listed(&mut velvet), [ONE, TWO, "config.ini"]);
    // The next boot reads the files on the card.
    let bytes = card(&mut velvet);
    assert!(sd_image::read(&bytes, "config.initial").is_err());
    let mut next = Plan::new().with_card(move |_| bytes.clone()).start();
    next.type_in(&format!("cat {TWO}"));
    next.hear_until("G1 X3\n", SECOND);
}

#[test]
fn a_file_is_renamed_and_moved() {
    let mut velvet = Plan::new().file(ONE, "G1 X1\n").file(TWO, "G1 X2\n").start();
    for (line, answer) in [
        (
            format!("mv {ONE} {TWO}"),
            "Could not rename benchy_part_one.gcode to benchy_part_two.gcode: the name is already in use\n",
        ),
        ("mkdir finished_parts".into(), ""),
        (format!("mv {ONE} finished_parts/{ONE}"), ""),
        (format!("mv {TWO} a_name_that_is_longer_than_any_of_the_others.gcode"), ""),
    ] {
        velvet.type_in(&line);
        assert_eq!(velvet.hear(SECOND).replace("ok\n", ""), answer, "{line}");
    }
    assert_eq!(
        listed(&mut velvet),
        ["a_name_that_is_longer_than_any_of_the_others.gcode", "config.ini", "finished_parts/"]
    );
    let bytes = card(&mut velvet);
    assert_eq!(read(&bytes, &format!("finished_parts/{ONE}")), "G1 X1\n");
    assert_eq!(read(&bytes, "a_name_that_is_longer_than_any_of_the_others.gcode"), "G1 X2\n");
}

#[test]
fn saved_settings_have_their_long_name_and_the_previous_ones_stay() {
    let mut velvet = Plan::new().set("[general] config-override = true").start();
    velvet.ask("M92 X81", SECOND);
    assert_eq!(velvet.ask("M500", SECOND), "Settings Stored to /sd/config-override\nok\n");
    // On a fresh card other firmware finds both files, and no others (there was once a `CONFIG-O`).
    assert_eq!(sd_image::names(&card(&mut velvet)).expect("a sound volume"), ["config-override", "config.ini"]);
    velvet.ask("M92 X82", SECOND);
    assert_eq!(velvet.ask("M500", SECOND), "Settings Stored to /sd/config-override\nok\n");
    velvet.ask("M504 pla at 60 mm per second", SECOND);
    let bytes = card(&mut velvet);
    assert!(read(&bytes, "config-override").contains("M92 X82.0"));
    assert!(read(&bytes, "previous-config-override").contains("M92 X81.0"));
    assert!(read(&bytes, "config-override.pla at 60 mm per second").contains("M92 X82.0"));
    assert_eq!(
        listed(&mut velvet),
        ["config-override", "config-override.pla at 60 mm per second", "config.ini", "previous-config-override"]
    );
    // After a power cut between the last two steps of the replacement, the next boot carries out the last
    // step.
    let mut next = Plan::new()
        .set("[general] config-override = true")
        .file("new-config-override", &read(&bytes, "config-override"))
        .file("previous-config-override", &read(&bytes, "previous-config-override"))
        .start();
    let loaded = next.ask("M92", SECOND);
    assert!(loaded.contains("X:82.000000 "), "{loaded}");
    assert_eq!(listed(&mut next), ["config-override", "config.ini", "previous-config-override"]);
}
