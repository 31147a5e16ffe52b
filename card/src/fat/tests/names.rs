//! Tests of names: equality, allowed characters, slots and short names.

use std::string::String;
use std::vec::Vec;

use proptest::prelude::*;

use super::card::{Card, Format};
use super::operations::NOW;
use crate::fat::letter_case::capital;
use crate::fat::name::{Name, checksum};
use crate::fat::short_name::{Basis, plain, units};
use crate::fat::{Error, is_legal_name, same_name};

fn parsed(text: &str) -> Name {
    Name::parse(text).unwrap()
}

fn text(short: [u8; 11]) -> String {
    String::from_utf8(short.to_vec()).unwrap()
}

#[test]
fn case_blanks_around_and_periods_at_the_end_do_not_count() {
    for (one, other) in
        [("config.ini", "CONFIG.INI"), ("größe.G", "GRÖßE.g"), ("жук", "ЖУК"), (" a. . ", "A"), ("é", "É")]
    {
        assert!(same_name(one, other), "{one} {other}");
    }
    for (one, other) in
        [("ß", "SS"), ("ß", "ss"), ("ı", "I"), ("ſ", "S"), ("config.ini", "config.inia"), (".a", "a"), ("a b", "ab")]
    {
        assert!(!same_name(one, other), "{one} {other}");
    }
}

#[test]
fn what_a_name_may_have() {
    let longest = "n".repeat(255);
    for name in ["a", ".hidden", "a+b,c;d=e[f].g", "größe 🖨", "it's (1) & {2}", "con", &longest] {
        assert!(is_legal_name(name), "{name}");
    }
    let too_long = "n".repeat(256);
    for name in
        ["", ".", "..", " ", "a/b", "a\\b", "a:b", "a*", "a?", "\"a\"", "<a>", "a|b", "a\tb", "a\u{7F}", &too_long]
    {
        assert!(!is_legal_name(name), "{name:?}");
    }
    // A character beyond the basic plane has two units.
    assert!(is_legal_name(&"🖨".repeat(127)) && !is_legal_name(&"🖨".repeat(128)));
}

#[test]
fn which_names_are_their_own_short_name() {
    let of = |name: &str| plain(&parsed(name)).map(|(short, case)| (text(short), case));
    assert_eq!(of("CONFIG.INI"), Some(("CONFIG  INI".into(), Some(0))));
    assert_eq!(of("config.INI"), Some(("CONFIG  INI".into(), Some(0x08))));
    assert_eq!(of("CONFIG.ini"), Some(("CONFIG  INI".into(), Some(0x10))));
    assert_eq!(of("config.ini"), Some(("CONFIG  INI".into(), Some(0x18))));
    assert_eq!(of("Config.ini"), Some(("CONFIG  INI".into(), None)), "the case bits cannot say that");
    assert_eq!(of("1234"), Some(("1234       ".into(), Some(0))));
    for name in ["config.initial", "toolongname", "a b", ".a", "a.b.c", "é", "a+b"] {
        assert_eq!(of(name), None, "{name}");
    }
}

/// FAT 1.03, the example of "Organization and Association of Short & Long Directory Entries".
#[test]
fn the_quick_brown_fox() {
    let name = parsed("The quick brown.fox");
    let short = Basis::of(&name).with_tail(1);
    assert_eq!(text(short), "THEQUI~1FOX");
    let slots: Vec<_> = (0..name.slots()).map(|place| name.slot(place, checksum(&short))).collect();
    let expected: [[u8; 32]; 2] = [
        *b"Bw\0n\0.\0f\0o\0\x0F\0\x07x\0\0\0\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\0\0\xFF\xFF\xFF\xFF",
        *b"\x01T\0h\0e\0 \0q\0\x0F\0\x07u\0i\0c\0k\0 \0b\0\0\0r\0o\0",
    ];
    assert_eq!(slots, expected);
}

