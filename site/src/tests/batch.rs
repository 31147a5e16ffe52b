//! Several calls in one message.

use super::*;

/// Takes the answers of an array that is one message.
#[track_caller]
fn answers(message: &str) -> Vec<String> {
    let inner = message.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).expect("an array");
    inner.split("},{\"jsonrpc\"").map(str::to_owned).collect()
}

/// Posts calls. Returns the head of the answer, and its body.
fn post(desk: &mut Desk, body: &str) -> (String, String) {
    desk.open(3);
    let request = format!(
        "POST /server/jsonrpc HTTP/1.1\r\nHost: velvet.local\r\nContent-Type: application/json\r\nContent-Length: \
         {}\r\n\r\n{body}",
        body.len()
    );
    let answer = String::from_utf8(desk.send(3, request.as_bytes())).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
    let body = if body.is_empty() { Vec::new() } else { files::chunks(body.as_bytes()) };
    (head.to_owned(), String::from_utf8(body).unwrap())
}

const INFO: &str = r#"{"jsonrpc":"2.0","result":{"state":"ready","hostname":"velvet","software_version":"1.2.3","app":"Velvet"},"id":"a"}"#;

#[test]
fn calls_of_one_message_are_answered_by_one_array() {
    for room in [1_000, 1_460, 20_000] {
        let mut desk = Desk::new(Role::Operate);
        desk.room = room;
        desk.macros = vec![("A", "")];
        desk.upgrade(0);
        let calls = r#"[{"method":"printer.info","id":"a"}, {"method":"printer.objects.query","params":{"objects":{"velvet":null,"toolhead":null}},"id":2},
            {"method":"server.info"},{"method":"no.such","id":3},[{"id":9}],"call",{"params":{"count":1},"method":"server.gcode_store","id":4},{"method":"printer.gcode.help","id":5}]"#;
        let told = desk.call(0, calls);
        assert_eq!(told.len(), 1, "{told:?}");
        let answers = answers(&told[0]);
        assert_eq!(answers.len(), 7, "one is a notification: {answers:?}");
        assert!(told[0].starts_with(&format!("[{INFO},{{\"jsonrpc\"")), "{told:?}");
        for (answer, holds) in answers.iter().zip([
            r#""app":"Velvet""#,
            r#""macros":0}}},"id":2"#,
            r#""code":-32601,"message":"there is no such method"},"id":3"#,
            r#""code":-32600,"message":"the message names no method"},"id":null"#,
            r#""code":-32600"#,
            r#""gcode_store":[]},"id":4"#,
            r#""A":"macro"},"id":5"#,
        ]) {
            assert!(answer.contains(holds), "{holds}: {answer}");
        }
        assert_eq!(desk.call(0, r#"{"method":"printer.info","id":"a"}"#), [INFO], "one alone is one");
    }
}

#[test]
fn an_array_waits_for_the_machine_and_holds_nothing_up() {
    let mut desk = Desk::new(Role::Own);
    desk.card.put("/sd/a.g", b"x");
    desk.upgrade(0);
    desk.upgrade(1);
    let script = |name: &str, id| format!(r#"{{"method":"{name}","params":{{"script":"M115"}},"id":{id}}}"#);
    let list = r#"{"method":"server.files.list","params":{"root":"gcodes"},"id":3}"#;
    let calls = format!("[{},{list},{}]", script("printer.gcode.script", 1), script("velvet.ask", 2));
    assert_eq!(desk.call(0, &calls), Vec::<String>::new());
    assert_eq!(desk.call(0, r#"{"method":"printer.info","id":"a"}"#), [INFO], "other calls go on");
    let another = desk.call(1, r#"[{"method":"printer.info","id":1}]"#);
    assert!(another.len() == 1 && another[0].contains(r#""code":503"#) && another[0].starts_with('{'), "{another:?}");
    assert_eq!(desk.next_line().as_deref(), Some("M115\n"));
    desk.say(b"for all\nok\n\x06");
    assert!(desk.next_line().is_some());
    desk.say(b"for one\nok\n");
    let told = messages(&desk.hear(0));
    assert!(told.len() == 2 && told[1].contains("notify_velvet_answer"), "told before the answers: {told:?}");
    desk.say(b"\x06");
    let told = messages(&desk.hear(0));
    assert_eq!(told.len(), 1);
    let answers = answers(&told[0]);
    assert!(answers.len() == 3 && answers[0].contains(r#""path":"a.g""#), "the list came first: {answers:?}");
    assert!(answers[1].contains(r#""result":"ok","id":1"#) && answers[2].contains(r#""result":"ok","id":2"#));
    assert!(desk.call(1, r#"[{"method":"printer.info","id":"a"}]"#)[0].starts_with("[{"), "there is room again");
    assert!(desk.ask(0, "server.files.list", r#""root":"gcodes""#).contains("a.g"), "and for lists");
}

#[test]
fn more_calls_than_a_message_may_have_are_refused_and_what_is_broken_is_said() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    let script = r#"{"method":"velvet.home","params":{"axes":"q"},"id":1}"#;
    let many = format!("[{}{script}]", format!("{script},").repeat(30));
    let told = desk.call(0, &many);
    let all = answers(&told[0]);
    assert!(told.len() == 1 && all.len() == 9 && all[7].contains("-32602"), "{all:?}");
    assert!(all[8].contains("a message has at most 8 calls"), "{}", all[8]);
    let told = desk.call(0, r#"[{"method":"printer.info","id":"a"},{"method":"#);
    assert!(told.len() == 1 && told[0].starts_with(&format!("[{INFO},")), "{told:?}");
    assert!(told[0].ends_with(r#""error":{"code":-32700,"message":"the message is no JSON"},"id":null}]"#), "{told:?}");
    assert_eq!(desk.call(0, r#"[{"method":"printer.info"},{"method":"server.info"}]"#), Vec::<String>::new());
    assert_eq!(desk.call(0, r#"{"method":"printer.info","id":"a"}"#), [INFO]);
}

#[test]
fn a_message_of_who_has_gone_makes_room_for_others() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    desk.call(0, r#"[{"method":"printer.gcode.script","params":{"script":"G28"},"id":1}]"#);
    desk.site.close(0, &mut desk.card);
    desk.upgrade(0);
    assert!(desk.call(0, r#"[{"method":"printer.info","id":"a"}]"#)[0].starts_with('['));
    desk.next_line();
    desk.say(b"\x06");
    assert_eq!(messages(&desk.hear(0)), Vec::<String>::new());
}

#[test]
fn a_message_without_an_end_holds_nobody_up_for_long() {
    let mut desk = Desk::new(Role::Watch);
    desk.upgrade(0);
    desk.upgrade(1);
    let begun = frame(r#"[{"method":"printer.info","id":"a"},"#);
    let piece = [&[0x01], &begun[1..]].concat();
    assert!(desk.send(0, &piece).is_empty(), "the first of several frames");
    assert!(desk.call(1, r#"[{"method":"printer.info","id":"a"}]"#)[0].contains(r#""code":503"#));
    desk.now += 2_000;
    assert_eq!(desk.call(1, r#"[{"method":"printer.info","id":"a"}]"#), [format!("[{INFO}]")]);
    let rest = frame(r#"{"method":"printer.info","id":"a"}]"#);
    let told = messages(&desk.send(0, &[&[0x80], &rest[1..]].concat()));
    assert!(told.len() == 1 && told[0].contains(r#""code":503"#), "its answers are lost, and it hears so: {told:?}");
}

#[test]
fn calls_are_posted_with_the_role_of_who_posts() {
    let mut desk = Desk::new(Role::Watch);
    let (head, body) = post(&mut desk, r#"{"method":"printer.info","id":"a"}"#);
    assert!(head.starts_with("HTTP/1.1 200 ") && body == INFO, "{head}: {body}");
    let calls = r#"[{"method":"printer.info","id":"a"},{"method":"printer.firmware_restart","id":1},
        {"method":"server.files.list","params":{"root":"gcodes"},"id":2},{"method":"access.login","params":{"password":"x"},"id":3},
        {"method":"access.info","id":4},{"method":"printer.emergency_stop","id":5}]"#;
    let (head, body) = post(&mut desk, calls);
    let answers = answers(&body);
    assert!(head.starts_with("HTTP/1.1 200 ") && answers.len() == 6, "{head}: {body}");
    for (answer, holds) in
        answers.iter().zip(["Velvet", r#""code":403"#, "over the WebSocket", "over the WebSocket", "Watch", r#""ok""#])
    {
        assert!(answer.contains(holds), "{holds}: {answer}");
    }
    assert!(desk.site.take_stop().is_some());
    assert!(post(&mut desk, r#"{"method":"printer.info"}"#).0.starts_with("HTTP/1.1 204 "));
    assert!(post(&mut desk, r#"[{"method":"printer.info"}]"#).0.starts_with("HTTP/1.1 204 "));
    assert!(post(&mut desk, "[{").1.contains("-32700"));
    let mut nobody = Desk::new(Role::Nobody);
    let (_, body) = post(&mut nobody, r#"[{"method":"printer.info","id":1},{"method":"access.info","id":2}]"#);
    assert!(body.contains(r#""code":401"#) && body.contains(r#""role":"Nobody""#), "{body}");
}
