//! Calls that come to lines of the machine, and what it says to them.

use super::*;

#[test]
fn a_script_is_answered_when_the_machine_is_done() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    desk.upgrade(1);
    let call = r#"{"jsonrpc":"2.0","method":"printer.gcode.script","params":{"script":"G28\nM105"},"id":"a1"}"#;
    assert_eq!(desk.call(0, call), Vec::<String>::new());
    assert_eq!(desk.next_line().as_deref(), Some("G28\n"));
    desk.say(&[b'o', b'k', b'\n', DONE]);
    assert_eq!(desk.next_line().as_deref(), Some("M105\n"));
    desk.say(b"ok T:21.5 /0.0 @0\n");
    let heard = desk.hear(1);
    assert_eq!(
        messages(&heard),
        [r#"{"jsonrpc":"2.0","method":"notify_gcode_response","params":["ok T:21.5 /0.0 @0"]}"#]
    );
    desk.say(&[DONE]);
    let heard = desk.hear(0);
    assert_eq!(messages(&heard)[1], r#"{"jsonrpc":"2.0","result":"ok","id":"a1"}"#, "behind what was said");
    desk.call(0, r#"{"method":"printer.gcode.script","params":{"script":"M104 S999"},"id":2}"#);
    desk.next_line();
    desk.say(b"error:too hot\n");
    desk.say(&[REFUSED]);
    let heard = messages(&desk.hear(0));
    assert!(heard[0].contains("notify_gcode_response") && heard[0].contains("too hot"), "{heard:?}");
    assert_eq!(heard[1], r#"{"jsonrpc":"2.0","error":{"code":400,"message":"too hot"},"id":2}"#);
}

#[test]
fn an_answer_comes_to_who_has_asked_before_its_end() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    desk.upgrade(1);
    desk.call(0, r#"{"method":"velvet.ask","params":{"script":"version"},"id":3}"#);
    assert_eq!(desk.next_line().as_deref(), Some("version\n"));
    desk.say(b"Velvet 1\n\x07// the cable is out\nPrime\nok\n\x06");
    let news = r#"{"jsonrpc":"2.0","method":"notify_gcode_response","params":["// the cable is out"]}"#;
    let answer = |line| format!(r#"{{"jsonrpc":"2.0","method":"notify_velvet_answer","params":["{line}"]}}"#);
    let done = r#"{"jsonrpc":"2.0","result":"ok","id":3}"#;
    assert_eq!(messages(&desk.hear(0)), [&answer("Velvet 1"), news, &answer("Prime"), done]);
    assert_eq!(messages(&desk.hear(1)), [news]);
}

#[test]
fn a_long_answer_waits_for_who_has_asked() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    desk.call(0, r#"{"method":"velvet.ask","params":{"script":"help"},"id":3}"#);
    desk.next_line();
    let long: Vec<u8> = (0..400).flat_map(|line| format!("help of line {line}\n").into_bytes()).chain([DONE]).collect();
    let (mut said, mut heard) = (0, Vec::new());
    while said < long.len() {
        said += desk.site.hear(&long[said..], desk.now);
        heard.extend(messages(&desk.hear(0)));
    }
    assert_eq!(heard.len(), 401);
    assert!(heard[399].contains("line 399") && heard[400].ends_with(r#""id":3}"#), "{:?}", &heard[399..]);
}

#[test]
fn a_script_of_who_has_left_answers_nobody_else() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    desk.call(0, r#"{"method":"printer.gcode.script","params":{"script":"G28"},"id":1}"#);
    desk.site.close(0, &mut desk.card);
    desk.upgrade(1);
    desk.next_line();
    desk.say(&[DONE]);
    assert_eq!(messages(&desk.hear(1)), Vec::<String>::new());
}

#[test]
fn who_may_only_watch_may_stop_the_machine_and_nothing_else() {
    let mut desk = Desk::new(Role::Watch);
    desk.upgrade(0);
    for method in ["printer.gcode.script", "printer.print.pause", "printer.print.resume", "printer.print.cancel"] {
        let call = format!(r#"{{"method":"{method}","params":{{"script":"G28"}},"id":1}}"#);
        assert!(desk.call(0, &call)[0].contains(r#""code":403"#), "{method}");
    }
    assert_eq!((desk.next_line(), desk.site.take_stop().is_some()), (None, false));
    assert!(desk.call(0, r#"{"method":"printer.emergency_stop","id":1}"#)[0].contains("ok"));
    assert!(desk.site.take_stop().is_some());
}

#[test]
fn a_page_without_a_socket_stops_the_machine_too() {
    let ask = |role, more: &str| {
        let mut desk = Desk::new(role);
        desk.open(0);
        let request =
            format!("POST /printer/emergency_stop HTTP/1.1\r\nHost: velvet.local\r\n{more}Content-Length: 0\r\n\r\n");
        let answer = String::from_utf8_lossy(&desk.send(0, request.as_bytes())).into_owned();
        (answer, desk.site.take_stop().is_some())
    };
    let (answer, stops) = ask(Role::Watch, "");
    assert!(answer.starts_with("HTTP/1.1 200 ") && answer.contains(r#"{"result":"ok"}"#) && stops, "{answer}");
    let (answer, stops) = ask(Role::Nobody, "");
    assert!(answer.starts_with("HTTP/1.1 401 ") && !stops, "{answer}");
    let (answer, stops) = ask(Role::Own, "Content-Type: text/plain\r\n");
    assert!(answer.starts_with("HTTP/1.1 415 ") && !stops, "a form of another page: {answer}");
    let (answer, stops) = ask(Role::Own, "Origin: http://evil.example\r\n");
    assert!(answer.starts_with("HTTP/1.1 403 ") && !stops, "{answer}");
}

#[test]
fn a_body_that_no_path_takes_is_refused() {
    let mut desk = Desk::new(Role::Own);
    desk.open(0);
    let long = b"GET /printer/info HTTP/1.1\r\nHost: velvet.local\r\nContent-Length: 5000\r\n\r\n";
    assert!(desk.send(0, long).starts_with(b"HTTP/1.1 413 "));
}

/// Begins a jog on a socket that was opened. Returns the line that the machine gets.
fn begin_jog(desk: &mut Desk, place: usize) -> Option<String> {
    let start = r#"{"method":"velvet.jog.start","params":{"axis":"x","direction":1,"mm_per_min":12000},"id":9}"#;
    let answer = desk.call(place, start);
    assert!(answer.len() == 1 && answer[0].contains(r#""result":{"id":"#), "{answer:?}");
    desk.next_line().map(|line| line.as_str().to_owned())
}

#[test]
fn a_jog_ends_with_its_button_its_connection_and_its_beats() {
    for ends in ["stop", "close", "fin", "reload", "silence", "halt"] {
        let mut desk = Desk::new(Role::Operate);
        desk.upgrade(0);
        desk.upgrade(1);
        assert_eq!(begin_jog(&mut desk, 0).as_deref(), Some("$J -c X1 F12000\n"));
        for _ in 0..20 {
            desk.now += 60;
            assert_eq!(desk.call(0, r#"{"method":"velvet.jog.beat","params":{"id":1}}"#), Vec::<String>::new());
            // Another visitor's beats are heard as well, and are no use.
            assert!(desk.call(1, r#"{"method":"velvet.jog.beat","params":{"id":1},"id":1}"#)[0].contains("404"));
            assert!(!desk.site.take_jog_end(desk.now), "{ends}");
        }
        match ends {
            "stop" => {
                assert!(desk.call(0, r#"{"method":"velvet.jog.stop","params":{"id":1},"id":2}"#)[0].contains("ok"))
            }
            "close" => desk.site.close(0, &mut desk.card),
            "fin" => desk.site.hear_end(0),
            // A closing frame, as a browser sends it whose page is left.
            "reload" => drop(desk.send(0, &[0x88, 0x80, 1, 2, 3, 4])),
            "silence" => desk.now += 100,
            _ => drop(desk.call(1, r#"{"method":"printer.emergency_stop"}"#)),
        }
        assert!(desk.site.take_jog_end(desk.now), "{ends}");
        desk.say(&[DONE]);
        assert_eq!(desk.next_line(), None, "{ends}: nothing goes on");
        desk.now += 10_000;
        assert!(!desk.site.take_jog_end(desk.now), "{ends}: it is over");
    }
}

#[test]
fn lines_wait_for_the_end_of_a_jog_and_no_jog_begins_behind_lines() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    assert!(begin_jog(&mut desk, 0).is_some());
    desk.call(0, r#"{"method":"printer.gcode.script","params":{"script":"M105"},"id":3}"#);
    assert_eq!(desk.next_line(), None);
    desk.call(0, r#"{"method":"velvet.jog.stop","params":{"id":1}}"#);
    assert!(desk.site.take_jog_end(desk.now));
    desk.say(&[DONE]);
    assert_eq!(desk.next_line().as_deref(), Some("M105\n"));
    let start = r#"{"method":"velvet.jog.start","params":{"axis":"x","direction":1,"mm_per_min":600},"id":4}"#;
    assert!(desk.call(0, start).iter().any(|answer| answer.contains(r#""code":503"#)));
}

#[test]
fn the_path_is_told_from_a_number_on() {
    let mut desk = Desk::new(Role::Watch);
    desk.upgrade(0);
    assert_eq!(desk.site.follows_path(), None);
    let since = |desk: &mut Desk, seq: u32| {
        desk.call(0, &format!(r#"{{"method":"velvet.path.since","params":{{"seq":{seq}}},"id":1}}"#)).remove(0)
    };
    let answer = since(&mut desk, 0);
    assert_eq!(answer, r#"{"jsonrpc":"2.0","result":{"next":0,"lost":false,"points":[]},"id":1}"#);
    assert_eq!(desk.site.follows_path(), Some(true));
    desk.site.begin_path();
    for number in 0..100_u8 {
        desk.site.add_to_path([f32::from(number), f32::from(number % 2), 0.2], number > 5);
    }
    let answer = since(&mut desk, 0);
    assert!(answer.contains(r#""points":[[0,0,0.2,0],[1,1,0.2,0],"#) && answer.ends_with(r#",[99,1,0.2,1]]},"id":1}"#));
    assert_eq!(answer.matches("0.2").count(), 100);
    assert!(since(&mut desk, 98).contains(r#"{"next":100,"lost":false,"points":[[98,0,0.2,1],[99,1,0.2,1]]}"#));
    desk.site.begin_path();
    assert!(since(&mut desk, 100).contains(r#"{"next":0,"lost":true,"points":[]}"#));
    assert!(desk.call(0, r#"{"method":"velvet.path.since","id":1}"#)[0].contains("-32602"));
    desk.site.close(0, &mut desk.card);
    assert_eq!((desk.site.follows_path(), desk.site.follows_path()), (Some(false), None));
}

#[test]
fn factors_of_rapids_and_spindle_wait_for_no_line_and_that_of_feed_rates_is_one() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    let set = |desk: &mut Desk, parameters: &str| {
        desk.call(0, &format!(r#"{{"method":"velvet.override.set","params":{{{parameters}}},"id":1}}"#))
    };
    assert!(set(&mut desk, r#""rapid":0.25"#)[0].contains("ok"));
    assert!(set(&mut desk, r#""spindle":1.2,"feed":0.9"#).is_empty());
    assert_eq!(desk.site.take_factors(), Some(Factors { rapid: Some(0.25), spindle: Some(1.2) }));
    assert_eq!((desk.next_line().as_deref(), desk.site.take_factors()), (Some("M220 S90\n"), None));
    for wrong in [r#""rapid":1.5"#, r#""spindle":0"#, ""] {
        assert!(set(&mut desk, wrong)[0].contains("-32602"), "{wrong}");
    }
    desk.show(0, &Snapshot { state: State::Alarm, ..snapshot() });
    assert!(set(&mut desk, r#""rapid":0.5"#)[0].contains("400") && desk.site.take_factors().is_none());
}

#[test]
fn codes_are_told_with_their_help() {
    let mut desk = Desk::new(Role::Watch);
    desk.upgrade(0);
    let help = desk.call(0, r#"{"method":"printer.gcode.help","id":1}"#).remove(0);
    assert!(help.starts_with(r#"{"jsonrpc":"2.0","result":{"G0":"#) && help.ends_with(r#""},"id":1}"#), "{help}");
    assert!(help.contains(r#","M104":""#) && help.contains(r#","play":""#), "{help}");
}
