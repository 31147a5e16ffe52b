//! Access to the page on the real image: logins, the first password, keys, roles of lines.

use super::page::socket_with as socket;
use super::{Net, plan};
use crate::common::velvet::SECOND;
use virtual_prime::net_desk::peer::Connection;

const OPEN: &str = "[network] password_required = false";
const WATCHED: &str = "[network] watch_without_password = true";
const PAGE: &str = "[network] webserver_enable = true";
const PASSWORD: &str = "correct-horse";

/// Sends a request with these header lines and a body of JSON, if there is one. Returns the whole answer.
fn ask(net: &mut Net, request: &str, lines: &str, body: &str) -> String {
    let content = format!("Content-Type: application/json\r\nContent-Length: {}\r\n", body.len());
    let content = if body.is_empty() { "" } else { content.as_str() };
    let head = format!("{request} HTTP/1.1\r\nHost: 10.0.2.15\r\n{lines}{content}Connection: close\r\n\r\n{body}");
    super::page::exchange(net, &head)
}

/// Logs in over HTTP. Returns the answer.
fn log_in(net: &mut Net, password: &str) -> String {
    ask(net, "POST /access/login", "", &format!(r#"{{"username":"owner","password":"{password}"}}"#))
}

/// Returns the header line that shows the session of a login.
fn cookie(answer: &str) -> String {
    let cookie = answer.split("Set-Cookie: ").nth(1).unwrap_or_else(|| panic!("no cookie: {answer}"));
    assert!(cookie.contains("; HttpOnly; SameSite=Strict\r\n"), "{cookie}");
    format!("Cookie: {}\r\n", cookie.split(';').next().unwrap())
}

/// Calls a method over a WebSocket. Returns what came until these words did.
fn call(net: &mut Net, visitor: Connection, method: &str, parameters: &str, words: &str) -> String {
    super::page::call(net, visitor, method, parameters, 7);
    net.expect(visitor, words, 5 * SECOND)
}

/// Returns whether the board has closed a WebSocket for want of rights: code 1008 (RFC 6455 section 7.4.1).
fn is_closed(net: &mut Net, visitor: Connection) -> bool {
    net.peer.receive(visitor).windows(4).any(|bytes| bytes == [0x88, 2, 0x03, 0xF0])
}

fn script(net: &mut Net, visitor: Connection, line: &str, words: &str) -> String {
    call(net, visitor, "printer.gcode.script", &format!(r#""script":"{line}""#), words)
}

#[test]
fn the_first_password_is_confirmed_at_the_machine_and_makes_an_owner() {
    let mut net = Net::with_address(plan(&[PAGE]));
    let visitor = socket(&mut net, "");
    call(&mut net, visitor, "access.info", "", r#""login_required":true,"password_set":false,"role":"Nobody""#);
    call(&mut net, visitor, "printer.info", "", r#""code":401"#);
    let told = net.velvet.said().len();
    let word = format!(r#""password":"{PASSWORD}""#);
    call(&mut net, visitor, "velvet.password.set", &word, r#""state":"confirm","shown_on":"consoles""#);
    net.run(100);
    let said = net.velvet.said()[told..].to_owned();
    let code = said.split("// network: code ").nth(1).unwrap_or_else(|| panic!("no code: {said}"))[..6].to_owned();
    assert!(said.contains("at 10.0.2.2: type it there"), "{said}");
    let wrong = if code == "000000" { "000001" } else { "000000" };
    call(&mut net, visitor, "velvet.password.set", &format!(r#""code":"{wrong}""#), "this is not the code");
    assert!(log_in(&mut net, PASSWORD).starts_with("HTTP/1.1 401 "), "it is not in force");
    call(&mut net, visitor, "velvet.password.set", &format!(r#""code":"{code}""#), r#""result":"ok""#);
    let answer = log_in(&mut net, PASSWORD);
    assert!(answer.starts_with("HTTP/1.1 200 ") && answer.contains(r#""role":"Own""#), "{answer}");
    let cookie = cookie(&answer);
    assert!(ask(&mut net, "GET /printer/info", &cookie, "").starts_with("HTTP/1.1 200 "));
    assert!(net.ask("net").contains("Password: set\n"));
    // Telnet asks for the same one.
    let far = net.connect(23);
    net.expect(far, "Password: ", 2 * SECOND);
    net.say(far, PASSWORD, "Welcome to Smoothie\nok\n");
    // The record is on the card, and shown to nobody.
    let before = net.velvet.said().len();
    for line in ["cat netpass", "play netpass -v", "M32 netpass", "cp netpass x", "cat x"] {
        net.velvet.type_in(line);
        net.run(300);
    }
    let said = &net.velvet.said()[before..];
    assert!(said.contains("it is a secret of the machine") && !said.contains("pbkdf2"), "{said}");
    let out = ask(&mut net, "POST /access/logout", &cookie, "{}");
    assert!(out.contains("Set-Cookie: velvet=; Max-Age=0;"), "{out}");
    assert!(ask(&mut net, "GET /printer/info", &cookie, "").starts_with("HTTP/1.1 401 "), "the session has ended");
}

#[test]
fn wrong_passwords_are_told_and_cost_time() {
    let mut net = Net::with_address(plan(&[PAGE]));
    net.ask(&format!("password {PASSWORD}"));
    for _ in 0..5 {
        let answer = log_in(&mut net, "wrong-horse");
        assert!(answer.starts_with("HTTP/1.1 401 ") && !answer.contains("Set-Cookie"), "{answer}");
    }
    net.run(100);
    assert_eq!(net.velvet.said().matches("// network: a wrong password came from 10.0.2.2\n").count(), 5);
    let answer = log_in(&mut net, PASSWORD);
    assert!(answer.starts_with("HTTP/1.1 429 ") && answer.contains("\r\nRetry-After: "), "{answer}");
    net.run(2 * SECOND);
    assert!(log_in(&mut net, PASSWORD).starts_with("HTTP/1.1 200 "));
    let foreign = ask(&mut net, "POST /access/login", "Origin: http://evil.example\r\n", "{}");
    assert!(foreign.starts_with("HTTP/1.1 403 "), "{foreign}");
}

/// Two visitors share the page's console: each line is judged by who sent it.
#[test]
fn a_guest_has_the_machine_work_and_the_owner_changes_what_stays() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    net.ask(&format!("password {PASSWORD}"));
    let answer = log_in(&mut net, PASSWORD);
    let (guest, owner) = (socket(&mut net, ""), socket(&mut net, &cookie(&answer)));
    call(&mut net, guest, "access.info", "", r#""role":"Operate""#);
    call(&mut net, owner, "access.get_user", "", r#""username":"owner""#);
    for line in ["mkdir folder", "rm a.g", "config-set general grbl_mode true", "password off", "M500"] {
        let mut told = script(&mut net, guest, line, r#""error":{"code":400"#);
        net.run(100);
        told += &String::from_utf8_lossy(&net.peer.receive(guest));
        assert!(told.contains("this is for who has the machine's password"), "{line}: {told}");
        assert!(!told.contains(r#""result":"ok""#), "{line}: {told}");
    }
    script(&mut net, owner, "mkdir folder", r#""result":"ok""#);
    script(&mut net, guest, "rm folder", r#""error":{"code":400"#);
    script(&mut net, guest, "M104 S0", r#""result":"ok""#);
    script(&mut net, owner, "rm folder", r#""result":"ok""#);
    // Nobody's next line may become a part of somebody else's file.
    script(&mut net, owner, "M28 a.g", r#""error":{"code":400"#);
    // Another password ends the owner's session, and with it the socket.
    net.ask("password battery-staple");
    net.run(500);
    assert!(is_closed(&mut net, owner), "the socket of a session that has ended");
    call(&mut net, guest, "access.info", "", r#""role":"Operate""#);
}

#[test]
fn a_key_gives_its_role_until_it_is_revoked() {
    let mut net = Net::with_address(plan(&[PAGE, WATCHED]));
    net.ask(&format!("password {PASSWORD}"));
    assert!(ask(&mut net, "GET /printer/info", "", "").starts_with("HTTP/1.1 200 "), "everybody may watch");
    let session = cookie(&log_in(&mut net, PASSWORD));
    let made = ask(&mut net, "POST /access/api_key", &session, r#"{"name":"slicer"}"#);
    let key = made.split(r#""result":""#).nth(1).unwrap_or_else(|| panic!("no key: {made}"))[..32].to_owned();
    let line = format!("X-Api-Key: {key}\r\n");
    assert!(ask(&mut net, "GET /access/user", &line, "").contains(r#""username":"slicer""#));
    let before = net.velvet.said().len();
    net.velvet.type_in("cat netkeys");
    net.hear_until("it is a secret of the machine", SECOND);
    assert!(!net.velvet.said()[before..].contains("slicer"));
    let program = socket(&mut net, &line);
    script(&mut net, program, "M104 S0", r#""result":"ok""#);
    script(&mut net, program, "mkdir folder", r#""error":{"code":400"#);
    let watcher = socket(&mut net, "");
    script(&mut net, watcher, "M104 S0", r#""code":403"#);
    let owner = socket(&mut net, &session);
    call(&mut net, owner, "velvet.keys.list", "", r#"{"name":"slicer","role":"Operate"}"#);
    call(&mut net, owner, "velvet.keys.revoke", r#""name":"slicer""#, r#""result":"ok""#);
    assert!(ask(&mut net, "GET /printer/info", &line, "").starts_with("HTTP/1.1 401 "), "less than without a key");
    assert!(is_closed(&mut net, program), "its socket ends as well");
}
