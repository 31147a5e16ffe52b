use std::io::{Read, Write};
use std::net::TcpStream;

use super::*;
use crate::mock::{Mock, pass};

const MS: u64 = 1_000_000;
/// Greatest number of looks at the system's sockets in a wait.
const PATIENCE: u32 = 100_000;

struct Bench {
    remote: Remote,
    controller: Controller,
    device: Mock,
    now_ns: u64,
}

impl Bench {
    fn new() -> Self {
        let any = SocketAddr::from(([127, 0, 0, 1], 0));
        let remote = Remote::listen(any, any).expect("two ports");
        Self { remote, controller: Controller::default(), device: Mock::connected(), now_ns: 0 }
    }

    fn connect(&self, place: usize) -> TcpStream {
        let stream = TcpStream::connect(self.remote.addresses().unwrap()[place]).expect("it listens");
        stream.set_nonblocking(true).unwrap();
        stream
    }

    /// Waits a little, and panics after too many looks.
    fn wait(&mut self, looks: &mut u32) {
        *looks += 1;
        assert!(*looks < PATIENCE, "nothing comes");
        std::thread::sleep(std::time::Duration::from_micros(20));
        self.pass_ms(1);
    }

    fn pass_ms(&mut self, ms: u64) {
        for _ in 0..ms {
            pass(&mut self.controller, &mut self.device, &mut self.now_ns, MS);
            self.remote.serve(self.now_ns, &mut self.controller, &mut self.device);
        }
    }

    /// Waits for so many bytes.
    fn hear(&mut self, from: &mut TcpStream, count: usize) -> Vec<u8> {
        let mut all = Vec::new();
        let (mut byte, mut looks) = ([0], 0);
        while all.len() < count {
            match from.read(&mut byte) {
                Ok(0) => panic!("closed after {all:02x?}"),
                Ok(_) => all.push(byte[0]),
                Err(_) => self.wait(&mut looks),
            }
        }
        all
    }

    /// Waits until the connection is closed.
    fn wait_for_close(&mut self, of: &mut TcpStream) {
        let (mut bytes, mut looks) = ([0; 1024], 0);
        // If the connection closes with unread bytes, the system reports a reset.
        let closed = |read: io::Result<usize>| match read {
            Ok(count) => count == 0,
            Err(error) => error.kind() != io::ErrorKind::WouldBlock,
        };
        while !closed(of.read(&mut bytes)) {
            self.wait(&mut looks);
        }
    }

    fn notes(&mut self) -> String {
        self.remote.take_notes().join("\n")
    }

    /// Waits until the cable is in or out.
    fn wait_for_cable(&mut self, plugged: bool) {
        let mut looks = 0;
        while self.remote.is_plugged() != plugged {
            self.wait(&mut looks);
        }
    }
}

/// Encodes HELLO of a peer with QEMU's capabilities.
fn hello() -> Vec<u8> {
    let mut bytes = [0_u32, 68, 0].map(u32::to_le_bytes).concat();
    bytes.resize(12 + 64, 0);
    bytes.extend(0xFF_u32.to_le_bytes());
    bytes
}

const HELLO_BYTES: usize = 80;
/// Length of the announcement: interfaces, endpoints and connection, with their heads.
const ANNOUNCEMENT_BYTES: usize = 16 + 132 + 16 + 160 + 16 + 10;
const LIST: [u8; 8] = [1, 0x11, 0x80, 5, 0, 0, 0, 0];

fn import() -> Vec<u8> {
    let mut bytes = vec![1, 0x11, 0x80, 3, 0, 0, 0, 0, b'1', b'-', b'1'];
    bytes.resize(40, 0);
    bytes
}

#[test]
fn a_connection_is_the_cable() {
    let mut bench = Bench::new();
    for _ in 0..3 {
        let mut peer = bench.connect(0);
        bench.hear(&mut peer, HELLO_BYTES);
        assert!(!bench.remote.is_plugged(), "it has said nothing");
        peer.write_all(&hello()).unwrap();
        let told = bench.hear(&mut peer, ANNOUNCEMENT_BYTES);
        assert_eq!(told[told.len() - 6..], [0x50, 0x1D, 0x15, 0x60, 2, 1]);
        assert!(bench.notes().contains("plugs in\nUSB: device 1d50:6015 is there"));
        drop(peer);
        bench.wait_for_cable(false);
        assert!(bench.notes().contains("has unplugged"));
    }
}

