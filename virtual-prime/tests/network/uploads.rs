//! Files over the network on the real image: uploads, downloads, lists; cables that go out in the middle.

use std::io::{Cursor, Write as _};

use virtual_prime::net_desk::peer::Connection;
use virtual_prime::sd_image;

use super::page::{OPEN, PAGE, PORT, call, socket};
use super::{Net, plan};
use crate::common::velvet::SECOND;

const BOUNDARY: &str = "----WebKitFormBoundary0123456789abcdef";
/// Bytes that are handed to the computer's socket at a time.
const PIECE: usize = 16_384;
/// Longest time of a request, ms.
const PATIENCE: u64 = 60 * SECOND;

/// An upload on its way.
pub(super) struct Upload {
    visitor: Connection,
    request: Vec<u8>,
    sent: usize,
    heard: Vec<u8>,
}

impl Upload {
    fn begin(net: &mut Net, path: &str, name: &str, content: &[u8]) -> Self {
        Self::over(net.connect(PORT), path, name, content)
    }

    /// Begins on a connection that is being made.
    pub(super) fn prepare(net: &mut Net, path: &str, name: &str, content: &[u8]) -> Option<Self> {
        net.peer.connect(PORT).map(|visitor| Self::over(visitor, path, name, content))
    }

    fn over(visitor: Connection, path: &str, name: &str, content: &[u8]) -> Self {
        let part = |field: &str| format!("--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"{field}\"");
        let mut body = format!("{}\r\n\r\ngcodes\r\n{}\r\n\r\n{path}\r\n", part("root"), part("path")).into_bytes();
        body.extend(format!("{}; filename=\"{name}\"\r\n\r\n", part("file")).bytes());
        body.extend(content);
        body.extend(format!("\r\n--{BOUNDARY}--\r\n").bytes());
        let mut request = format!(
            "POST /server/files/upload HTTP/1.1\r\nHost: 10.0.2.15\r\nContent-Length: {}\r\n\
             Content-Type: multipart/form-data; boundary={BOUNDARY}\r\n\r\n",
            body.len()
        )
        .into_bytes();
        request.extend(body);
        Self { visitor, request, sent: 0, heard: Vec::new() }
    }

    /// Sends as much as there is room for, and hears. True when the answer is whole.
    pub(super) fn go_on(&mut self, net: &mut Net) -> bool {
        let rest = &self.request[self.sent..];
        self.sent += net.peer.send(self.visitor, &rest[..rest.len().min(PIECE)]);
        self.heard.extend(net.peer.receive(self.visitor));
        String::from_utf8_lossy(&self.heard).trim_end().ends_with(['}', '0'])
    }

    pub(super) fn visitor(&self) -> Connection {
        self.visitor
    }

    pub(super) fn heard(&self) -> String {
        String::from_utf8_lossy(&self.heard).into_owned()
    }

    /// Sends all of it. Returns the answer.
    fn finish(mut self, net: &mut Net) -> String {
        let end = net.velvet.now_ms() + PATIENCE;
        while !self.go_on(net) {
            assert!(net.velvet.now_ms() < end, "no answer: {}", String::from_utf8_lossy(&self.heard));
            net.run(1);
        }
        net.peer.close(self.visitor);
        self.heard()
    }
}

/// Puts a file on the card. Returns the answer.
fn put(net: &mut Net, path: &str, name: &str, content: &[u8]) -> String {
    Upload::begin(net, path, name, content).finish(net)
}