#[test]
fn what_short_names_begin_with() {
    let basis = |name: &str| text(Basis::of(&parsed(name)).with_tail(3));
    assert_eq!(basis("config-override"), "CONFIG~3   ");
    assert_eq!(basis("benchy_part_two.gcode"), "BENCHY~3GCO");
    assert_eq!(basis("a b.c d.e f"), "AB~3    EF ");
    assert_eq!(basis("..bashrc"), "BASHRC~3   ");
    assert_eq!(basis("größe.g"), "GR__E~3 G  ");
    assert_eq!(basis("x+y[1].g"), "X_Y_1_~3G  ");
    let name = parsed("benchy_part_two.gcode");
    let hashed: Vec<_> = (0..50).map(|round| Basis::of(&name).hashed(&name, round).with_tail(1)).collect();
    assert!(hashed.iter().all(|name| name.starts_with(b"BE") && name.ends_with(b"~1GCO")), "{hashed:?}");
    assert_eq!(hashed.iter().collect::<std::collections::BTreeSet<_>>().len(), 50);
}

#[test]
fn short_names_of_others_are_read() {
    let read = |name: &[u8; 11], case| String::from_utf16(&units(*name, case).collect::<Vec<_>>()).unwrap();
    assert_eq!(read(b"\x9ABUNG   GCO", 0), "ÜBUNG.GCO");
    assert_eq!(read(b"\x05RGER   TXT", 0), "σRGER.TXT");
    assert_eq!(read(b"EA DATA  SF", 0), "EA DATA. SF");
    assert_eq!(read(b"README     ", 0x18), "readme");
}

#[test]
fn colliding_names_are_different_files() {
    let mut card = Card::new(Format::FAT16);
    let mut volume = card.mount();
    let names =
        ["benchy_part_one.gcode", "benchy_part_two.gcode", "config.ini", "config.initial", "config.inia", "PRINTS"];
    let entries = names.map(|name| volume.create(&mut card, name, NOW).unwrap());
    let short_names = entries.each_ref().map(|entry| text(entry.short_name()));
    let expected = ["BENCHY~1GCO", "BENCHY~2GCO", "CONFIG  INI", "CONFIG~1INI", "CONFIG~2INI", "PRINTS~1   "];
    assert_eq!(short_names, expected, "PRINTS is the volume's label");
    for (name, entry) in names.iter().zip(&entries) {
        assert_eq!(volume.find(&mut card, name).unwrap().place(), entry.place(), "{name}");
        assert_eq!(volume.create(&mut card, &name.to_lowercase(), NOW).unwrap_err(), Error::Exists, "{name}");
    }
    // A short name is a name of its file, and of no other.
    assert_eq!(volume.create(&mut card, "config~2.ini", NOW).unwrap_err(), Error::Exists);
    assert_eq!(volume.find(&mut card, "config~2.ini").unwrap().place(), entries[4].place());
    volume.remove(&mut card, &entries[4]).unwrap();
    assert_eq!(text(volume.create(&mut card, "config~2.ini", NOW).unwrap().short_name()), "CONFIG~2INI");
    assert_eq!(text(volume.create(&mut card, "config.inib", NOW).unwrap().short_name()), "CONFIG~3INI");
}

proptest! {
    #[test]
    fn folding_twice_is_folding_once(unit: u16) {
        prop_assert_eq!(capital(capital(unit)), capital(unit));
    }

    #[test]
    fn a_name_is_found_whatever_it_is(name in "[ -.0-~äöüЖж🖨]{1,90}") {
        let mut card = Card::new(Format::FAT16);
        let mut volume = card.mount();
        match volume.create(&mut card, &name, NOW) {
            Ok(entry) => {
                prop_assert!(is_legal_name(&name));
                prop_assert_eq!(volume.find(&mut card, &name).unwrap().place(), entry.place());
                prop_assert_eq!(volume.find(&mut card, &name.to_lowercase()).unwrap().place(), entry.place());
                let mut listed = Name::new();
                volume.list(&mut card, "").unwrap().next(&mut volume, &mut card, &mut listed).unwrap();
                let listed: String = listed.chars().collect();
                prop_assert_eq!(&listed, name.trim_start_matches(' ').trim_end_matches([' ', '.']));
            }
            Err(error) => {
                prop_assert_eq!(error, Error::BadName);
                prop_assert!(!is_legal_name(&name));
            }
        }
    }
}