#[test]
fn a_second_peer_is_turned_away_and_the_first_goes_on() {
    let mut bench = Bench::new();
    let mut first = bench.connect(0);
    first.write_all(&hello()).unwrap();
    bench.hear(&mut first, HELLO_BYTES + ANNOUNCEMENT_BYTES);
    let mut second = bench.connect(0);
    bench.wait_for_close(&mut second);
    let mut client = bench.connect(1);
    client.write_all(&import()).unwrap();
    assert_eq!(bench.hear(&mut client, 8)[7], 2, "usbip: busy");
    bench.wait_for_close(&mut client);
    // Message GET_CONFIGURATION with identifier 9.
    first.write_all(&[7, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0]).unwrap();
    assert_eq!(bench.hear(&mut first, 18), [8, 0, 0, 0, 2, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn a_peer_that_comes_at_once_finds_a_device_that_was_plugged_in_afresh() {
    let mut bench = Bench::new();
    let mut first = bench.connect(0);
    first.write_all(&hello()).unwrap();
    bench.hear(&mut first, HELLO_BYTES + ANNOUNCEMENT_BYTES);
    // Message SET_CONFIGURATION, which selects configuration 1.
    first.write_all(&[6, 0, 0, 0, 1, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 1]).unwrap();
    let mut looks = 0;
    while bench.device.configuration == 0 {
        bench.wait(&mut looks);
    }
    let mut second = bench.connect(0);
    second.write_all(&hello()).unwrap();
    drop(first);
    bench.hear(&mut second, HELLO_BYTES + ANNOUNCEMENT_BYTES);
    assert_eq!((bench.device.resets, bench.device.configuration), (2, 0));
}

#[test]
fn a_client_asks_then_imports_and_has_the_cable_until_it_closes() {
    let mut bench = Bench::new();
    let mut asking = bench.connect(1);
    asking.write_all(&LIST).unwrap();
    assert_eq!(bench.hear(&mut asking, 12 + 312 + 8)[11], 1);
    drop(asking);
    bench.wait_for_cable(false);
    let mut client = bench.connect(1);
    client.write_all(&import()).unwrap();
    assert_eq!(bench.hear(&mut client, 320)[..8], [1, 0x11, 0, 3, 0, 0, 0, 0]);
    let mut other = bench.connect(1);
    other.write_all(&LIST).unwrap();
    assert_eq!(bench.hear(&mut other, 12)[11], 0, "it is in use");
    let mut peer = bench.connect(0);
    peer.write_all(&hello()).unwrap();
    bench.hear(&mut peer, HELLO_BYTES);
    bench.pass_ms(300);
    assert_eq!(bench.device.resets, 2, "the peer waits");
    drop(client);
    bench.hear(&mut peer, ANNOUNCEMENT_BYTES);
    assert_eq!(bench.device.resets, 3);
}

#[test]
fn a_client_loses_its_connection_with_the_device() {
    let mut bench = Bench::new();
    let mut client = bench.connect(1);
    client.write_all(&import()).unwrap();
    bench.hear(&mut client, 320);
    bench.device.connected = false;
    bench.wait_for_close(&mut client);
    bench.wait_for_cable(false);
    assert!(bench.notes().contains("has to attach again"));
}

#[test]
fn who_is_unplugged_is_heard_no_more() {
    let mut bench = Bench::new();
    let mut peer = bench.connect(0);
    peer.write_all(&hello()).unwrap();
    bench.hear(&mut peer, HELLO_BYTES + ANNOUNCEMENT_BYTES);
    // The message SET_CONFIGURATION 1 is on its way when the cable is pulled out.
    peer.write_all(&[6, 0, 0, 0, 1, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 1]).unwrap();
    bench.remote.unplug();
    bench.pass_ms(1);
    assert!(!bench.remote.is_plugged());
    bench.wait_for_close(&mut peer);
    assert_eq!(bench.device.configuration, 0);
    assert!(bench.notes().contains("is unplugged"));
    let mut client = bench.connect(1);
    client.write_all(&import()).unwrap();
    bench.hear(&mut client, 320);
    bench.remote.unplug();
    bench.pass_ms(1);
    assert!(!bench.remote.is_plugged());
    bench.wait_for_close(&mut client);
    assert!(bench.notes().contains("is unplugged"));
}

#[test]
fn who_speaks_something_else_is_hung_up_on() {
    let mut bench = Bench::new();
    for place in [0, 1] {
        let mut peer = bench.connect(place);
        peer.write_all(b"GET / HTTP/1.1\r\n\r\n").unwrap();
        bench.wait_for_close(&mut peer);
        assert!(bench.notes().contains("not"), "{place}");
    }
    assert!(!bench.remote.is_plugged());
}

#[test]
fn a_port_that_is_taken_is_named() {
    let bench = Bench::new();
    let [taken, _] = bench.remote.addresses().unwrap();
    let error = Remote::listen(SocketAddr::from(([127, 0, 0, 1], 0)), taken).unwrap_err().to_string();
    assert!(error.contains(&format!("port {} for usbip", taken.port())), "{error}");
}
