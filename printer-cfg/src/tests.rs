//! A configuration on a card, read as Klipper reads it.

use std::string::String;
use std::vec::Vec;

use base::sessions::Recipient;

use crate::test_card::Card;
use crate::{Scratch, Section, Store, Use, read_saved, save, saved_name};

const MAIN: &str = "\
# a comment
[include macros/*.cfg]
[printer]
kinematics: cartesian   ; of three axes
max_accel = 3000 # steady
[gcode_macro PRINT_START]
description: Before a print
variable_bed: 60
gcode:
    M117 Hello # not this
    ; nor this

    G28 ;behind a blank
    G1 X{ 1;2 }
rename_existing: OTHER_START
[delayed_gcode later]
initial_duration: 2.5
gcode:
  M117 late

#*# <---------------------- SAVE_CONFIG ---------------------->
#*# DO NOT EDIT THIS BLOCK OR BELOW. The contents are auto-generated.
#*#
#*# [extruder]
#*# pid_kp = 22.2
#*# [printer]
#*# max_accel = 5000
";

fn card() -> Card {
    Card::with(&[
        ("/sd/printer.cfg", MAIN),
        ("/sd/macros/b.cfg", "[gcode_macro B]\ngcode: M117 b\n"),
        ("/sd/macros/a.cfg", "[gcode_macro M109]\nrename_existing: M109.1\ngcode: M109.1 {rawparams}\n"),
        ("/sd/macros/no.txt", "[gcode_macro NO]\ngcode: M112\n"),
    ])
}

fn loaded(card: &mut Card) -> Store {
    let mut store = Store::new();
    let loaded = store.reload(card, "/sd/printer.cfg", 1_000_000);
    assert_eq!((loaded.sections, loaded.macros, loaded.trouble), (7, 3, None));
    assert_eq!(loaded.codes, [false, true]);
    store
}

fn option(store: &Store, card: &mut Card, section: Section, key: &str) -> Option<String> {
    let read = store.read((section, key), card, |text| text.collect::<Vec<u8>>()).unwrap();
    read.map(|bytes| String::from_utf8(bytes).unwrap())
}

#[test]
fn values_are_what_klipper_reads() {
    let mut card = card();
    let store = loaded(&mut card);
    let printer = store.section("printer").unwrap();
    assert_eq!(option(&store, &mut card, printer, "kinematics").as_deref(), Some("cartesian"));
    assert_eq!(option(&store, &mut card, printer, "max_accel").as_deref(), Some("5000"), "the saved block wins");
    assert_eq!(option(&store, &mut card, printer, "max_velocity"), None);
    let start = store.named("gcode_macro", "print_start").unwrap();
    let text = "\nM117 Hello\n\nG28\nG1 X{ 1;2 }";
    assert_eq!(option(&store, &mut card, start, "gcode").as_deref(), Some(text));
    assert_eq!(option(&store, &mut card, start, "description").as_deref(), Some("Before a print"));
    assert!(store.has(start, Use::Variables) && store.has(start, Use::Macro));
    assert_eq!(store.name(start, &mut card).unwrap(), "PRINT_START");
    assert_eq!(store.renamed("other_start"), Some(start));
    assert_eq!(store.line_of(start, "gcode", 4, &mut card), ("/sd/printer.cfg", 13, 4));
    assert_eq!(card.left_open(), 0);
}

#[test]
fn what_is_included_stands_at_its_place_in_the_order_of_names() {
    let mut card = card();
    let store = loaded(&mut card);
    let [m109, b] = ["M109", "B"].map(|name| store.named("gcode_macro", name).unwrap());
    assert_eq!((m109, b), (Section(0), Section(1)));
    assert_eq!(store.renamed("M109.1"), Some(m109));
    assert_eq!(store.named("gcode_macro", "NO"), None);
    let lost = Card::with(&[("/sd/printer.cfg", "[include no.cfg]\n[gcode_macro A]\ngcode: G28\n")]);
    let loaded = Store::new().reload(&mut { lost }, "/sd/printer.cfg", 0);
    assert_eq!(loaded.macros, 1, "the rest is read");
    assert!(loaded.trouble.unwrap().to_string().contains("includes"));
}

#[test]
fn a_file_that_includes_itself_ends() {
    let mut card = Card::with(&[("/sd/printer.cfg", "[include *.cfg]\n[gcode_macro A]\ngcode: G28\n")]);
    assert_eq!(Store::new().reload(&mut card, "/sd/printer.cfg", 0).macros, 1);
}

#[test]
fn a_changed_file_is_seen() {
    let mut card = card();
    let store = loaded(&mut card);
    let start = store.named("gcode_macro", "PRINT_START").unwrap();
    card.files.insert("/sd/printer.cfg".into(), std::format!("[new]\n{MAIN}").into_bytes());
    let trouble = store.read((start, "gcode"), &mut card, |_| ()).unwrap_err();
    assert_eq!(store.path_of(&trouble), "/sd/printer.cfg");
    assert!(trouble.to_string().contains("macros reload"));
}

#[test]
fn delayed_code_is_due_after_its_time() {
    let mut card = card();
    let mut store = loaded(&mut card);
    assert!(!store.is_due(3_400_000) && store.is_due(3_500_000));
    assert_eq!(store.take_due(3_500_000), store.named("delayed_gcode", "later"));
    store.call(Section(0), 1, Recipient::All, false);
    assert!(store.is_called(Section(0)) && store.may_call());
}

#[test]
fn saved_variables_are_klippers_file() {
    let mut card = Card::with(&[("/sd/v.cfg", "[Variables]\nb = 'x # y'\nd = [1, 2]")]);
    let mut line = Scratch::new();
    for (name, value) in [("c", "2.5"), ("a", "None"), ("d", "{'k': 1}"), ("e", "True")] {
        save(&mut card, "/sd/v.cfg", (name, value), &mut line).unwrap();
    }
    let all = "[Variables]\na = None\nb = 'x # y'\nc = 2.5\nd = {'k': 1}\ne = True\n\n";
    assert_eq!(card.text("/sd/v.cfg"), all);
    assert!(read_saved(&mut card, "/sd/v.cfg", "b", &mut line).unwrap());
    assert_eq!(line.text(), Some("'x # y'"));
    assert!(!read_saved(&mut card, "/sd/v.cfg", "z", &mut line).unwrap());
    assert!(saved_name(&mut card, "/sd/v.cfg", 4, &mut line).unwrap());
    assert_eq!(line.text(), Some("e"));
    assert!(!saved_name(&mut card, "/sd/v.cfg", 5, &mut line).unwrap());
    save(&mut card, "/sd/new.cfg", ("a", "1"), &mut line).unwrap();
    assert_eq!(card.text("/sd/new.cfg"), "[Variables]\na = 1\n\n");
    assert_eq!(card.left_open(), 0);
}

#[test]
fn memory_is_as_much_as_the_board_lends() {
    let store = size_of::<Store>();
    assert!(store <= 3600, "{store} bytes behind ITCM, beside the lines");
    let others = size_of::<Scratch>() + size_of::<crate::Variables>();
    assert!(others <= 3200, "{others} bytes in SRAM1, beside code and values");
}
