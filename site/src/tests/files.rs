//! Files: uploads, downloads, lists, changes.

use super::*;

/// Fields of a form, the name of its file, and the status that it is refused with.
type Refused<'f> = (&'f [(&'f str, &'f str)], &'f str, &'f str);

const BOUNDARY: &str = "----a-boundary-0123";

/// Makes a form of fields and a file.
pub(super) fn form(fields: &[(&str, &str)], name: &str, content: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    for (field, value) in fields {
        let part = format!("--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"{field}\"\r\n\r\n{value}\r\n");
        body.extend(part.bytes());
    }
    let part = format!(
        "--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"file\"; filename=\"{name}\"\r\n\
         Content-Type: application/octet-stream\r\n\r\n"
    );
    body.extend(part.bytes());
    body.extend(content);
    body.extend(format!("\r\n--{BOUNDARY}--\r\n").bytes());
    body
}

/// Makes the request that sends a form.
fn upload(body: &[u8]) -> Vec<u8> {
    request_of("", body)
}

/// Makes the request that sends a form, with more headers.
pub(super) fn request_of(headers: &str, body: &[u8]) -> Vec<u8> {
    let mut request = format!(
        "POST /server/files/upload HTTP/1.1\r\nHost: velvet.local\r\n{headers}Content-Length: {}\r\n\
         Content-Type: multipart/form-data; boundary={BOUNDARY}\r\n\r\n",
        body.len()
    )
    .into_bytes();
    request.extend(body);
    request
}

pub(super) fn content(size: usize) -> Vec<u8> {
    (0..size).map(|at| b"G1 X12.5 Y3\r\n-"[at * 7 % 14] ^ (at / 900) as u8).collect()
}

impl Desk {
    pub(super) fn put(&mut self, fields: &[(&str, &str)], name: &str, content: &[u8]) -> String {
        self.open(0);
        let answer = self.send(0, &upload(&form(fields, name, content)));
        self.site.close(0, &mut self.card);
        self.run();
        String::from_utf8(answer).expect("a text")
    }

    /// Gives the site time for what is to be done on files.
    pub(super) fn run(&mut self) {
        for _ in 0..100 {
            self.now += 1;
            self.site.run(self.now, &mut self.card);
        }
    }

