//! The page and its API on the real image: HTTP and a WebSocket over the cable.

use super::{Net, plan};
use crate::common::velvet::SECOND;
use virtual_prime::net_desk::peer::Connection;

pub(super) const OPEN: &str = "[network] password_required = false";
pub(super) const PAGE: &str = "[network] webserver_enable = true";
pub(super) const PORT: u16 = 80;

/// Sends a request of HTTP that wants the connection closed behind its answer. Returns the whole answer as
/// text, with what is no text replaced.
pub(super) fn exchange(net: &mut Net, request: &str) -> String {
    let visitor = net.connect(PORT);
    net.send(visitor, request.as_bytes());
    let (mut heard, end) = (Vec::new(), net.velvet.now_ms() + 10 * SECOND);
    while !net.peer.is_over(visitor) && net.velvet.now_ms() < end {
        net.run(2);
        heard.extend(net.peer.receive(visitor));
        if net.peer.has_ended(visitor) {
            net.peer.close(visitor);
        }
    }
    String::from_utf8_lossy(&heard).into_owned()
}

/// Asks for a path. Returns the answer's head and body.
fn get(net: &mut Net, path: &str) -> String {
    exchange(net, &format!("GET {path} HTTP/1.1\r\nHost: 10.0.2.15\r\nConnection: close\r\n\r\n"))
}

/// Opens a WebSocket.
pub(super) fn socket(net: &mut Net) -> Connection {
    socket_with(net, "")
}

/// Opens a WebSocket with these header lines.
pub(super) fn socket_with(net: &mut Net, lines: &str) -> Connection {
    let visitor = net.connect(PORT);
    ask_for_socket(net, visitor, lines);
    // The value for this key is that of RFC 6455 section 1.3.
    net.expect(visitor, "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n\r\n", 2 * SECOND);
    visitor
}

/// Asks for a WebSocket, with these header lines.
pub(super) fn ask_for_socket(net: &mut Net, visitor: Connection, lines: &str) {
    let request = format!(
        "GET /websocket HTTP/1.1\r\nHost: 10.0.2.15\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n{lines}\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    net.send(visitor, request.as_bytes());
}

/// Sends a call as a frame with a mask of zeros.
pub(super) fn call(net: &mut Net, visitor: Connection, method: &str, parameters: &str, id: u32) {
    let text = format!(r#"{{"jsonrpc":"2.0","method":"{method}","params":{{{parameters}}},"id":{id}}}"#);
    // A length is written in as few bytes as can be (RFC 6455 section 5.2).
    let mut frame = vec![0x81];
    match text.len() {
        length @ 0..126 => frame.push(0x80 | length as u8),
        length => {
            frame.push(0x80 | 126);
            frame.extend((length as u16).to_be_bytes());
        }
    }
    frame.extend([0; 4]);
    frame.extend(text.bytes());
    net.send(visitor, &frame);
}

#[test]
fn a_browser_gets_the_page_and_sees_the_machine_move() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    let index = get(&mut net, "/");
    assert!(index.starts_with("HTTP/1.1 200 OK\r\n") && index.contains("Content-Encoding: gzip"), "{index}");
    assert!(get(&mut net, "/printer/objects/query?velvet").contains(r#""mode":"Idle""#));
    assert!(net.ask("net").contains("Page: port 80, "));
    net.ask("G28.3 X10 Y10 Z10");
    let visitor = socket(&mut net);
    call(&mut net, visitor, "printer.objects.subscribe", r#""objects":{"motion_report":null}"#, 1);
    net.expect(visitor, r#""live_position":[10,10,10"#, 2 * SECOND);
    call(&mut net, visitor, "printer.gcode.script", r#""script":"G1 X20 F600\nM400""#, 2);
    let told = net.expect(visitor, r#""result":"ok","id":2"#, 5 * SECOND);
    assert!(told.matches("notify_status_update").count() >= 3, "it moves for a second: {told}");
    net.expect(visitor, r#""live_position":[20,10,10"#, 2 * SECOND);
    call(&mut net, visitor, "printer.gcode.script", r#""script":"M104 S999""#, 3);
    net.expect(visitor, "above its max_temp", 2 * SECOND);
}

#[test]
fn a_page_stops_the_machine_at_once() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    net.ask("G28.3 X10 Y10 Z10");
    let visitor = socket(&mut net);
    call(&mut net, visitor, "printer.gcode.script", r#""script":"M104 S50\nG1 X200 F600\nM400""#, 1);
    net.run(SECOND);
    call(&mut net, visitor, "printer.emergency_stop", "", 2);
    net.hear_until("Emergency stop", SECOND);
    // The line that was in work is not done, and its caller is told so.
    net.expect(visitor, r#""error":{"code":400"#, 2 * SECOND);
    // What is told is a quarter of a second old at the most.
    net.run(300);
    assert!(get(&mut net, "/printer/objects/query?webhooks&extruder").contains(r#""state":"shutdown""#));
    call(&mut net, visitor, "printer.firmware_restart", "", 3);
    net.expect(visitor, r#""result":"ok","id":3"#, 5 * SECOND);
}

#[test]
fn an_answer_of_many_lines_comes_whole_to_who_asks() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    let (asker, other) = (socket(&mut net), socket(&mut net));
    call(&mut net, asker, "velvet.ask", r#""script":"help""#, 1);
    let told = net.expect(asker, r#""result":"ok","id":1"#, 5 * SECOND);
    // All commands, from the first to the last: twice what the board has room for.
    assert!(told.matches(r#""method":"notify_velvet_answer""#).count() >= 55, "{told}");
    assert!(told.contains("help [command or code] - list the commands") && told.contains("$SLP  - sleep"), "{told}");
    call(&mut net, other, "printer.gcode.script", r#""script":"M118 for all""#, 2);
    let told = net.expect(other, r#""result":"ok","id":2"#, 5 * SECOND);
    assert!(told.contains("for all") && !told.contains("notify_velvet_answer"), "{told}");
}

#[test]
fn with_a_password_nobody_sees_more_than_the_page() {
    let mut net = Net::with_address(plan(&[PAGE]));
    assert!(get(&mut net, "/").starts_with("HTTP/1.1 200 "));
    for path in ["/printer/info", "/printer/objects/query?toolhead"] {
        assert!(get(&mut net, path).starts_with("HTTP/1.1 401 "), "{path}");
    }
}
