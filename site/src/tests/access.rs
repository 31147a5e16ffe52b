//! Tests of access: the role of every method, logins, keys, the first password.

use super::*;
use crate::Verdict;
use crate::calls::{METHODS, Method};
use crate::files::Ask;

/// A secret, of bytes that count up.
const RANDOM: [u8; 16] = [7; 16];

impl Desk {
    /// Sends a request with a body of JSON and these header lines. Returns what comes back at once.
    fn post(&mut self, place: usize, path: &str, lines: &str, body: &str) -> String {
        self.open(place);
        let length = body.len();
        let request = format!(
            "POST {path} HTTP/1.1\r\nHost: velvet.local\r\nContent-Type: application/json\r\n{lines}\
             Content-Length: {length}\r\n\r\n{body}"
        );
        String::from_utf8_lossy(&self.send(place, request.as_bytes())).into_owned()
    }

    /// Asks for a path with these header lines.
    fn get_with(&mut self, place: usize, path: &str, lines: &str) -> String {
        self.open(place);
        let request = format!("GET {path} HTTP/1.1\r\nHost: velvet.local\r\n{lines}\r\n");
        String::from_utf8_lossy(&self.send(place, request.as_bytes())).into_owned()
    }

    /// Opens a WebSocket with these header lines.
    fn upgrade_with(&mut self, place: usize, lines: &str) -> String {
        self.open(place);
        let request = format!(
            "GET /websocket HTTP/1.1\r\nHost: velvet.local\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n{lines}\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        );
        String::from_utf8_lossy(&self.send(place, request.as_bytes())).into_owned()
    }

    /// Logs in over HTTP. Returns the header line of the session's cookie.
    fn log_in(&mut self, place: usize, random: [u8; 16]) -> String {
        self.site.add_random(random);
        let answer = self.post(place, "/access/login", "", r#"{"username":"owner","password":"correct-horse"}"#);
        assert_eq!(answer, "", "the gate has not said anything yet");
        assert_eq!(self.site.take_word().map(|(_, word)| word.to_vec()), Some(b"correct-horse".to_vec()));
        self.site.hear_verdict(Verdict::Right);
        let answer = String::from_utf8_lossy(&self.hear(place)).into_owned();
        assert!(answer.starts_with("HTTP/1.1 200 ") && answer.contains(r#""role":"Own""#), "{answer}");
        let cookie = answer.split("Set-Cookie: ").nth(1).expect("a cookie");
        assert!(cookie.contains("; HttpOnly; SameSite=Strict\r\n") && cookie.contains("Max-Age=2592000"), "{cookie}");
        format!("Cookie: {}\r\n", cookie.split(';').next().unwrap())
    }

    fn role(&mut self, place: usize) -> String {
        let info = self.call(place, r#"{"method":"access.info","id":1}"#).pop().unwrap();
        info.split(r#""role":""#).nth(1).unwrap().split('"').next().unwrap().to_owned()
    }
}

/// What each role may call, written once more: a method that is changed or added has to be decided on here.
fn least_role(method: Method) -> Role {
    use Method as M;
    match method {
        M::Identify | M::AccessInfo | M::Login | M::Logout | M::GetUser | M::SetPassword => Role::Nobody,
        M::ServerInfo | M::PrinterInfo | M::ListObjects | M::QueryObjects | M::Subscribe | M::EmergencyStop => {
            Role::Watch
        }
        M::Ask
        | M::Help
        | M::PathSince
        | M::Temperatures
        | M::Lines
        | M::Files(Ask::List | Ask::Directory | Ask::Metadata) => Role::Watch,
        M::Script | M::Pause | M::Resume | M::Cancel | M::Release | M::Play | M::Home | M::Override => Role::Operate,
        M::JogStep | M::JogStart | M::JogBeat | M::JogStop | M::Files(Ask::MakeFolder) => Role::Operate,
        M::MakeKey | M::ListKeys | M::RevokeKey => Role::Own,
        M::Files(Ask::Move | Ask::RemoveFile | Ask::RemoveFolder(_)) => Role::Own,
    }
}

/// Every method with every role: whether it is refused for want of the role depends on the table alone.
#[test]
fn each_role_may_call_what_is_written_here() {
    let mut calls = 0;
    for role in Role::ALL {
        for (name, method) in METHODS {
            let mut desk = Desk::new(role);
            desk.upgrade(0);
            let answer = desk.call(0, &format!(r#"{{"method":"{name}","params":{{}},"id":1}}"#)).concat();
            let is_refused = [r#""code":401,"message":"log in first""#, r#""code":403,"message":"this is for who"#]
                .iter()
                .any(|refusal| answer.contains(refusal));
            assert_eq!(!is_refused, role >= least_role(method), "{name} {role:?}: {answer}");
            calls += 1;
        }
    }
    assert_eq!(calls, 4 * METHODS.len());
}

#[test]
fn a_login_gives_a_cookie_and_a_logout_takes_its_role() {
    let mut desk = Desk::new(Role::Nobody);
    let cookie = desk.log_in(0, RANDOM);
    assert_eq!(cookie, format!("Cookie: velvet={}\r\n", "07".repeat(16)));
    assert!(desk.get_with(1, "/printer/info", &cookie).starts_with("HTTP/1.1 200 "));
    assert!(desk.get_with(2, "/printer/info", "").starts_with("HTTP/1.1 401 "));
    let other = cookie.replace('7', "8");
    assert!(desk.get_with(2, "/printer/info", &other).starts_with("HTTP/1.1 401 "), "a guess");
    assert!(desk.get_with(2, "/access/user", &cookie).contains(r#""username":"owner""#));
    desk.upgrade_with(3, &cookie);
    assert_eq!(desk.role(3), "Own");
    let bye = desk.post(2, "/access/logout", &cookie, "");
    assert!(bye.contains("user_logged_out") && bye.contains("Set-Cookie: velvet=; Max-Age=0;"), "{bye}");
    assert!(desk.get_with(1, "/printer/info", &cookie).starts_with("HTTP/1.1 401 "));
    let end = desk.hear(3);
    assert_eq!(&end[..4], [0x88, 2, 0x03, 0xF0], "the socket ends with 1008, by RFC 6455 section 7.4.1");
}

#[test]
fn a_socket_that_logs_in_is_the_owners_and_no_other_is() {
    let mut desk = Desk::new(Role::Watch);
    desk.upgrade(0);
    desk.upgrade(1);
    let login = r#"{"method":"access.login","params":{"username":"owner","password":"correct-horse"},"id":5}"#;
    assert_eq!(desk.call(0, login), Vec::<String>::new());
    assert!(desk.site.take_word().is_some() && desk.site.take_word().is_none());
    desk.site.hear_verdict(Verdict::Right);
    let heard = messages(&desk.hear(0));
    assert!(heard[0].contains("user_logged_in") && !heard[0].contains("token"), "{heard:?}");
    assert_eq!((desk.role(0), desk.role(1)), ("Own".to_owned(), "Watch".to_owned()));
    desk.site.change_password();
    assert_eq!(desk.hear(0), [0x88, 2, 0x03, 0xF0], "it ends with 1008, by RFC 6455 section 7.4.1");
}

#[test]
fn wrong_passwords_are_refused_with_the_time_to_wait() {
    let mut desk = Desk::new(Role::Nobody);
    for (place, (verdict, status, text)) in [
        (Verdict::Wrong, "401 ", "not the password"),
        (Verdict::NoPassword, "401 ", "no password is set"),
        (Verdict::Wait(16), "429 ", "try again in 16 s"),
    ]
    .into_iter()
    .enumerate()
    {
        desk.post(place, "/access/login", "", r#"{"username":"owner","password":"x"}"#);
        assert_eq!(desk.site.take_word().map(|(from, _)| from), Some(FROM.octets()));
        desk.site.hear_verdict(verdict);
        let answer = String::from_utf8_lossy(&desk.hear(place)).into_owned();
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")) && answer.contains(text), "{answer}");
        assert!(!answer.contains("Set-Cookie"), "{answer}");
        assert_eq!(answer.contains("Retry-After: 16\r\n"), verdict == Verdict::Wait(16));
    }
}

#[test]
fn logins_that_cannot_wait_are_told_so_and_who_leaves_gets_nothing() {
    let mut desk = Desk::new(Role::Nobody);
    let login = r#"{"password":"correct-horse"}"#;
    for place in 0..3 {
        assert_eq!(desk.post(place, "/access/login", "", login), "");
    }
    assert!(desk.post(3, "/access/login", "", login).starts_with("HTTP/1.1 503 "));
    desk.site.take_word();
    desk.site.close(0, &mut desk.card);
    desk.open(0);
    desk.site.add_random(RANDOM);
    desk.site.hear_verdict(Verdict::Right);
    assert!(desk.hear(0).is_empty(), "another visitor has come to the place");
    assert!(desk.get_with(4, "/printer/info", &format!("Cookie: velvet={}\r\n", "07".repeat(16))).contains("401"));
}

/// A page of another site cannot have a browser log in, nor a name that leads here.
#[test]
fn a_login_is_checked_for_host_origin_and_content() {
    let mut desk = Desk::new(Role::Nobody);
    let login = |desk: &mut Desk, host: &str, lines: &str| {
        desk.open(0);
        let request = format!("POST /access/login HTTP/1.1\r\nHost: {host}\r\n{lines}Content-Length: 2\r\n\r\n{{}}");
        let answer = String::from_utf8_lossy(&desk.send(0, request.as_bytes())).into_owned();
        (answer.get(9..12).unwrap_or_default().to_owned(), desk.site.take_word().is_some())
    };
    let json = "Content-Type: application/json\r\n";
    for (host, lines, status) in [
        ("evil.example", json.to_owned(), "421"),
        ("velvet.local", format!("{json}Origin: http://evil.example\r\n"), "403"),
        ("velvet.local", format!("{json}Sec-Fetch-Site: cross-site\r\n"), "403"),
        ("velvet.local", "Content-Type: text/plain\r\n".to_owned(), "415"),
    ] {
        assert_eq!(login(&mut desk, host, &lines), (status.to_owned(), false), "{host} {lines}");
    }
    assert_eq!(login(&mut desk, "velvet.local", json), (String::new(), true));
}

#[test]
fn a_body_that_is_no_call_logs_nobody_in() {
    let mut desk = Desk::new(Role::Nobody);
    for body in ["nonsense", r#"{"password":"x""#, &format!(r#"{{"password":"{}"}}"#, "x".repeat(400))] {
        let answer = desk.post(0, "/access/login", "", body);
        let is_taken = desk.site.take_word().is_some_and(|(_, word)| !word.is_empty());
        assert!(!is_taken, "{body}: {answer}");
        desk.site.hear_verdict(Verdict::Wrong);
    }
    let long = desk.post(0, "/access/login", "", &format!(r#"{{"password":"{}"}}"#, "x".repeat(600)));
    assert!(long.starts_with("HTTP/1.1 413 "), "{long}");
}

/// One slow request must not keep everybody else from logging in.
#[test]
fn a_call_that_comes_slowly_makes_room() {
    let mut desk = Desk::new(Role::Nobody);
    desk.open(0);
    let slow =
        "POST /access/login HTTP/1.1\r\nHost: velvet\r\nContent-Type: application/json\r\nContent-Length: 9\r\n\r\n{";
    desk.send(0, slow.as_bytes());
    let login = r#"{"password":"correct-horse"}"#;
    assert!(desk.post(1, "/access/login", "", login).starts_with("HTTP/1.1 503 "));
    desk.now += 2_000;
    assert_eq!(desk.post(1, "/access/login", "", login), "");
    let late = String::from_utf8_lossy(&desk.send(0, b"        ")).into_owned();
    assert!(late.starts_with("HTTP/1.1 503 "), "{late}");
    assert!(desk.site.take_word().is_some_and(|(_, word)| word == b"correct-horse"));
}

#[test]
fn a_key_is_shown_once_and_gives_its_role_until_it_is_revoked() {
    let mut desk = Desk::new(Role::Nobody);
    let cookie = desk.log_in(0, [1; 16]);
    desk.upgrade_with(1, &cookie);
    desk.site.add_random(RANDOM);
    let make = r#"{"method":"access.post_api_key","params":{"name":"slicer"},"id":2}"#;
    assert_eq!(desk.call(1, make), Vec::<String>::new(), "it is told when it is kept");
    let record = desk.site.take_keys().expect("a record");
    assert!(!String::from_utf8_lossy(&record).contains(&"07".repeat(16)), "not the key itself");
    desk.site.hear_kept(Ok(()));
    let key = "07".repeat(16);
    assert_eq!(messages(&desk.hear(1)), [format!(r#"{{"jsonrpc":"2.0","result":"{key}","id":2}}"#)]);
    for line in [format!("X-Api-Key: {key}\r\n"), format!("Authorization: Bearer {key}\r\n")] {
        assert!(desk.get_with(2, "/access/user", &line).contains(r#""username":"slicer""#));
        assert!(desk.get_with(2, "/printer/info", &line).starts_with("HTTP/1.1 200 "));
        assert!(desk.post(2, "/access/api_key", &line, r#"{"name":"x"}"#).starts_with("HTTP/1.1 403 "));
    }
    assert!(desk.get_with(2, "/printer/info", "X-Api-Key: guess\r\n").starts_with("HTTP/1.1 401 "));
    let listed = desk.call(1, r#"{"method":"velvet.keys.list","id":3}"#);
    assert!(listed[0].contains(r#""keys":[{"name":"slicer","role":"Operate"}]"#), "{listed:?}");
    desk.call(1, r#"{"method":"velvet.keys.revoke","params":{"name":"slicer"},"id":4}"#);
    assert!(desk.get_with(2, "/printer/info", &format!("X-Api-Key: {key}\r\n")).starts_with("HTTP/1.1 401 "));
    assert!(desk.site.take_keys().is_some_and(|record| record.is_empty()));
    desk.site.hear_kept(Ok(()));
    assert!(messages(&desk.hear(1))[0].contains(r#""result":"ok","id":4"#));
    let mut again = Desk::new(Role::Nobody);
    again.site.read_keys(&record);
    assert!(again.get_with(0, "/printer/info", &format!("X-Api-Key: {key}\r\n")).contains("200 OK"), "after a start");
}

#[test]
fn a_key_that_the_card_does_not_take_is_none() {
    let mut desk = Desk::new(Role::Own);
    desk.upgrade(0);
    desk.site.add_random(RANDOM);
    desk.call(0, r#"{"method":"access.post_api_key","params":{"name":"slicer","role":"Watch"},"id":2}"#);
    desk.site.hear_kept(Err("there is no card"));
    assert!(messages(&desk.hear(0))[0].contains(r#""error":{"code":500,"message":"there is no card"}"#));
    assert!(desk.get_with(1, "/printer/info", &format!("X-Api-Key: {}\r\n", "07".repeat(16))).contains("401"));
    for (parameters, code) in [(r#""name":"""#, -32_602), (r#""name":"a","role":"Nobody""#, -32_602)] {
        desk.site.add_random(RANDOM);
        let answer = desk.call(0, &format!(r#"{{"method":"access.post_api_key","params":{{{parameters}}},"id":2}}"#));
        assert!(answer[0].contains(&format!(r#""code":{code}"#)), "{answer:?}");
    }
}

#[test]
fn the_first_password_is_confirmed_by_the_code_that_the_machine_shows() {
    let mut desk = Desk::new(Role::Nobody);
    desk.upgrade(0);
    desk.upgrade(1);
    desk.site.add_random([0x2A, 0, 0, 0, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9]);
    let set = |what: &str| format!(r#"{{"method":"velvet.password.set","params":{{{what}}},"id":1}}"#);
    assert!(desk.call(0, &set(r#""password":"short""#))[0].contains("8 to 63"));
    let told = desk.call(0, &set(r#""password":"correct-horse""#));
    assert!(told[0].contains(r#""state":"confirm","shown_on":"consoles","expires_s":300"#), "{told:?}");
    assert_eq!(desk.site.take_code(), Some((42, FROM.octets())));
    assert!(desk.call(1, &set(r#""code":"000042""#))[0].contains("no password waits"), "another visitor");
    assert!(desk.call(0, &set(r#""code":"000043""#))[0].contains("not the code"));
    assert_eq!(desk.call(0, &set(r#""code":"000042""#)), Vec::<String>::new());
    assert_eq!(desk.site.take_password().map(|word| word.to_vec()), Some(b"correct-horse".to_vec()));
    desk.site.hear_kept(Ok(()));
    assert!(messages(&desk.hear(0))[0].contains(r#""result":"ok""#));
    desk.site.set_has_password(true);
    assert!(desk.call(0, &set(r#""password":"battery-staple""#))[0].contains(r#""code":403"#), "there is one now");
}

#[test]
fn who_has_the_password_changes_it_without_a_code() {
    let mut desk = Desk::new(Role::Nobody);
    desk.site.set_has_password(true);
    let cookie = desk.log_in(0, RANDOM);
    desk.upgrade_with(1, &cookie);
    let set = r#"{"method":"velvet.password.set","params":{"password":"battery-staple"},"id":1}"#;
    assert_eq!(desk.call(1, set), Vec::<String>::new());
    assert!(desk.site.take_password().is_some() && desk.site.take_code().is_none());
    // The board sets the new record, then says that it is kept.
    desk.site.change_password();
    desk.site.hear_kept(Ok(()));
    let heard = desk.hear(1);
    assert!(String::from_utf8_lossy(&heard).contains(r#""result":"ok""#), "the answer goes out before the socket ends");
}

#[test]
fn who_may_watch_gets_the_seat_of_who_may_nothing() {
    let mut desk = Desk::new(Role::Nobody);
    desk.site.read_keys(format!("Watch {} desk\n", crate::access::text_of(&[0; 16])).as_bytes());
    for place in 0..CLIENTS {
        assert!(desk.upgrade(place).starts_with("HTTP/1.1 101 "));
    }
    assert!(desk.upgrade(CLIENTS).starts_with("HTTP/1.1 503 "));
    let cookie = desk.log_in(CLIENTS, RANDOM);
    assert!(desk.upgrade_with(CLIENTS, &cookie).starts_with("HTTP/1.1 101 "));
    assert_eq!(desk.hear(0).first(), Some(&0x88), "the first of them is turned out");
    assert_eq!(desk.role(CLIENTS), "Own");
}

#[test]
fn a_line_goes_to_the_machine_with_the_role_of_who_sent_it() {
    let mut desk = Desk::new(Role::Operate);
    let cookie = desk.log_in(0, RANDOM);
    desk.upgrade_with(1, &cookie);
    desk.upgrade(2);
    desk.call(1, r#"{"method":"printer.gcode.script","params":{"script":"rm a.g"},"id":1}"#);
    desk.call(2, r#"{"method":"printer.gcode.script","params":{"script":"rm b.g"},"id":1}"#);
    let roles: Vec<Role> = (0..2)
        .map(|_| {
            let (_, role) = desk.site.next_line(desk.now).expect("a line");
            desk.say(&[DONE]);
            role
        })
        .collect();
    assert_eq!(roles, [Role::Own, Role::Operate]);
    desk.call(1, r#"{"method":"printer.gcode.script","params":{"script":"rm a.g"},"id":2}"#);
    desk.site.change_password();
    assert_eq!(desk.site.next_line(desk.now).map(|(_, role)| role), Some(Role::Operate), "what is left of the role");
}
