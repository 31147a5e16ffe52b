//! The site against a browser of bytes.

mod access;

use std::net::Ipv4Addr;

use base::bench::Card;
use base::ports::Factors;
use base::ports::Storage as _;
use base::sessions::{DONE, REFUSED};
use base::snapshot::{HeaterShown, JobShown, Snapshot};
use http::{Life, Role};
use program::State;
use units::Celsius;

use crate::{CLIENTS, Memory, PERIOD_MS, Site};

mod batch;
mod console;
mod stores;

const PLACES: usize = 6;
const BUFFER: usize = 2_048;
/// Address of every visitor.
const FROM: Ipv4Addr = Ipv4Addr::new(10, 0, 0, 7);

struct Desk {
    site: Site<PLACES>,
    card: Card,
    now: u64,
    /// Room that a call of `transmit` has.
    room: usize,
    /// Macros of the machine, and what they say of themselves.
    macros: Vec<(&'static str, &'static str)>,
}

impl Desk {
    fn new(role: Role) -> Self {
        let mut site = Site::new("1.2.3", role, Box::leak(Box::new(Memory::new())));
        site.set_host("velvet");
        let mut desk = Self { site, card: Card::default(), now: 1_000, room: 1_460, macros: Vec::new() };
        desk.site.show(&snapshot(), desk.now);
        desk
    }

    fn open(&mut self, place: usize) {
        self.site.open(place, FROM, BUFFER, self.now);
    }

    /// Sends bytes, and returns all that comes back at once.
    fn send(&mut self, place: usize, bytes: &[u8]) -> Vec<u8> {
        let mut waiting = bytes.to_vec();
        let mut heard = Vec::new();
        loop {
            let used = self.site.receive(place, &mut waiting, self.now, &mut self.card);
            waiting.drain(..used);
            let before = heard.len();
            for _ in 0..20 {
                self.site.run(self.now, &mut self.card);
            }
            heard.extend(self.hear(place));
            if used == 0 && heard.len() == before {
                return heard;
            }
        }
    }

    /// Returns what comes of itself.
    fn hear(&mut self, place: usize) -> Vec<u8> {
        let mut heard = Vec::new();
        loop {
            let mut room = vec![0; self.room];
            let count = self.site.transmit(place, &mut room, self.now, &mut self.card);
            heard.extend(&room[..count]);
            if count == 0 && self.site.wants_macro().is_none() {
                return heard;
            }
            while let Some(number) = self.site.wants_macro().filter(|_| count == 0) {
                self.site.show_macro(number, self.macros.get(usize::from(number)).copied());
            }
        }
    }

    /// Gets an answer whose body comes in chunks. Returns the body.
    fn get_whole(&mut self, place: usize, path: &str) -> String {
        let answer = self.get(place, path);
        let (_, body) = answer.split_once("\r\n\r\n").expect("a body");
        String::from_utf8(files::chunks(body.as_bytes())).unwrap()
    }

    fn get(&mut self, place: usize, path: &str) -> String {
        let request = format!("GET {path} HTTP/1.1\r\nHost: velvet.local\r\n\r\n");
        String::from_utf8_lossy(&self.send(place, request.as_bytes())).into_owned()
    }

    /// Opens a WebSocket. Returns the answer to its handshake.
    fn upgrade(&mut self, place: usize) -> String {
        self.open(place);
        let request = "GET /websocket HTTP/1.1\r\nHost: velvet.local\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
                       Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
        String::from_utf8_lossy(&self.send(place, request.as_bytes())).into_owned()
    }

    /// Sends a message, and returns all messages that come back at once.
    fn call(&mut self, place: usize, message: &str) -> Vec<String> {
        let heard = self.send(place, &frame(message));
        messages(&heard)
    }

    /// Returns the next line for the machine.
    fn next_line(&mut self) -> Option<String> {
        self.site.next_line(self.now).map(|(line, _)| line.as_str().to_owned())
    }

    /// Has the machine say something, all of which is heard.
    fn say(&mut self, bytes: &[u8]) {
        assert_eq!(self.site.hear(bytes, self.now), bytes.len());
    }

    /// Shows a state, a period later. Returns the messages that come of it.
    fn show(&mut self, place: usize, snapshot: &Snapshot) -> Vec<String> {
        self.now += PERIOD_MS;
        self.site.show(snapshot, self.now);
        let heard = self.hear(place);
        messages(&heard)
    }
}

/// Makes a client's frame of a text, with a mask.
fn frame(text: &str) -> Vec<u8> {
    let mask = [1, 2, 3, 4];
    let mut frame = vec![0x81];
    match text.len() {
        length @ 0..126 => frame.push(0x80 | length as u8),
        length => {
            frame.push(0x80 | 126);
            frame.extend((length as u16).to_be_bytes());
        }
    }
    frame.extend(mask);
    frame.extend(text.bytes().enumerate().map(|(place, byte)| byte ^ mask[place % 4]));
    frame
}