/// Asks for a path. Returns the head of the answer, and its body.
fn ask(net: &mut Net, request: &str) -> (String, Vec<u8>) {
    let visitor = net.connect(PORT);
    net.send(visitor, format!("{request}Host: 10.0.2.15\r\nConnection: close\r\n\r\n").as_bytes());
    let (mut heard, end) = (Vec::new(), net.velvet.now_ms() + PATIENCE);
    while !net.peer.is_over(visitor) {
        assert!(net.velvet.now_ms() < end, "no end: {}", String::from_utf8_lossy(&heard));
        net.run(2);
        heard.extend(net.peer.receive(visitor));
        if net.peer.has_ended(visitor) {
            net.peer.close(visitor);
        }
    }
    let end = heard.windows(4).position(|at| at == b"\r\n\r\n").map_or(heard.len(), |at| at + 4);
    let body = heard.split_off(end);
    (String::from_utf8(heard).expect("a head"), body)
}

fn download(net: &mut Net, path: &str) -> Vec<u8> {
    let (head, body) = ask(net, &format!("GET /server/files/gcodes/{path} HTTP/1.1\r\n"));
    assert!(head.starts_with("HTTP/1.1 200 "), "{head}");
    body
}

/// The card's files on a volume with clusters of 8 kB, as cards of a few gigabytes have them: with those of
/// one block, most of what is written is tables.
pub(super) fn in_large_clusters(card: &[u8], names: &[&str]) -> Vec<u8> {
    let mut image = Cursor::new(vec![0; 64 << 20]);
    let options = fatfs::FormatVolumeOptions::new().fat_type(fatfs::FatType::Fat16).bytes_per_cluster(8_192);
    fatfs::format_volume(&mut image, options).expect("a volume");
    let volume = fatfs::FileSystem::new(&mut image, fatfs::FsOptions::new()).expect("a volume");
    for name in names {
        let content = sd_image::read(card, name).expect("a file");
        volume.root_dir().create_file(name).and_then(|mut file| file.write_all(&content)).expect("room");
    }
    volume.unmount().expect("a volume");
    image.into_inner()
}

/// A job of so many lines, with ends of lines as Windows has them.
pub(super) fn job(lines: usize) -> Vec<u8> {
    (0..lines)
        .flat_map(|line| format!("G1 X{} Y{} E0.0{}\r\n", line % 200, line / 200, line % 9).into_bytes())
        .collect()
}

