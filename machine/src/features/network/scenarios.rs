//! The network as consoles see it: its news, its state, its password, who may do what over it.

use std::net::Ipv4Addr;

use base::ports::{AddressOrigin, KeysRecord, NetworkAddress, NetworkLink, NetworkNews};
use base::sessions::{ConsoleKind, Rights, SessionId, SessionProfile};
use scenarios::{Bench, CARTESIAN, Plan};

const NETWORK: &str = "\n[network]\nenable = true\nshell_enable = true\nhostname = lab-printer\n";
/// A console over the network.
const FAR: SessionId = SessionId(2);

const ADDRESS: NetworkAddress = NetworkAddress {
    address: Ipv4Addr::new(192, 168, 7, 45),
    mask_bits: 20,
    gateway: Some(Ipv4Addr::new(192, 168, 0, 1)),
    dns: Some(Ipv4Addr::new(9, 9, 9, 9)),
    origin: AddressOrigin::Dhcp,
};

fn with_network() -> Plan {
    Plan::new(CARTESIAN).adding(NETWORK)
}

/// Connects a console over the network with these rights, which the test types on.
fn visited(rights: Rights) -> Bench {
    let profile = SessionProfile { kind: ConsoleKind::Network, rights, dialect: None, greeting: "hello\n" };
    let mut bench = with_network().visitor(profile).start();
    bench.set_open(FAR, true);
    assert_eq!(bench.hear_on(FAR, 0.1), "hello\n");
    bench
}

fn ask_far(bench: &mut Bench, line: &str) -> String {
    bench.type_on(FAR, &format!("{line}\n"));
    bench.hear_on(FAR, 0.5)
}

#[test]
fn a_machine_without_a_network_says_so() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("net"), "No network: [network] enable is off\nok\n");
    assert!(bench.say("password correct-horse").contains("there is no network"));
}

#[test]
fn an_address_is_told_on_every_console_and_asked_for_by_net() {
    let mut bench = visited(Rights::Own);
    let said = bench.say("net");
    assert!(said.starts_with("Link DOWN\nMAC Address: 02:00:00:00:00:01\nName: lab-printer.local\n"), "{said}");
    assert!(said.contains("Telnet: port 23, 0 connected\nPassword: none"), "{said}");
    bench.network(|network| {
        if let Some(report) = &mut network.report {
            report.link = Some(NetworkLink { mbit: 100, is_full_duplex: true });
            report.address = Some(ADDRESS);
            report.traffic.damaged = 3;
        }
        network.news.push_back(NetworkNews::Address(ADDRESS));
    });
    let told = "// network: 192.168.7.45 (from DHCP), lab-printer.local\n";
    assert_eq!((bench.hear(0.1).as_str(), bench.hear_on(FAR, 0.1).as_str()), (told, told));
    let said = ask_far(&mut bench, "net");
    assert!(said.contains("Link: 100 Mbit/s, full duplex\nIP Address: 192.168.7.45 (from DHCP)\n"), "{said}");
    assert!(said.contains("Subnet Mask: 255.255.240.0\nGateway Address: 192.168.0.1\n"), "{said}");
    assert!(said.contains("DNS Server Address: 9.9.9.9\n") && said.contains("Damaged frames: 3"), "{said}");
    for (news, words) in [
        (NetworkNews::NoAddress, "no address any more"),
        (NetworkNews::AddressTaken(Ipv4Addr::new(10, 0, 0, 5)), "another machine has the address 10.0.0.5"),
        (NetworkNews::Renamed("lab-printer-2".try_into().expect("short")), "this one is lab-printer-2.local now"),
    ] {
        bench.network(|network| network.news.push_back(news));
        assert!(bench.hear(0.1).contains(words), "{words}");
    }
}

#[test]
fn the_networks_time_sets_the_clock_in_its_zone() {
    for (zone, hour) in [("0", "12:00"), ("5.5", "17:30"), ("-3", "09:00")] {
        let mut bench = with_network().set(&format!("[network] timezone = {zone}")).start();
        // 2026-11-29 12:00:00.
        bench.network(|network| network.news.push_back(NetworkNews::Time(1_795_953_600)));
        bench.hear(0.1);
        let date = bench.say("date");
        assert!(date.starts_with(&format!("2026-11-29 {hour}")), "{zone}: {date}");
    }
}

