//! State that others have made: temperatures and lines from before, the mesh, changes of files.

use base::bed::MeshName;
use base::snapshot::MeshShown;
use units::MOST_SIDE;

use super::*;

fn mesh(count: [u8; 2], number: u32) -> Snapshot {
    let name = MeshName::read("cold").unwrap();
    let mesh = MeshShown { name, ends: [[15.0, 20.0], [205.0, 190.5]], count, number };
    Snapshot { mesh: Some(mesh), ..snapshot() }
}

/// Takes `{"status":{"bed_mesh":` off a message's object.
fn object(message: &str) -> &str {
    let at = message.find(r#""bed_mesh":"#).expect("a mesh");
    message[at + 11..].split(r#"]]}"#).next().unwrap()
}

#[test]
fn a_mesh_is_told_row_by_row_whatever_room_there_is() {
    for room in [1_000, 1_460, 20_000] {
        let mut desk = Desk::new(Role::Watch);
        desk.room = room;
        desk.upgrade(0);
        let ask = r#"{"method":"printer.objects.subscribe","params":{"objects":{"bed_mesh":null}},"id":1}"#;
        let none =
            r#""bed_mesh":{"profile_name":"","mesh_min":[0,0],"mesh_max":[0,0],"probed_matrix":[],"mesh_matrix":[]}"#;
        let answer = desk.call(0, ask);
        assert!(answer[0].contains(none), "{answer:?}");
        let state = mesh([3, 2], 7);
        assert!(desk.site.wants_heights(7));
        desk.site.show_heights(7, 0, &[0.1, -0.25, 0.0]);
        desk.site.show_heights(7, 1, &[1.0004, -2.5, 0.0126]);
        assert!(!desk.site.wants_heights(7) && desk.site.wants_heights(8));
        let told = desk.show(0, &state);
        let matrix = "[[0.1,-0.25,0],[1,-2.5,0.013";
        let all = format!(
            r#"{{"profile_name":"cold","mesh_min":[15,20],"mesh_max":[205,190.5],"probed_matrix":{matrix}]],"mesh_matrix":{matrix}"#
        );
        assert_eq!(object(&told[0]), all);
        assert_eq!(desk.show(0, &state), Vec::<String>::new(), "it has not changed");
        // The greatest there is.
        (0..MOST_SIDE).for_each(|row| desk.site.show_heights(8, row, &[-12.345; MOST_SIDE]));
        let told = desk.show(0, &mesh([MOST_SIDE as u8; 2], 8));
        assert_eq!(told[0].matches("-12.345").count(), 2 * MOST_SIDE * MOST_SIDE);
        assert!(told[0].ends_with("]]}},1.75]}"), "{}", &told[0][told[0].len() - 40..]);
    }
}

#[test]
fn a_mesh_whose_heights_have_yet_to_come_is_an_object_all_the_same() {
    let mut desk = Desk::new(Role::Watch);
    desk.site.show(&mesh([9, 9], 3), desk.now);
    desk.open(0);
    let answer = desk.get(0, "/printer/objects/query?bed_mesh");
    assert!(answer.contains(r#""probed_matrix":[],"mesh_matrix":[]}}}}"#), "{answer}");
}

/// Returns the numbers of a list of the answer.
fn list(answer: &str, name: &str, of: &str) -> Vec<f64> {
    let heater = answer.split(&format!(r#""{name}":"#)).nth(1).expect("the heater");
    let list = heater.split(&format!(r#""{of}":["#)).nth(1).expect("the list").split(']').next().unwrap();
    list.split(',').filter(|number| !number.is_empty()).map(|number| number.parse().unwrap_or(f64::NAN)).collect()
}

#[test]
fn temperatures_of_ten_minutes_are_told_one_a_second() {
    let mut desk = Desk::new(Role::Watch);
    let mut state = snapshot();
    state.heaters[2].heats = false;
    state.heaters[2].reading = None;
    for step in 0..400_u32 {
        assert!(desk.site.wants_snapshot(desk.now + 5_000), "also while nobody looks");
        desk.now += 1_000;
        state.heaters[0].reading = Some(Celsius(20.0 + step as f32));
        state.heaters[0].target = Celsius(if step < 350 { 0.0 } else { 200.5 });
        desk.site.show(&state, desk.now);
    }
    assert!(!desk.site.wants_snapshot(desk.now), "nobody looks, and no sample is due");
    desk.upgrade(0);
    let answer = desk.call(0, r#"{"method":"server.temperature_store","id":1}"#).remove(0);
    let (heats, targets) = (list(&answer, "extruder", "temperatures"), list(&answer, "extruder", "targets"));
    assert_eq!((heats.len(), targets.len()), (405, 405), "a sample each 5 s, and the one before");
    assert!(heats.windows(2).all(|pair| pair[0] <= pair[1]) && *heats.last().unwrap() >= 415.0, "{heats:?}");
    assert!(targets[..350].iter().all(|target| *target == 0.0) && targets[404] == 200.5, "{targets:?}");
    let chamber = list(&answer, "temperature_sensor chamber", "temperatures");
    assert!(chamber.len() == 405 && chamber[5..].iter().all(|none| none.is_nan()), "{chamber:?}");
    assert!(answer.ends_with(r#"]}},"id":1}"#), "no targets of a sensor: {}", &answer[answer.len() - 60..]);
    desk.open(1);
    let same = desk.get_whole(1, "/server/temperature_store");
    let told = answer.strip_prefix(r#"{"jsonrpc":"2.0","#).and_then(|rest| rest.strip_suffix(r#","id":1}"#));
    assert_eq!(same.strip_prefix('{').and_then(|rest| rest.strip_suffix('}')), told, "as over the WebSocket");
    for _ in 0..1_000 {
        desk.now += 1_000;
        desk.site.show(&state, desk.now);
    }
    let answer = desk.call(0, r#"{"method":"server.temperature_store","id":1}"#);
    assert_eq!(list(&answer[0], "heater_bed", "targets").len(), 600);
}

#[test]
fn lines_from_before_are_told_to_who_comes() {
    let mut desk = Desk::new(Role::Operate);
    desk.upgrade(0);
    desk.call(0, r#"{"method":"printer.gcode.script","params":{"script":"M115"}}"#);
    assert_eq!(desk.next_line().as_deref(), Some("M115\n"));
    desk.say(b"FIRMWARE_NAME:\"Velvet\"\nok\n\x06");
    desk.now += 9_500;
    desk.say(b"\x07ALARM: it is hot\n");
    desk.upgrade(1);
    let told = desk.call(1, r#"{"method":"server.gcode_store","params":{"count":9},"id":2}"#);
    let lines = r#""gcode_store":[{"message":"M115","time":1,"type":"command"},{"message":"FIRMWARE_NAME:\"Velvet\"","time":1,"type":"response"},{"message":"!! ALARM: it is hot","time":10,"type":"response"}]},"id":2}"#;
    assert_eq!(told, [format!(r#"{{"jsonrpc":"2.0","result":{{"eventtime":10.5,{lines}"#)]);
    let told = desk.call(1, r#"{"method":"server.gcode_store","params":{"count":1},"id":3}"#);
    assert!(told[0].contains(r#""gcode_store":[{"message":"!! ALARM"#), "{told:?}");
    desk.open(2);
    let list = desk.get_whole(2, "/server/gcode_store");
    assert_eq!(list, format!(r#"{{"result":{{"eventtime":10.5,{}}}"#, lines.replace(r#","id":2}"#, "")));
    assert!(desk.get_whole(2, "/server/gcode_store?count=1").contains(r#""gcode_store":[{"message":"!! ALARM"#));
    let wrong = desk.get(2, "/server/gcode_store?count=many");
    assert!(wrong.starts_with("HTTP/1.1 400 ") && wrong.contains("count is a number of lines"), "{wrong}");
    // All of what is kept, by rooms of one line and of many.
    (0..300).for_each(|number| desk.say(format!("line {number}\n").as_bytes()));
    let answers = [1_000, 1_460, 9_000].map(|room| {
        desk.room = room;
        desk.call(1, r#"{"method":"server.gcode_store","id":4}"#)
            .into_iter()
            .find(|told| told.contains(r#""id":4"#))
            .unwrap()
    });
    assert!(answers[0] == answers[1]);
    assert!(
        answers[0].matches("message").count() > 200
            && answers[0] == answers[2]
            && answers[0].ends_with(r#""line 299","time":10,"type":"response"}]},"id":4}"#),
        "{}",
        answers[0]
    );
}

#[test]
fn messages_from_before_are_told_whatever_was_answered_since() {
    let mut desk = Desk::new(Role::Operate);
    desk.say(b"// network: 10.0.0.9\nWARNING: fan has no tachometer\n");
    desk.now += 60_000;
    desk.say(b"\x07ALARM: Hard limit -X was hit (minx)\n");
    (0..300).for_each(|number| desk.say(format!("line {number}\n").as_bytes()));
    desk.upgrade(0);
    let ask =
        r#"{"method":"printer.objects.subscribe","params":{"objects":{"velvet":null,"velvet_messages":null}},"id":1}"#;
    let told = desk.call(0, ask);
    let limit = "Release the machine, move the axis away from its switch, and home it.";
    let all = format!(
        r#""messages":[{{"time":1,"level":"info","text":"network: 10.0.0.9","remedy":""}},{{"time":1,"level":"warning","text":"fan has no tachometer","remedy":""}},{{"time":61,"level":"error","text":"ALARM: Hard limit -X was hit (minx)","remedy":"{limit}"}}]}}}}}},"id":1}}"#
    );
    assert!(told[0].ends_with(&all), "{told:?}");
    desk.show(0, &snapshot());
    // An answer to one visitor is none; a refusal of what everybody hears is one, and comes by itself.
    desk.call(0, r#"{"method":"velvet.ask","params":{"script":"x"},"id":2}"#);
    desk.next_line();
    desk.say(b"error:unknown\n\x15");
    let told = desk.show(0, &snapshot());
    assert!(!told.iter().any(|told| told.contains("status_update")), "{told:?}");
    (0..5).for_each(|number| desk.say(format!("error:line {number}\n").as_bytes()));
    let told = desk.show(0, &snapshot());
    let update = told.iter().find(|told| told.contains("status_update")).expect("more messages");
    assert!(
        update.contains(r#""params":[{"velvet_messages":{"messages":[{"time":61,"level":"error","text":"line 0","#)
            && update.contains(r#""text":"line 4","remedy":""}]"#),
        "{update}"
    );
    assert!(!update.contains("tachometer") && update.matches(r#""level":"error""#).count() == 5, "{update}");
}

#[test]
fn what_others_change_is_told_once_in_a_while_and_own_changes_once() {
    let mut desk = Desk::new(Role::Own);
    desk.card.put("/sd/a.g", b"x");
    desk.upgrade(0);
    desk.now += 10_000;
    desk.run();
    desk.hear(0);
    let told = |desk: &mut Desk| {
        desk.run();
        let heard = desk.hear(0);
        messages(&heard).into_iter().filter(|message| message.contains("filelist_changed")).collect::<Vec<_>>()
    };
    assert_eq!(told(&mut desk), Vec::<String>::new());
    // Another console removes a file, and makes two folders.
    desk.card.remove("/sd/a.g").unwrap();
    let others = r#"{"jsonrpc":"2.0","method":"notify_filelist_changed","params":[{"action":"root_update","item":{"root":"gcodes","path":""}}]}"#;
    assert_eq!(told(&mut desk), [others]);
    desk.card.make_directory("/sd/b").unwrap();
    desk.card.make_directory("/sd/c").unwrap();
    assert_eq!(told(&mut desk), Vec::<String>::new(), "not yet");
    desk.now += 2_000;
    assert_eq!(told(&mut desk), [others]);
    desk.now += 2_000;
    let answer = desk.ask(0, "server.files.post_directory", r#""path":"gcodes/d""#);
    assert!(answer.contains("create_dir"), "{answer}");
    assert_eq!(told(&mut desk), Vec::<String>::new(), "the visitor's own was told by its own words");
}