#[test]
fn a_file_comes_to_the_card_and_back() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    let (mut content, picture) = (job(3_000), "QUJDREVGRw==");
    let comments = format!("; generated by Slicer 1\n; thumbnail begin 32x32 12\n; {picture}\n; thumbnail end\n");
    content.splice(0..0, comments.bytes());
    let began = net.velvet.now_ms();
    let answer = put(&mut net, "new folder", "a job.gcode", &content);
    let took = net.velvet.now_ms() - began;
    println!("{} bytes in {took} ms: {} kB/s", content.len(), content.len() as u64 / took);
    assert!(answer.starts_with("HTTP/1.1 201 ") && answer.contains(r#""path":"new folder/a job.gcode""#), "{answer}");
    assert!(download(&mut net, "new%20folder/a%20job.gcode") == content, "it comes back as it went");
    let (head, part) =
        ask(&mut net, "GET /server/files/gcodes/new%20folder/a%20job.gcode HTTP/1.1\r\nRange: bytes=9-99\r\n");
    assert!(head.starts_with("HTTP/1.1 206 ") && part == content[9..=99], "{head}");
    let (head, body) =
        ask(&mut net, "GET /server/files/gcodes/new%20folder/.thumbs/a%20job.gcode-32x32.png HTTP/1.1\r\n");
    assert!(head.contains("image/png") && body.starts_with(b"007\r\nABCDEFG\r\n"), "{head}{body:?}");
    let visitor = socket(&mut net);
    call(&mut net, visitor, "server.files.get_directory", r#""path":"gcodes""#, 1);
    let told = net.expect(visitor, r#""id":1}"#, 5 * SECOND);
    assert!(told.contains(r#""dirname":"new folder""#) && told.contains(r#""filename":"config.ini""#), "{told}");
    call(&mut net, visitor, "server.files.metadata", r#""filename":"new folder/a job.gcode""#, 2);
    let told = net.expect(visitor, r#""id":2}"#, 5 * SECOND);
    assert!(told.contains(r#""slicer":"Slicer""#) && told.contains(r#""width":32"#), "{told}");
    // What others change is told, and the card is counted by now.
    put(&mut net, "", "another.gcode", b"G28\n");
    net.expect(visitor, "notify_filelist_changed", 2 * SECOND);
    net.run(2 * SECOND);
    call(&mut net, visitor, "server.files.get_directory", r#""path":"gcodes/new folder""#, 3);
    net.expect(visitor, r#""id":3}"#, 5 * SECOND);
    net.run(2 * SECOND);
    call(&mut net, visitor, "server.files.get_directory", r#""path":"gcodes/new folder""#, 4);
    let told = net.expect(visitor, r#""id":4}"#, 5 * SECOND);
    assert!(told.contains(r#""disk_usage":{"total":"#), "{told}");
    let said = net.ask("ls -1 /sd/.velvet");
    assert!(!said.contains("upload"), "{said}");
}

#[test]
fn a_file_comes_with_a_megabyte_a_second() {
    let plan = plan(&[OPEN, PAGE]).with_card(|card| in_large_clusters(&card, &["config.ini"]));
    let mut net = Net::with_address(plan);
    let content = job(20_000);
    let began = net.velvet.now_ms();
    let answer = put(&mut net, "", "a.gcode", &content);
    let took = net.velvet.now_ms() - began;
    println!("{} bytes in {took} ms: {} kB/s", content.len(), content.len() as u64 / took);
    assert!(answer.starts_with("HTTP/1.1 201 "), "{answer}");
    let began = net.velvet.now_ms();
    assert!(download(&mut net, "a.gcode") == content);
    println!("and back in {} ms", net.velvet.now_ms() - began);
    assert!(content.len() as u64 / took >= 1_000, "a megabyte a second");
}

#[test]
fn what_is_not_taken_is_refused_with_the_reason() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    for (path, name, words) in [
        ("", "config.ini", "the machine's owner"),
        ("", "a?.gcode", "no file can have this name"),
        (".velvet", "a.gcode", "there is no such file"),
        ("config.ini", "a.gcode", ""),
    ] {
        let answer = put(&mut net, path, name, b"G28\n");
        assert!(answer.starts_with("HTTP/1.1 4") && answer.contains(words), "{path}/{name}: {answer}");
    }
    let (head, _) = ask(&mut net, "DELETE /server/files/gcodes/config.ini HTTP/1.1\r\n");
    assert!(head.starts_with("HTTP/1.1 403 "), "{head}");
    let (head, _) = ask(&mut net, "GET /server/files/gcodes/none.gcode HTTP/1.1\r\n");
    assert!(head.starts_with("HTTP/1.1 404 "), "{head}");
    assert!(net.ask("ls").contains("config.ini"));
}

/// Has the cable out so many times, each time at another moment of an upload.
fn pull_out(times: u64) {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    let (old, new) = (job(200), job(4_000));
    put(&mut net, "", "part.gcode", &old);
    for turn in 0..times {
        let mut upload = Upload::begin(&mut net, "", "part.gcode", &new);
        for _ in 0..1 + 7 * turn % 50 {
            assert!(!upload.go_on(&mut net), "the cable is out too late for this test");
            net.run(1);
        }
        net.peer.unplug(&mut net.velvet.bench.vm);
        net.run(200);
        net.peer.plug(&mut net.velvet.bench.vm);
        net.hear_until("// network: 10.0.2.15 (from DHCP)", 15 * SECOND);
        net.peer.forget(upload.visitor);
        net.run(100);
        assert!(download(&mut net, "part.gcode") == old, "turn {turn}");
    }
    assert!(put(&mut net, "", "part.gcode", &new).contains("modify_file"));
    assert!(download(&mut net, "part.gcode") == new);
}

#[test]
fn a_cable_that_goes_out_leaves_the_old_file() {
    pull_out(2);
}

#[test]
#[ignore = "some minutes: make net"]
fn it_does_so_at_any_moment() {
    pull_out(50);
}

/// Megabytes of the long upload, or those that VELVET_MEGABYTES says.
const MEGABYTES: usize = 20;

#[test]
#[ignore = "twenty megabytes: make net"]
fn a_large_file_comes_while_a_print_is_watched() {
    let megabytes = std::env::var("VELVET_MEGABYTES").map_or(MEGABYTES, |text| text.parse().expect("a number"));
    let print = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../demo/part.gcode")).expect("a print");
    let plan = plan(&[OPEN, PAGE]).file("print.g", &print);
    let mut net = Net::with_address(plan.with_card(|card| in_large_clusters(&card, &["config.ini", "print.g"])));
    let watchers: Vec<_> = (0..4).map(|_| socket(&mut net)).collect();
    for (id, watcher) in watchers.iter().enumerate() {
        let objects = r#""objects":{"motion_report":null,"extruder":null,"virtual_sdcard":null,"velvet":null}"#;
        call(&mut net, *watcher, "printer.objects.subscribe", objects, id as u32);
    }
    net.ask("M23 print.g");
    net.velvet.type_in("M24");
    let lines = megabytes * 1_000_000 / 18;
    let content = job(lines);
    let began = net.velvet.now_ms();
    let mut upload = Upload::begin(&mut net, "", "large.gcode", &content);
    let mut told = 0;
    while !upload.go_on(&mut net) {
        net.run(1);
        told += watchers.iter().map(|watcher| net.peer.receive(*watcher).len()).sum::<usize>();
    }
    let took = net.velvet.now_ms() - began;
    let answer = upload.heard();
    println!(
        "{} bytes in {took} ms: {} kB/s; {told} bytes to those who watch",
        content.len(),
        content.len() as u64 / took
    );
    assert!(answer.starts_with("HTTP/1.1 201 "), "{answer}");
    assert!(told > 1_000, "nobody was told anything");
    let said = net.ask("get steps");
    assert!(said.contains("late: 0 (") && said.contains("delayed: 0\n"), "{said}");
    assert!(net.ask("progress").contains("complete"), "it prints");
    assert!(download(&mut net, "large.gcode") == content);
    assert!(content.len() as u64 / took >= 1_000, "a megabyte a second");
}

#[test]
fn two_files_come_while_a_job_is_played() {
    let lines = "G1 X20 F6000\nG1 X10\n".repeat(60);
    let text = format!("G28.3 X10 Y10 Z10\n{lines}");
    let mut net = Net::with_address(plan(&[OPEN, PAGE]).file("job.g", &text));
    net.ask("M23 job.g");
    net.velvet.type_in("M24");
    let contents = [job(3_000), job(2_500)];
    let mut both: Vec<_> = contents
        .iter()
        .zip(["one.gcode", "two.gcode"])
        .map(|(bytes, name)| Upload::begin(&mut net, "", name, bytes))
        .collect();
    let end = net.velvet.now_ms() + PATIENCE;
    let mut is_done = [false; 2];
    while is_done != [true; 2] {
        assert!(net.velvet.now_ms() < end, "{is_done:?}");
        for (upload, is_done) in both.iter_mut().zip(&mut is_done) {
            *is_done |= upload.go_on(&mut net);
        }
        net.run(1);
    }
    // The file that is played cannot be replaced.
    let answer = put(&mut net, "", "job.g", b"G28\n");
    assert!(answer.starts_with("HTTP/1.1 409 ") && answer.contains("the file is in use"), "{answer}");
    net.hear_until("Done printing file", 60 * SECOND);
    let said = net.ask("get steps");
    assert!(said.contains("late: 0 (") && said.contains("delayed: 0\n"), "{said}");
    for (bytes, name) in contents.iter().zip(["one.gcode", "two.gcode"]) {
        assert!(download(&mut net, name) == *bytes, "{name}");
    }
}