/// Puts a server's frames of text together to messages.
fn messages(bytes: &[u8]) -> Vec<String> {
    let (mut rest, mut all, mut text) = (bytes, Vec::new(), Vec::new());
    while !rest.is_empty() {
        let (first, short) = (rest[0], usize::from(rest[1]));
        let (length, head) =
            if short == 126 { (usize::from(rest[2]) << 8 | usize::from(rest[3]), 4) } else { (short, 2) };
        text.extend(&rest[head..head + length]);
        if first & 0x80 != 0 {
            all.push(String::from_utf8(std::mem::take(&mut text)).unwrap());
        }
        rest = &rest[head + length..];
    }
    all
}

fn snapshot() -> Snapshot {
    let mut snapshot = Snapshot::default();
    for (name, designator) in [("hotend", "T"), ("bed", "B"), ("chamber", "C")] {
        let heater = HeaterShown {
            name: name.try_into().unwrap(),
            designator: designator.try_into().unwrap(),
            reading: Some(Celsius(21.5)),
            max: Celsius(300.0),
            heats: true,
            ..HeaterShown::default()
        };
        snapshot.heaters.push(heater).unwrap();
    }
    snapshot
}

mod files;
mod resuming;

#[test]
fn the_page_is_served_and_kept_by_browsers() {
    let mut desk = Desk::new(Role::Nobody);
    desk.open(0);
    let index = desk.get(0, "/");
    assert!(index.starts_with("HTTP/1.1 200 OK\r\n") && index.contains("Content-Encoding: gzip\r\n"), "{index}");
    assert!(index.contains("Cache-Control: no-cache\r\n") && index.contains("Content-Security-Policy:"), "{index}");
    let tag = index.split("ETag: ").nth(1).unwrap().split("\r\n").next().unwrap();
    let again = format!("GET / HTTP/1.1\r\nHost: velvet.local\r\nIf-None-Match: {tag}\r\n\r\n");
    let again = String::from_utf8_lossy(&desk.send(0, again.as_bytes())).into_owned();
    assert!(again.starts_with("HTTP/1.1 304 ") && again.ends_with("\r\n\r\n"), "{again}");
    assert!(desk.get(0, "/none").starts_with("HTTP/1.1 404 "));
}