#[test]
fn a_password_is_kept_on_the_card_and_shown_to_nobody() {
    let mut bench = with_network().start();
    for (line, why) in [
        ("password", "write password and a word"),
        ("password short", "8 to 63"),
        ("password naive\u{e9}naive", "8 to 63"),
    ] {
        assert!(bench.say(line).contains(why), "{line}");
    }
    assert!(bench.say("password correct-horse").contains("ask for this password from now on\nok\n"));
    assert_eq!(bench.network(|network| network.password.clone()).as_deref(), Some(&b"correct-horse"[..]));
    assert!(bench.say("net").contains("Password: set\n"));
    for line in ["cat netpass", "cat /sd/NETPASS", "cat \"netpass\""] {
        let said = bench.say(line);
        assert!(!said.contains("horse") && said.contains("not shown"), "{line}: {said}");
    }
    bench.say("password battery-staple");
    assert!(!bench.say("ls").contains("previous-netpass"), "the former record stays on the card");
    assert!(bench.say("password off").ends_with("ok\n"));
    assert_eq!(bench.network(|network| network.password.clone()), None);
    assert!(!bench.say("ls").contains("netpass"));
}

/// Every way to have a file read leads past the same check.
#[test]
fn secrets_of_the_card_are_shown_to_nobody() {
    let mut bench = with_network().file("netpass", "plain$from-before\n").file("netkeys", "Own 77 horse\n").start();
    for secret in ["netpass", "NETPASS.", "/sd/netkeys", "\"netkeys\""] {
        for line in ["cat", "play", "M32", "M23", "cp", "md5sum", "ed", "mv", "preflight"] {
            let target = if matches!(line, "cp" | "ed" | "mv") { " shown.g" } else { "" };
            let echo = if line == "play" { " -v" } else { "" };
            let said = bench.say(&format!("{line} {secret}{target}{echo}"));
            assert!(!said.contains("plain$") && !said.contains("horse"), "{line} {secret}: {said}");
            assert!(line != "cat" || said.contains("not shown"), "{line} {secret}: {said}");
        }
    }
    assert!(!bench.say("ls").contains("shown.g"));
    assert_eq!(bench.network(|network| network.keys.clone()).as_deref(), Some(&b"Own 77 horse\n"[..]));
}

#[test]
fn a_code_is_shown_to_who_stands_at_the_machine_alone() {
    let mut bench = visited(Rights::Own);
    bench.network(|network| network.news.push_back(NetworkNews::Code(42, Ipv4Addr::new(10, 0, 0, 66))));
    let said = bench.hear(0.1);
    assert!(said.contains("code 000042 sets the password that was chosen on the page at 10.0.0.66"), "{said}");
    assert_eq!(bench.hear_on(FAR, 0.1), "", "not over the network");
}

#[test]
fn a_password_set_on_the_page_is_kept_and_its_visitor_told() {
    let mut bench = with_network().start();
    bench.network(|network| {
        assert!(network.begin("battery-staple"));
        network.news.push_back(NetworkNews::NewPassword);
    });
    bench.hear(0.1);
    assert_eq!(bench.network(|network| network.kept.clone()), [Ok(())]);
    assert_eq!(bench.network(|network| network.password.clone()).as_deref(), Some(&b"battery-staple"[..]));
    assert!(bench.say("ls").contains("netpass"));
}

#[test]
fn keys_of_visitors_are_kept_and_the_last_one_takes_the_file_with_it() {
    let mut bench = with_network().start();
    for (record, is_there) in [("Watch 77 desk\n", true), ("", false)] {
        bench.network(|network| {
            network.changed_keys = KeysRecord::from_slice(record.as_bytes()).ok();
            network.news.push_back(NetworkNews::NewKeys);
        });
        bench.hear(0.1);
        assert_eq!(bench.say("ls").contains("netkeys"), is_there, "{record}");
    }
    assert_eq!(bench.network(|network| network.kept.clone()), [Ok(()), Ok(())]);
    assert!(!bench.say("ls").contains("previous-"), "revoked keys do not stay on the card");
}

#[test]
fn the_password_on_the_card_is_in_force_after_a_start() {
    let mut bench = with_network().file("netpass", "plain$from-before\n").start();
    assert_eq!(bench.network(|network| network.password.clone()).as_deref(), Some(&b"from-before"[..]));
    assert!(bench.say("net").contains("Password: set\n"));
    let mut bench = with_network().file("netpass", "rubbish").start();
    assert_eq!(bench.network(|network| network.password.clone()), None);
    assert!(bench.say("net").contains("Password: none"));
}

