//! A whole print beside large files that come, and four who watch: the same steps as in quiet.

use virtual_prime::net_desk::peer::Connection;

use super::motion::{PATIENCE_OF_A_PRINT_MS, assert_same, distances, played};
use super::page::{OPEN, PAGE, PORT, ask_for_socket, call};
use super::uploads::{Upload, in_large_clusters, job};
use super::{Net, plan};

/// Lines of a file that comes: 5 MB, several of which come while a print goes on.
const LINES: usize = 280_000;

/// Name of the message that tells changes.
const UPDATE: &[u8] = b"notify_status_update";

/// Visitors beside the print: four who watch, and one who sends a file and has it sent back, over and over.
#[derive(Default)]
struct Visitors {
    watchers: Vec<Connection>,
    /// Messages to those who watch.
    told: usize,
    /// Time of the last look at them, ms.
    now_ms: u64,
    upload: Option<Upload>,
    download: Option<Download>,
    content: Vec<u8>,
    came_back: usize,
}

/// A file on its way back.
struct Download {
    visitor: Connection,
    request: &'static [u8],
    heard: Vec<u8>,
}

impl Visitors {
    fn disturb(&mut self, net: &mut Net, now: u64) {
        if now < 4_000 && now.is_multiple_of(1_000) {
            self.watchers.extend(net.peer.connect(PORT));
        }
        if now < 4_000
            && now % 1_000 == 500
            && let Some(&watcher) = self.watchers.last()
        {
            ask_for_socket(net, watcher, "");
        }
        if now == 5_000 {
            let objects = r#""objects":{"motion_report":null,"extruder":null,"virtual_sdcard":null,"velvet":null}"#;
            self.watchers
                .clone()
                .into_iter()
                .for_each(|watcher| call(net, watcher, "printer.objects.subscribe", objects, 1));
        }
        self.now_ms = now;
        for &watcher in &self.watchers {
            let heard = net.peer.receive(watcher);
            self.told += heard.windows(UPDATE.len()).filter(|bytes| *bytes == UPDATE).count();
        }
        if now >= 6_000 {
            self.transfer(net);
        }
    }

    fn transfer(&mut self, net: &mut Net) {
        if let Some(Download { visitor, request, heard }) = &mut self.download {
            let sent = net.peer.send(*visitor, request);
            *request = &request[sent..];
            heard.extend(net.peer.receive(*visitor));
            if heard.len() > self.content.len() && heard.ends_with(&self.content) {
                self.came_back += 1;
                net.peer.abort(*visitor);
                self.download = None;
            }
            return;
        }
        let Some(upload) = &mut self.upload else {
            self.upload = Upload::prepare(net, "", "large.gcode", &self.content);
            return;
        };
        if upload.go_on(net) {
            assert!(upload.heard().starts_with("HTTP/1.1 201 "), "{}", upload.heard());
            net.peer.close(upload.visitor());
            self.upload = None;
            let request = b"GET /server/files/gcodes/large.gcode HTTP/1.1\r\nHost: 10.0.2.15\r\n\r\n";
            self.download = net.peer.connect(PORT).map(|visitor| Download { visitor, request, heard: Vec::new() });
        }
    }
}

/// `demo/part.gcode`, or the file that VELVET_GCODE names, twice.
#[test]
#[ignore = "twice the length of a print: make net"]
fn a_print_is_stepped_alike_while_large_files_come_and_go() {
    let file = std::env::var("VELVET_GCODE")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../demo/part.gcode").into());
    let print = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{file}: {error}"));
    let homes = print.lines().any(|line| line.starts_with("G28"));
    let plan = || {
        let plan = plan(&[OPEN, PAGE]).file("job.g", &print);
        plan.with_card(|card| in_large_clusters(&card, &["config.ini", "job.g"]))
    };
    let quiet = played(plan(), PATIENCE_OF_A_PRINT_MS, |_, _| {});
    let mut visitors = Visitors { content: job(LINES), ..Visitors::default() };
    let busy = played(plan(), PATIENCE_OF_A_PRINT_MS, |net, now| visitors.disturb(net, now));
    let Visitors { told, came_back, now_ms, content, .. } = &visitors;
    println!(
        "{came_back} files of {} bytes came and went in {now_ms} ms; {told} messages to those who watch",
        content.len()
    );
    for (number, (quiet, busy)) in quiet.iter().zip(&busy).enumerate() {
        println!("motion {number}, {} edges: {}", quiet.len(), distances(quiet, busy));
    }
    // Each of four is told of changes four times a second where nothing else is on the wire.
    assert!(*came_back > 0 && *told as u64 * 1_000 > 4 * now_ms.saturating_sub(6_000), "once a second at least");
    assert_same(&quiet, &busy, homes);
}