#[test]
fn who_has_no_password_gets_the_page_alone() {
    let mut desk = Desk::new(Role::Nobody);
    desk.open(0);
    for path in ["/printer/info", "/server/info", "/printer/objects/list", "/printer/objects/query?toolhead"] {
        assert!(desk.get(0, path).starts_with("HTTP/1.1 401 "), "{path}");
    }
    desk.upgrade(1);
    for method in ["printer.info", "printer.objects.subscribe", "printer.emergency_stop"] {
        let answer =
            desk.call(1, &format!(r#"{{"method":"{method}","params":{{"objects":{{"velvet":null}}}},"id":1}}"#));
        assert!(answer[0].contains(r#""error":{"code":401"#), "{method}: {answer:?}");
    }
    desk.say(b"// a secret of the shop\n");
    let told: Vec<String> = (0..8).flat_map(|_| desk.show(1, &snapshot())).collect();
    assert!(told.iter().all(|told| told.contains("notify_proc_stat_update")), "the board is there, no more: {told:?}");
}

#[test]
fn requests_for_other_hosts_are_refused() {
    let mut desk = Desk::new(Role::Own);
    desk.open(0);
    let foreign = desk.send(0, b"GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    assert!(foreign.starts_with(b"HTTP/1.1 421 "));
    desk.open(1);
    let page = b"GET /printer/info HTTP/1.1\r\nHost: velvet.local\r\nOrigin: http://evil.example\r\n\r\n";
    assert!(desk.send(1, page).starts_with(b"HTTP/1.1 403 "));
    desk.open(2);
    assert!(desk.send(2, b"DELETE / HTTP/1.1\r\nHost: velvet.local\r\n\r\n").starts_with(b"HTTP/1.1 405 "));
}

#[test]
fn objects_are_told_over_http() {
    let mut desk = Desk::new(Role::Watch);
    desk.open(0);
    let list = desk.get(0, "/printer/objects/list");
    assert!(
        list.contains(r#""toolhead","gcode_move""#)
            && list.contains(r#""extruder","heater_bed","heater_generic chamber""#)
    );
    let answer = desk.get(0, "/printer/objects/query?extruder&heater_generic%20chamber=target&none");
    let extruder = r#""extruder":{"temperature":21.5,"target":0,"power":0,"max_temp":300}"#;
    assert!(
        answer.contains(extruder) && answer.contains("heater_generic chamber") && !answer.contains("toolhead"),
        "{answer}"
    );
}

#[test]
fn macros_are_objects_and_have_their_help() {
    let mut desk = Desk::new(Role::Watch);
    desk.macros =
        vec![("Load", "Loads \"it\""), ("_inner", ""), ("G28", "homes otherwise"), ("D", ""), ("E", ""), ("F", "")];
    desk.open(0);
    for room in [1_000, 1_460, 20_000] {
        desk.room = room;
        let list = desk.get_whole(0, "/printer/objects/list");
        let names = ["Load", "_inner", "G28", "D", "E", "F"].map(|name| format!(r#""gcode_macro {name}""#)).join(",");
        assert!(list.contains(r#""velvet","#) && list.ends_with(&format!("{names}]}}}}")), "{list}");
    }
    desk.upgrade(1);
    let help = desk.call(1, r#"{"method":"printer.gcode.help","id":1}"#);
    let macros = r#","LOAD":"Loads \"it\"","_INNER":"macro","D":"macro","E":"macro","F":"macro"},"id":1}"#;
    assert!(help.len() == 1 && help[0].ends_with(macros) && help[0].matches(r#""G28":"#).count() == 1, "{help:?}");
    // Read anew: the list has another number, and other macros.
    let ask = r#"{"method":"printer.objects.subscribe","params":{"objects":{"velvet":null}},"id":2}"#;
    assert!(desk.call(1, ask)[0].contains(r#""macros":0}"#));
    desk.macros = vec![("NEW", "")];
    let told = desk.show(1, &Snapshot { macros: 1, ..snapshot() });
    assert!(told[0].contains(r#""macros":1}"#), "{told:?}");
    assert!(
        desk.get_whole(0, "/printer/objects/list")
            .ends_with(r#","velvet","extruder","heater_bed","heater_generic chamber","gcode_macro NEW"]}}"#)
    );
}

#[test]
fn a_list_of_macros_waits_for_the_machine_and_for_nobody_who_has_gone() {
    let mut desk = Desk::new(Role::Watch);
    desk.macros = vec![("A", "")];
    desk.open(0);
    let mut request = b"GET /printer/objects/list HTTP/1.1\r\nHost: velvet.local\r\n\r\n".to_vec();
    desk.site.receive(0, &mut request, desk.now, &mut desk.card);
    let mut room = vec![0; 1_460];
    let begun = desk.site.transmit(0, &mut room, desk.now, &mut desk.card);
    assert!(begun > 0 && desk.site.transmit(0, &mut room, desk.now, &mut desk.card) == 0, "the machine has its time");
    assert_eq!(desk.site.wants_macro(), Some(0));
    let rest = String::from_utf8_lossy(&desk.hear(0)).into_owned();
    assert!(rest.contains(r#","gcode_macro A"]}}"#), "{rest}");
    assert_eq!(desk.site.wants_macro(), None);
}

#[test]
fn a_subscriber_is_told_of_what_changes_and_of_nothing_else() {
    let mut desk = Desk::new(Role::Watch);
    assert!(desk.upgrade(0).starts_with("HTTP/1.1 101 "));
    let call = r#"{"jsonrpc":"2.0","method":"printer.objects.subscribe","params":{"objects":{"extruder":null,"print_stats":["state"]}},"id":7}"#;
    let answer = desk.call(0, call);
    assert_eq!(answer.len(), 1);
    assert!(
        answer[0].contains(r#""status":{"print_stats":{"state":"standby""#) && answer[0].ends_with(r#","id":7}"#),
        "{answer:?}"
    );
    let mut state = snapshot();
    assert_eq!(desk.show(0, &state), Vec::<String>::new());
    state.heaters[0].target = Celsius(200.0);
    state.heaters[1].target = Celsius(60.0);
    let told = desk.show(0, &state);
    let update = r#"{"jsonrpc":"2.0","method":"notify_status_update","params":[{"extruder":{"temperature":21.5,"target":200,"power":0,"max_temp":300}},1.5]}"#;
    assert_eq!(told, [update], "of the bed nobody wanted to hear");
    state.job = Some(JobShown { path: "/sd/part.g".try_into().unwrap(), size: 200, done: 50, ..JobShown::default() });
    let told = desk.show(0, &state);
    assert!(told.len() == 1 && told[0].contains(r#""state":"printing","message":"","filename":"part.g""#), "{told:?}");
}

#[test]
fn what_is_no_call_is_an_error() {
    let mut desk = Desk::new(Role::Own);
    desk.upgrade(0);
    let long =
        format!(r#"{{"method":"printer.gcode.script","params":{{"script":"{}"}},"id":1}}"#, "G1 X1 ".repeat(200));
    for (message, code) in [
        ("nonsense", -32_700),
        (r#"{"method":"printer.info","id":1"#, -32_700),
        (r#"{"id":1}"#, -32_600),
        ("[]", -32_600),
        ("[", -32_700),
        (r#"[7]"#, -32_600),
        (r#"{"method":"no.such","id":1}"#, -32_601),
        (r#"{"method":"printer.gcode.script","id":1}"#, -32_602),
        (r#"{"method":"printer.gcode.script","params":{"script":"G1\u0018"},"id":1}"#, -32_602),
        (long.as_str(), -32_600),
    ] {
        let answer = desk.call(0, message);
        assert!(answer.len() == 1 && answer[0].contains(&format!(r#""code":{code}"#)), "{message}: {answer:?}");
    }
    assert_eq!(desk.next_line(), None, "nothing of it has come to the machine");
}

#[test]
fn more_calls_than_have_room_wait_and_lose_nothing() {
    let mut desk = Desk::new(Role::Own);
    desk.upgrade(0);
    let calls: Vec<u8> = (0..100).flat_map(|id| frame(&format!(r#"{{"method":"server.info","id":{id}}}"#))).collect();
    let answers = messages(&desk.send(0, &calls));
    assert_eq!(answers.len(), 100);
    assert!(answers.iter().enumerate().all(|(id, answer)| answer.ends_with(&format!(r#""id":{id}}}"#))));
}

#[test]
fn each_page_has_a_seat_and_who_has_none_is_told() {
    let mut desk = Desk::new(Role::Own);
    for place in 0..CLIENTS {
        assert!(desk.upgrade(place).starts_with("HTTP/1.1 101 "));
    }
    assert!(desk.upgrade(CLIENTS).starts_with("HTTP/1.1 503 "));
    desk.site.close(1, &mut desk.card);
    assert!(desk.upgrade(1).starts_with("HTTP/1.1 101 "));
}

#[test]
fn the_machine_is_looked_at_while_somebody_looks() {
    let mut desk = Desk::new(Role::Own);
    assert!(!desk.site.wants_snapshot(desk.now + 4_000), "nobody looks");
    desk.open(0);
    assert!(desk.site.wants_snapshot(desk.now + PERIOD_MS) && !desk.site.wants_snapshot(desk.now + PERIOD_MS - 1));
    desk.upgrade(1);
    let told = desk.show(1, &Snapshot { state: State::Alarm, ..snapshot() });
    assert_eq!(told, [r#"{"jsonrpc":"2.0","method":"notify_klippy_shutdown","params":[]}"#]);
}

#[test]
fn a_connection_that_says_nothing_ends() {
    let mut desk = Desk::new(Role::Own);
    desk.open(0);
    assert_eq!(desk.site.life(0, desk.now), Life::Open);
    desk.send(0, b"GET / HT");
    desk.now += 6_000;
    desk.site.life(0, desk.now);
    assert!(desk.hear(0).starts_with(b"HTTP/1.1 408 "));
}

#[test]
fn a_page_hears_once_a_second_that_the_board_is_there() {
    let mut desk = Desk::new(Role::Watch);
    desk.upgrade(0);
    let beats: Vec<usize> = (0..12).map(|_| desk.show(0, &snapshot()).len()).collect();
    assert_eq!(beats.iter().sum::<usize>(), 3, "{beats:?}");
    let told = (0..4).flat_map(|_| desk.show(0, &snapshot())).next();
    assert_eq!(told.as_deref(), Some(r#"{"jsonrpc":"2.0","method":"notify_proc_stat_update","params":[{}]}"#));
}

#[test]
fn a_call_without_an_id_is_not_answered() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    assert_eq!(desk.call(0, r#"{"method":"server.info"}"#), Vec::<String>::new());
    assert_eq!(desk.call(0, r#"{"method":"printer.gcode.script","params":{"script":"M105"}}"#), Vec::<String>::new());
    assert_eq!(desk.next_line().as_deref(), Some("M105\n"), "it is carried out all the same");
    assert_eq!(desk.call(0, r#"{"method":"no.such"}"#).len(), 0);
    assert_eq!(desk.call(0, "{").len(), 1, "no JSON: nobody knows whether there was an id");
}

#[test]
fn visitors_are_told_what_they_may() {
    for (role, name) in [(Role::Watch, "Watch"), (Role::Operate, "Operate"), (Role::Own, "Own")] {
        let mut desk = Desk::new(role);
        desk.upgrade(0);
        let answer = desk.call(0, r#"{"method":"access.info","id":1}"#);
        assert!(
            answer[0].contains(&format!(r#""login_required":false,"password_set":false,"role":"{name}""#)),
            "{answer:?}"
        );
    }
}