    /// Calls a method. Returns the answer's message.
    pub(super) fn ask(&mut self, place: usize, method: &str, parameters: &str) -> String {
        let message = format!(r#"{{"jsonrpc":"2.0","method":"{method}","params":{{{parameters}}},"id":7}}"#);
        let mut heard = self.call(place, &message);
        self.run();
        let more = self.hear(place);
        heard.extend(messages(&more));
        heard.into_iter().find(|message| message.contains(r#""id":7"#)).expect("an answer")
    }
}

#[test]
fn a_file_comes_to_the_card_under_its_name_when_it_is_whole() {
    let mut desk = Desk::new(Role::Operate);
    for size in [0, 1, 511, 512, 513, 5_000] {
        let bytes = content(size);
        let answer = desk.put(&[("root", "gcodes"), ("path", "parts/new")], "a b.gcode", &bytes);
        assert!(answer.starts_with("HTTP/1.1 201 Created\r\n"), "{size}: {answer}");
        assert!(answer.contains(r#""path":"parts/new/a b.gcode""#) && answer.contains(&format!(r#""size":{size}"#)));
        assert_eq!(desk.card.files["/sd/parts/new/a b.gcode"], bytes, "{size}");
        assert_eq!((desk.card.files.len(), desk.card.open_files()), (1, 0), "nothing is left behind");
        let is_first = size == 0;
        assert!(answer.contains(if is_first { "create_file" } else { "modify_file" }), "{answer}");
    }
}

#[test]
fn the_checksum_is_told_and_compared() {
    // SHA-256 of "abc" (FIPS 180-4, appendix B.1 of its examples).
    const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    let mut desk = Desk::new(Role::Operate);
    let answer = desk.put(&[("checksum", &ABC.to_uppercase())], "a.g", b"abc");
    assert!(answer.contains(&format!(r#""checksum":"{ABC}""#)), "{answer}");
    let answer = desk.put(&[("checksum", ABC)], "a.g", b"abd");
    assert!(answer.starts_with("HTTP/1.1 422 ") && answer.contains("checksum"), "{answer}");
    assert_eq!(desk.card.files["/sd/a.g"], b"abc", "the old file stays");
    assert_eq!((desk.card.files.len(), desk.card.open_files()), (1, 0));
    for wrong in ["", "abc", &"g".repeat(64)] {
        assert!(desk.put(&[("checksum", wrong)], "a.g", b"abc").starts_with("HTTP/1.1 400 "), "{wrong}");
    }
}

#[test]
fn fields_come_in_any_order_and_pieces_of_any_size() {
    let bytes = content(3_000);
    let mut body = form(&[], "c.gcode", &bytes);
    body.truncate(body.len() - format!("--{BOUNDARY}--\r\n").len());
    let fields = form(&[("path", "deep/er"), ("print", "true"), ("other", "x")], "", b"");
    let fields = &fields[..fields.windows(8).position(|at| at == b"\"file\"; ").unwrap()];
    let end = fields.windows(BOUNDARY.len() + 2).rposition(|at| at == format!("--{BOUNDARY}").as_bytes()).unwrap();
    body.extend(&fields[..end]);
    body.extend(format!("--{BOUNDARY}--\r\n").bytes());
    for piece in [1, 7, 600, 1_460] {
        let mut desk = Desk::new(Role::Operate);
        desk.open(0);
        let mut heard = Vec::new();
        let mut waiting: Vec<u8> = Vec::new();
        for bytes in upload(&body).chunks(piece) {
            waiting.extend(bytes);
            loop {
                let used = desk.site.receive(0, &mut waiting, desk.now, &mut desk.card);
                waiting.drain(..used);
                if used == 0 {
                    break;
                }
            }
            assert!(waiting.len() < BUFFER, "the socket would be full");
        }
        desk.run();
        heard.extend(desk.hear(0));
        let answer = String::from_utf8(heard).unwrap();
        assert!(answer.starts_with("HTTP/1.1 201 ") && answer.contains(r#""print_started":true"#), "{piece}: {answer}");
        assert_eq!(desk.card.files["/sd/deep/er/c.gcode"], bytes, "{piece}");
        assert_eq!(desk.next_line().as_deref(), Some("play \"/sd/deep/er/c.gcode\"\n"));
    }
}

#[test]
fn what_is_refused_leaves_nothing_behind_and_says_why() {
    let cases: [Refused<'_>; 9] = [
        (&[("root", "config")], "a.g", "400 "),
        (&[("path", "../x")], "a.g", "400 "),
        (&[("path", "sub:x")], "a.g", "400 "),
        (&[], "a?.g", "400 "),
        (&[], "", "400 "),
        (&[], "config.ini", "403 "),
        (&[("path", "www")], "index.html", "403 "),
        (&[], "netpass", "404 "),
        (&[("path", &"long/".repeat(60))], "a.g", "400 "),
    ];
    for (fields, name, status) in cases {
        let mut desk = Desk::new(Role::Operate);
        let answer = desk.put(fields, name, &content(3_000));
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")) && answer.contains("message"), "{name}: {answer}");
        assert!(desk.card.files.is_empty() && desk.card.open_files() == 0, "{name}: {:?}", desk.card.files.keys());
    }
    let mut desk = Desk::new(Role::Own);
    assert!(desk.put(&[], "config.ini", b"x = 1").starts_with("HTTP/1.1 201 "), "the owner may");
    let mut desk = Desk::new(Role::Watch);
    assert!(desk.put(&[], "a.g", b"x").starts_with("HTTP/1.1 403 "));
    let mut desk = Desk::new(Role::Operate);
    desk.card.is_full = true;
    let answer = desk.put(&[], "a.g", &content(3_000));
    assert!(answer.starts_with("HTTP/1.1 507 ") && answer.contains("the SD card is full"), "{answer}");
}

#[test]
fn a_visitor_who_goes_leaves_the_old_file_and_nothing_else() {
    let request = upload(&form(&[("path", "p")], "a.gcode", &content(4_000)));
    for end in (0..request.len()).step_by(97).chain([request.len() - 1]) {
        let mut desk = Desk::new(Role::Operate);
        desk.card.directories.insert("/sd/p".into());
        desk.card.put("/sd/p/a.gcode", b"old");
        desk.open(0);
        desk.send(0, &request[..end]);
        desk.site.close(0, &mut desk.card);
        desk.run();
        assert_eq!(desk.card.files.len(), 1, "cut off at byte {end}: {:?}", desk.card.files.keys());
        assert_eq!((desk.card.text("/sd/p/a.gcode"), desk.card.open_files()), ("old", 0));
    }
}

#[test]
fn a_power_cut_leaves_the_old_file_or_the_new_one() {
    let (old, new) = (b"old".to_vec(), content(2_000));
    let request = upload(&form(&[], "a.gcode", &new));
    let mut outcomes = [0; 2];
    for writes in 0.. {
        let mut desk = Desk::new(Role::Operate);
        desk.card.put("/sd/a.gcode", &old);
        desk.card.writes_left = Some(writes);
        desk.open(0);
        desk.send(0, &request);
        desk.run();
        let is_done = desk.card.writes_left != Some(0);
        let mut after = Desk::new(Role::Operate);
        after.card = desk.card.rebooted();
        after.open(0);
        after.run();
        let files: Vec<_> = after.card.files.keys().collect();
        assert_eq!(files, ["/sd/a.gcode"], "after {writes} writes");
        let is_new = after.card.files["/sd/a.gcode"] == new;
        assert!(is_new || after.card.files["/sd/a.gcode"] == old, "after {writes} writes");
        outcomes[usize::from(is_new)] += 1;
        if is_done {
            break;
        }
    }
    assert!(outcomes[0] > 5 && outcomes[1] > 2, "{outcomes:?}");
}

#[test]
fn two_come_at_once_and_a_third_waits_for_one_to_end() {
    let mut desk = Desk::new(Role::Operate);
    let files = [content(3_000), content(2_345)];
    let requests: Vec<_> =
        files.iter().enumerate().map(|(at, bytes)| upload(&form(&[], &format!("{at}.g"), bytes))).collect();
    (0..3).for_each(|place| desk.open(place));
    let mut waiting = [Vec::new(), Vec::new()];
    for at in 0..4_000 {
        for place in 0..2 {
            waiting[place].extend(requests[place].get(at));
            let used = desk.site.receive(place, &mut waiting[place], desk.now, &mut desk.card);
            waiting[place].drain(..used);
        }
        if at == 1_500 {
            let answer = desk.send(2, &upload(&form(&[], "c.g", b"x")));
            assert!(answer.starts_with(b"HTTP/1.1 503 "), "{}", String::from_utf8_lossy(&answer));
        }
    }
    desk.run();
    for (at, bytes) in files.iter().enumerate() {
        assert!(desk.hear(at).starts_with(b"HTTP/1.1 201 "), "{at}");
        assert_eq!(desk.card.files[&format!("/sd/{at}.g")], *bytes);
    }
}

#[test]
fn files_are_sent_whole_and_in_parts() {
    let mut desk = Desk::new(Role::Watch);
    let bytes = content(5_000);
    desk.card.put("/sd/a b.gcode", &bytes);
    desk.open(0);
    let ask = |lines: &str| format!("GET /server/files/gcodes/a%20b.gcode HTTP/1.1\r\nHost: velvet\r\n{lines}\r\n");
    let answer = desk.send(0, ask("").as_bytes());
    let head = String::from_utf8_lossy(&answer[..answer.len() - bytes.len()]).into_owned();
    assert!(head.starts_with("HTTP/1.1 200 OK\r\n") && head.contains("Content-Length: 5000\r\n"), "{head}");
    assert!(head.contains("Content-Disposition: attachment\r\n") && answer.ends_with(&bytes), "{head}");
    let part = desk.send(0, ask("Range: bytes=510-1030\r\n").as_bytes());
    assert!(part.starts_with(b"HTTP/1.1 206 ") && part.ends_with(&bytes[510..=1_030]));
    let tag = head.split("ETag: ").nth(1).unwrap().split("\r\n").next().unwrap();
    let again = desk.send(0, ask(&format!("If-None-Match: {tag}\r\n")).as_bytes());
    assert!(again.starts_with(b"HTTP/1.1 304 "));
    let head = desk.send(0, ask("").replacen("GET", "HEAD", 1).as_bytes());
    assert!(head.ends_with(b"\r\n\r\n") && head.starts_with(b"HTTP/1.1 200 "));
    for (path, status) in [("none", "404"), (".velvet/x", "404"), ("netpass", "404"), ("", "404")] {
        assert!(desk.get(0, &format!("/server/files/gcodes/{path}")).starts_with(&format!("HTTP/1.1 {status} ")));
    }
    assert_eq!(desk.card.open_files(), 0);
}

#[test]
fn folders_are_listed_changed_and_told_of() {
    let mut desk = Desk::new(Role::Own);
    for path in ["/sd/a.gcode", "/sd/b.gcode", "/sd/netpass", "/sd/sub/c.gcode"] {
        desk.card.put(path, b"G1");
    }
    desk.card.directories.extend(["/sd/sub".into(), "/sd/.velvet".into()]);
    desk.upgrade(0);
    desk.upgrade(1);
    let list = desk.ask(0, "server.files.get_directory", r#""path":"gcodes""#);
    assert!(
        list.contains(r#""dirs":[{"dirname":"sub""#) && list.contains(r#""filename":"a.gcode","size":2"#),
        "{list}"
    );
    assert!(!list.contains("netpass") && !list.contains("velvet\"") && list.contains("root_info"), "{list}");
    assert_eq!((list.matches("filename").count(), list.matches("dirname").count()), (2, 1));
    assert!(desk.ask(0, "server.files.list", r#""root":"gcodes""#).contains(r#"[{"path":"a.gcode""#));
    let made = desk.ask(0, "server.files.post_directory", r#""path":"gcodes/new""#);
    assert!(made.contains(r#""item":{"root":"gcodes","path":"new"},"action":"create_dir""#), "{made}");
    let told = messages(&desk.hear(1));
    assert!(
        told.iter().any(|told| told.contains("notify_filelist_changed") && told.contains("create_dir")),
        "{told:?}"
    );
    let moved = desk.ask(0, "server.files.move", r#""dest":"gcodes/new/z.gcode","source":"gcodes/a.gcode""#);
    assert!(moved.contains(r#""path":"new/z.gcode"},"action":"move_file""#), "{moved}");
    assert!(desk.card.files.contains_key("/sd/new/z.gcode"));
    assert!(desk.ask(0, "server.files.delete_directory", r#""path":"gcodes/new""#).contains("409"));
    assert!(desk.ask(0, "server.files.delete_directory", r#""force":true,"path":"gcodes/new""#).contains("delete_dir"));
    assert!(!desk.card.files.contains_key("/sd/new/z.gcode"));
    assert!(desk.ask(0, "server.files.delete_file", r#""path":"gcodes/b.gcode""#).contains("delete_file"));
    for (method, parameters, code) in [
        ("server.files.get_directory", r#""path":"gcodes/none""#, "404"),
        ("server.files.get_directory", r#""path":"gcodes/.velvet""#, "404"),
        ("server.files.get_directory", r#""path":"config""#, "404"),
        ("server.files.delete_file", r#""path":"gcodes/none""#, "404"),
        ("server.files.delete_file", r#""path":"gcodes""#, "-32602"),
        ("server.files.move", r#""source":"gcodes/b.gcode""#, "-32602"),
        ("server.files.metadata", r#""filename":"sub""#, "404"),
    ] {
        let answer = desk.ask(0, method, parameters);
        assert!(answer.contains(&format!(r#""error":{{"code":{code}"#)), "{method} {parameters}: {answer}");
    }
    let mut guest = Desk::new(Role::Operate);
    guest.card.put("/sd/a.gcode", b"G1");
    guest.upgrade(0);
    assert!(guest.ask(0, "server.files.delete_file", r#""path":"gcodes/a.gcode""#).contains("403"));
}

#[test]
fn lists_are_told_over_http_as_well() {
    let mut desk = Desk::new(Role::Watch);
    desk.card.put("/sd/a b.gcode", b"; layer_height = 0.2\n");
    desk.open(0);
    for (path, words) in [
        ("list?root=gcodes", r#"{"result":[{"path":"a b.gcode","size":21"#),
        ("directory?path=gcodes", r#"{"result":{"dirs":[],"files":[{"filename":"a b.gcode""#),
        ("metadata?filename=a%20b.gcode", r#""layer_height":0.2"#),
        ("metadata?filename=none", r#""code":404"#),
        ("metadata", r#""code":40"#),
        ("list?root=config", r#""code":404"#),
    ] {
        let (mut heard, one) = (desk.get(0, &format!("/server/files/{path}")), desk.site.life(0, desk.now));
        desk.run();
        heard += &String::from_utf8_lossy(&desk.hear(0));
        assert!(heard.contains(words), "{path}: {heard}");
        if heard.contains("Connection: close") || one != Life::Open {
            desk.site.close(0, &mut desk.card);
            desk.open(0);
        }
    }
    assert_eq!(desk.card.open_files(), 0);
}

#[test]
fn a_folder_of_many_files_is_told_piece_by_piece() {
    let mut desk = Desk::new(Role::Watch);
    for number in 0..300 {
        desk.card.put(&format!("/sd/a file with a name {number:03}.gcode"), b"G1");
    }
    desk.upgrade(0);
    desk.room = 1_000;
    let message = r#"{"jsonrpc":"2.0","method":"server.files.get_directory","params":{"path":"gcodes"},"id":7}"#;
    let mut heard = desk.send(0, &frame(message));
    for _ in 0..100 {
        desk.run();
        heard.extend(desk.hear(0));
    }
    let told = messages(&heard).into_iter().find(|told| told.contains(r#""id":7"#)).expect("an answer");
    assert_eq!(told.matches("filename").count(), 300);
    assert!(told.contains("name 000") && told.contains("name 299"), "{told}");
}

/// A job as PrusaSlicer writes one, with pictures of these bytes.
fn sliced(pictures: &[(&str, &str, Vec<u8>)]) -> String {
    let mut text = String::from("; generated by PrusaSlicer 2.7.1+linux-x64 on 2026-01-01\n\n");
    for (kind, size, bytes) in pictures {
        let base64 = base64(bytes);
        text += &format!("; thumbnail{kind} begin {size} {}\n", base64.len());
        base64.as_bytes().chunks(78).for_each(|line| text += &format!("; {}\n", std::str::from_utf8(line).unwrap()));
        text += &format!("; thumbnail{kind} end\n;\n");
    }
    (0..6_000).for_each(|line| text += &format!("G1 X{} Y2 E0.1\n", line % 200));
    text += "; filament used [mm] = 1000.5, 234\n; estimated printing time (normal mode) = 1h 2m 3s\n";
    text + "; layer_height = 0.2\n; filament_type = PETG;PLA\n"
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |three: &[u8]| {
        let bits = (0..3).fold(0_u32, |bits, at| bits << 8 | u32::from(three.get(at).copied().unwrap_or(0)));
        (0..4)
            .map(move |at| if at <= three.len() { LETTERS[(bits >> (18 - 6 * at) & 63) as usize] as char } else { '=' })
            .collect::<String>()
    };
    bytes.chunks(3).map(group).collect()
}

#[test]
fn what_the_slicer_wrote_is_told_and_its_pictures_are_sent() {
    let pictures = [("", "16x16", content(700)), ("", "220x124", content(20_001)), ("_JPG", "64x64", content(5_000))];
    let mut desk = Desk::new(Role::Watch);
    desk.card.put("/sd/part 1.gcode", sliced(&pictures).as_bytes());
    desk.upgrade(0);
    let told = desk.ask(0, "server.files.metadata", r#""filename":"part 1.gcode""#);
    for words in [
        r#""filename":"part 1.gcode""#,
        r#""slicer":"PrusaSlicer""#,
        r#""estimated_time":3723"#,
        r#""filament_total":1234.5"#,
        r#""layer_height":0.2"#,
        r#""filament_type":"PETG""#,
        r#""width":220,"height":124"#,
        r#"".thumbs/part 1.gcode-16x16.png""#,
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    desk.open(1);
    for (kind, size, bytes) in &pictures {
        let ending = if kind.is_empty() { "png" } else { "jpg" };
        let path = format!("/server/files/gcodes/.thumbs/part%201.gcode-{size}.{ending}");
        let request = format!("GET {path} HTTP/1.1\r\nHost: velvet\r\n\r\n");
        let mut heard = desk.send(1, request.as_bytes());
        for _ in 0..20 {
            desk.run();
            heard.extend(desk.hear(1));
        }
        let (head, body) = heard.split_at(heard.windows(4).position(|at| at == b"\r\n\r\n").unwrap() + 4);
        assert!(String::from_utf8_lossy(head).contains("Content-Type: image/"), "{size}");
        assert_eq!(chunks(body), *bytes, "{size}");
    }
    let nothing = desk.get(1, "/server/files/gcodes/.thumbs/part%201.gcode-9x9.png");
    assert_eq!(nothing, "", "it is looked for");
    desk.run();
    assert!(desk.hear(1).starts_with(b"HTTP/1.1 404 "));
    assert_eq!(desk.card.open_files(), 0);
}

/// Puts the chunks of a body together.
pub(super) fn chunks(mut body: &[u8]) -> Vec<u8> {
    let mut all = Vec::new();
    loop {
        let end = body.windows(2).position(|at| at == b"\r\n").unwrap();
        let size = usize::from_str_radix(std::str::from_utf8(&body[..end]).unwrap(), 16).unwrap();
        if size == 0 {
            return all;
        }
        all.extend(&body[end + 2..end + 2 + size]);
        body = &body[end + 4 + size..];
    }
}

#[test]
fn a_page_of_the_users_own_takes_the_place_of_the_boards_which_stays_in_reach() {
    let mut desk = Desk::new(Role::Nobody);
    desk.card.put("/sd/www/index.html", b"<p>mine</p>");
    desk.card.put("/sd/www/app.js", b"1");
    desk.open(0);
    let index = desk.get(0, "/");
    assert!(index.contains("Content-Type: text/html") && index.ends_with("<p>mine</p>"), "{index}");
    assert!(desk.get(0, "/app.js").contains("Content-Type: text/javascript"));
    assert!(desk.get(0, "/?builtin").contains("Content-Encoding: gzip"));
    assert!(desk.get(0, "/none.js").starts_with("HTTP/1.1 404 "));
    assert!(desk.get(0, "/server/files/gcodes/a.g").starts_with("HTTP/1.1 401 "));
}

#[test]
fn a_stop_waits_for_no_list() {
    let mut desk = Desk::new(Role::Own);
    for number in 0..200 {
        desk.card.put(&format!("/sd/{number:03}.gcode"), b"G1");
    }
    (0..3).for_each(|place| drop(desk.upgrade(place)));
    desk.room = 100;
    let list = r#"{"jsonrpc":"2.0","method":"server.files.get_directory","params":{"path":"gcodes"},"id":7}"#;
    let mut waiting = frame(&list.replace("7}", "1}"));
    for id in ["2}", "3}", "4}"] {
        waiting.extend(frame(&list.replace("7}", id)));
    }
    waiting.extend(frame(r#"{"jsonrpc":"2.0","method":"printer.emergency_stop","id":9}"#));
    while !waiting.is_empty() {
        let used = desk.site.receive(0, &mut waiting, desk.now, &mut desk.card);
        assert!(used > 0, "the stop waits");
        waiting.drain(..used);
    }
    assert!(desk.site.take_stop().is_some());
    desk.room = 1_460;
    let mut heard = Vec::new();
    for _ in 0..50 {
        desk.run();
        heard.extend(desk.hear(0));
    }
    let told = messages(&heard);
    let answers = told.iter().filter(|told| told.matches("filename").count() == 200).count();
    let refused = told.iter().filter(|told| told.contains(r#""code":503"#)).count();
    assert_eq!((answers, refused), (3, 1), "three at a time");
    assert!(desk.ask(1, "server.files.list", r#""root":"gcodes""#).contains("199.gcode"), "there is room again");
}