/// Whoever comes without the password has the machine work, and changes nothing that stays.
#[test]
fn who_only_operates_changes_neither_files_nor_settings_nor_firmware() {
    let mut bench = visited(Rights::Operate);
    for line in [
        "rm a.g",
        "mv a.g b.g",
        "mkdir x",
        "upload a.g",
        "dl a.g 5",
        "ry",
        "config-set general grbl_mode true",
        "flash",
        "dfu",
        "reset",
        "msc",
        "password correct-horse",
        "M28 a.g",
        "M30 a.g",
        "M500",
        "M502",
    ] {
        let said = ask_far(&mut bench, line);
        assert!(said.contains("this is for who has the machine's password"), "{line}: {said}");
    }
    assert!(ask_far(&mut bench, "G28.3 X0 Y0 Z0").ends_with("ok\n"));
    assert!(ask_far(&mut bench, "G1 X5 F3000").ends_with("ok\n"));
    assert!(ask_far(&mut bench, "M104 S50").ends_with("ok\n"));
    assert!(ask_far(&mut bench, "ls").ends_with("ok\n"));
}

#[test]
fn the_owner_changes_them_over_the_network_as_well() {
    let mut bench = visited(Rights::Own);
    assert!(ask_far(&mut bench, "mkdir x").ends_with("ok\n"));
    assert!(ask_far(&mut bench, "M500").ends_with("ok\n"));
    assert!(ask_far(&mut bench, "password correct-horse").ends_with("ok\n"));
}

#[test]
fn a_file_may_do_what_its_starter_may() {
    let save = "M500\nG4 P1\n";
    let profile = SessionProfile { kind: ConsoleKind::Network, rights: Rights::Operate, dialect: None, greeting: "" };
    let start = || {
        let mut bench = with_network().file("save.g", save).file("idle.g", "G4 S2\nM500\n").visitor(profile).start();
        bench.set_open(FAR, true);
        bench
    };
    for begins in ["play /sd/save.g -v", "M32 save.g", "M23 save.g\nM24", "queue add /sd/save.g\nqueue next"] {
        let mut bench = start();
        bench.type_on(FAR, &format!("{begins}\n"));
        let said = bench.hear(3.0);
        assert!(said.contains("this is for who has the machine's password"), "{begins}: {said}");
        assert_eq!(bench.read_card("config-override"), None, "{begins}");
        bench.say("abort");
        // The owner's own start of the same file counts, and so does a selection that somebody else made.
        ask_far(&mut bench, "M23 save.g");
        bench.say("M24");
        bench.hear(3.0);
        assert!(bench.read_card("config-override").is_some(), "{begins}");
    }
    // Going on with a job, and adding to it, gives it no more rights.
    let mut bench = start();
    ask_far(&mut bench, "play /sd/idle.g");
    ask_far(&mut bench, "M25");
    bench.say("M24");
    assert!(bench.hear(4.0).contains("this is for who has"));
    let mut bench = start();
    bench.say("play /sd/idle.g");
    ask_far(&mut bench, "pause at line 2 M30 idle.g");
    assert!(bench.hear(4.0).contains("this is for who has"));
    assert!(bench.read_card("idle.g").is_some());
}

#[test]
fn settings_of_grbl_are_the_owners_too() {
    let mut bench = with_network()
        .set("[general] grbl_mode = true")
        .visitor(SessionProfile { kind: ConsoleKind::Network, rights: Rights::Operate, dialect: None, greeting: "" })
        .start();
    bench.set_open(FAR, true);
    bench.hear_on(FAR, 0.1);
    for line in ["$10=3", "$110=5000", "$N0=G21", "$RST=$", "$I=mine"] {
        let said = ask_far(&mut bench, line);
        assert!(said.contains("error:"), "{line}: {said}");
    }
    assert!(ask_far(&mut bench, "$J=G91 X1 F500").ends_with("ok\n"));
    let options = ask_far(&mut bench, "$I");
    assert!(options.contains(",1023]"), "what may be sent ahead over the network: {options}");
    assert!(bench.say("$I").contains(",4095]"));
}
