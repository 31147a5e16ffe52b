//! Boards in the network as a person uses them: found, talked to, sent jobs. The board is a part of the test.

#[path = "network/desk.rs"]
mod desk;

use desk::{Announcer, errors, out, velvet};

#[test]
fn boards_are_listed_and_other_machines_counted() {
    let announcer = Announcer::new();
    announcer.announce("velvet", 23, &[("firmware", "velvet"), ("grbl", "2323")]);
    announcer.announce("mill", 2_300, &[("firmware", "velvet"), ("version", "1.2.3")]);
    announcer.announce("router", 23, &[("firmware", "others")]);
    let listed = velvet(&["boards", "--mdns-port", announcer.port()], "");
    assert_eq!(
        out(&listed),
        "mill.local    127.0.0.1        telnet 2300, version 1.2.3\n\
         velvet.local  127.0.0.1        telnet 23, GRBL's dialect 2323\n"
    );
    assert_eq!(errors(&listed), "1 other machine offers telnet and is not Velvet's\n");
    assert_eq!(listed.status.code(), Some(0));
    let listed = velvet(&["boards", "--json", "--mdns-port", announcer.port()], "");
    let boards: serde_json::Value = serde_json::from_str(&out(&listed)).expect("JSON");
    assert_eq!(
        boards[1],
        serde_json::json!({
            "name": "velvet.local", "address": "127.0.0.1", "telnet": 23, "grbl": 2323, "firmware": "velvet", "version": null
        })
    );
}

#[test]
fn a_network_without_boards_is_said_with_what_to_look_at() {
    let announcer = Announcer::new();
    let listed = velvet(&["boards", "--seconds", "1", "--mdns-port", announcer.port()], "");
    assert_eq!((listed.status.code(), out(&listed).as_str()), (Some(1), ""));
    for word in ["within 1 s", "same network", "[network] enable = true", "shell_enable", "firewall", "`net`"] {
        assert!(errors(&listed).contains(word), "{word}: {}", errors(&listed));
    }
    let listed = velvet(&["boards", "--json", "--seconds", "1", "--mdns-port", announcer.port()], "");
    assert_eq!((listed.status.code(), out(&listed).as_str()), (Some(1), "[]\n"));
    assert_eq!(velvet(&["boards", "--seconds", "0"], "").status.code(), Some(2));
}
