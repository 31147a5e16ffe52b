//! Visitors of the page's port who mean no good: heads that never end, heads too long, JSON too deep,
//! connections by the hundred. Limits hold, nobody is kept out for long, and the machine moves as ever.

use virtual_prime::net_desk::peer::Connection;

use super::motion::{JOB, PATIENCE_MS, assert_same, played};
use super::page::{OPEN, PAGE, PORT};
use super::{Net, plan};
use crate::common::velvet::SECOND;

/// Connections that the board has for pages.
const PLACES: usize = 8;
/// Time in which a head has to be there, ms (`http/src/limits.rs`), and in which a visitor that was refused
/// has to go while others wait (`net/src/streams.rs`).
const HEAD_MS: u64 = 5 * SECOND;
const GOES_MS: u64 = 500;
/// Longest time until a computer asks for a connection once more by then, ms (RFC 6298: the double each
/// time).
const ASKS_AGAIN_MS: u64 = 4 * SECOND;

/// Request of a visitor, and the beginning of the only answer that the board may give it.
struct Nonsense {
    request: Vec<u8>,
    status: &'static str,
}

fn nonsense(number: usize) -> Nonsense {
    let head = "GET / HTTP/1.1\r\nHost: 10.0.2.15\r\n";
    let (request, status) = match number % 4 {
        0 => (format!("{head}X-Long: {}\r\n\r\n", "x".repeat(5_000)), "HTTP/1.1 431 "),
        1 => {
            let body = format!("{{\"jsonrpc\":\"2.0\",\"method\":\"server.info\",\"params\":{}", "[".repeat(300));
            let head = "POST /access/login HTTP/1.1\r\nHost: 10.0.2.15\r\nContent-Type: application/json\r\n";
            (format!("{head}Content-Length: {}\r\n\r\n{body}", body.len()), "HTTP/1.1 4")
        }
        2 => (format!("{}\r\n\r\n", "\u{7F}\u{1}".repeat(300)), "HTTP/1.1 400 "),
        _ => (head.to_owned(), "HTTP/1.1 408 "),
    };
    Nonsense { request: request.into_bytes(), status }
}

/// Visitors one after the other, faster than the board has places for them.
#[derive(Default)]
struct Crowd {
    visitors: Vec<(Connection, Nonsense, Vec<u8>)>,
    came: usize,
    answered: usize,
}

impl Crowd {
    /// Most visitors at a time, and how long each one stays at the most, ms.
    const MOST: usize = 40;

    fn disturb(&mut self, net: &mut Net, _now: u64) {
        if self.visitors.len() < Self::MOST
            && let Some(visitor) = net.peer.connect(PORT)
        {
            self.visitors.push((visitor, nonsense(self.came), Vec::new()));
            self.came += 1;
        }
        for (visitor, nonsense, heard) in &mut self.visitors {
            let sent = net.peer.send(*visitor, &nonsense.request);
            nonsense.request.drain(..sent);
            heard.extend(net.peer.receive(*visitor));
        }
        // Whoever has an answer goes; of the others the first ones go without a word, at the latest.
        let is_full = self.visitors.len() == Self::MOST;
        let mut may_go = if is_full { Self::MOST / 4 } else { 0 };
        let answered = &mut self.answered;
        self.visitors.retain(|(visitor, nonsense, heard)| {
            if heard.is_empty() && may_go == 0 {
                return true;
            }
            if heard.is_empty() {
                may_go -= 1;
            } else {
                let text = String::from_utf8_lossy(heard);
                assert!(text.starts_with(nonsense.status), "{} and not {text}", nonsense.status);
                *answered += 1;
            }
            net.peer.abort(*visitor);
            net.peer.retire(*visitor);
            false
        });
    }
}

#[test]
fn a_crowd_that_talks_nonsense_leaves_every_step_where_it_is() {
    let quiet = played(plan(&[OPEN, PAGE]).file("job.g", JOB), PATIENCE_MS, |_, _| {});
    let mut crowd = Crowd::default();
    let busy = played(plan(&[OPEN, PAGE]).file("job.g", JOB), PATIENCE_MS, |net, now| crowd.disturb(net, now));
    assert_same(&quiet, &busy, false);
    assert!(crowd.came >= 1_000 && crowd.answered >= 100, "{} came, {} answered", crowd.came, crowd.answered);
}

#[test]
fn who_sends_slowly_keeps_nobody_out() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    let slow: Vec<Connection> = (0..PLACES).map(|_| net.connect(PORT)).collect();
    for letter in b"GET / HTT".chunks(1) {
        slow.iter().for_each(|visitor| net.send(*visitor, letter));
        net.run(100);
    }
    let (visitor, began) = (net.peer.connect(PORT).expect("an address"), net.velvet.now_ms());
    while !net.peer.is_connected(visitor) {
        let waits = net.velvet.now_ms() - began;
        assert!(waits < HEAD_MS + GOES_MS + ASKS_AGAIN_MS, "slow visitors keep all places");
        for slow in &slow {
            let _gone = net.peer.send(*slow, b"P");
        }
        net.run(50);
    }
    net.send(visitor, b"GET /server/info HTTP/1.1\r\nHost: 10.0.2.15\r\nConnection: close\r\n\r\n");
    net.expect(visitor, "HTTP/1.1 200 OK", 2 * SECOND);
    // Each was told, and let go.
    net.run(HEAD_MS);
    for slow in slow {
        let heard = String::from_utf8_lossy(&net.peer.receive(slow)).into_owned();
        assert!(heard.starts_with("HTTP/1.1 408 ") && !net.peer.is_connected(slow), "{heard}");
    }
}
