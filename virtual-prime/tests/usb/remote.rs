//! Other computers at the socket, over TCP, with an image in between, as `console --usb` offers it.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};

use rigless::time::VirtualNanos;
use usb_host::remote::Remote;
use usb_host::usbredir::message::{BulkHead, Capabilities, Message};
use usb_host::usbredir::stream::Stream;

use super::*;

const USBREDIR: usize = 0;
const USBIP: usize = 1;
/// Time limit of a step, milliseconds of the board's time.
const PATIENCE_MS: u32 = 20_000;

/// A board whose socket is offered, and a connection to it.
struct Offered {
    bench: Bench,
    remote: Arc<Mutex<Remote>>,
    socket: TcpStream,
    came: Vec<u8>,
    looks: u32,
}

impl Offered {
    fn connect(place: usize) -> Self {
        let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let remote = Remote::listen(any, any).expect("two ports");
        let socket = TcpStream::connect(remote.addresses().unwrap()[place]).expect("it listens");
        socket.set_nonblocking(true).unwrap();
        socket.set_nodelay(true).unwrap();
        let (bench, _) = boot("usb_echo");
        Self { bench, remote: Arc::new(Mutex::new(remote)), socket, came: Vec::new(), looks: 0 }
    }

    /// Runs a frame of the bus, and takes the bytes that came in it.
    fn pass(&mut self) {
        self.looks += 1;
        assert!(self.looks < PATIENCE_MS, "nothing comes any more");
        self.bench.vm.run_for(MS);
        let remote = self.remote.clone();
        self.bench.vm.with(move |stopped| {
            let at = VirtualNanos(stopped.stop.at.0);
            let mut remote = remote.lock().unwrap();
            stopped.session.board_mut().mcu.usb(at, |host, device, now_ns| remote.serve(now_ns, host, device));
        });
        let mut bytes = [0; 4_096];
        while let Ok(count @ 1..) = self.socket.read(&mut bytes) {
            self.came.extend(&bytes[..count]);
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        self.socket.write_all(bytes).expect("it is taken");
    }

    fn is_plugged(&self) -> bool {
        self.remote.lock().unwrap().is_plugged()
    }

    /// Takes the next bytes from the board's side.
    fn take(&mut self, count: usize) -> Vec<u8> {
        while self.came.len() < count {
            self.pass();
        }
        self.looks = 0;
        self.came.drain(..count).collect()
    }
}

/// A peer of usbredir.
struct Peer {
    offered: Offered,
    stream: Stream,
}

impl Peer {
    fn plug_in() -> Self {
        let mut peer = Self { offered: Offered::connect(USBREDIR), stream: Stream::new("test", Capabilities(0xFF)) };
        peer.flush();
        peer.wait_for(|message| matches!(message, Message::DeviceConnect(_)));
        peer
    }

    fn flush(&mut self) {
        let bytes = std::mem::take(self.stream.output());
        self.offered.send(&bytes);
    }

    fn say(&mut self, id: u64, message: &Message) {
        self.stream.send(id, message);
        self.flush();
    }

    fn next(&mut self) -> (u64, Message) {
        loop {
            self.stream.receive(&std::mem::take(&mut self.offered.came));
            if let Some(message) = self.stream.take_message().expect("the protocol") {
                self.offered.looks = 0;
                return message;
            }
            self.offered.pass();
        }
    }

    fn wait_for(&mut self, is: impl Fn(&Message) -> bool) -> (u64, Message) {
        loop {
            let message = self.next();
            if is(&message.1) {
                return message;
            }
        }
    }

    fn configure(&mut self) {
        self.say(1, &Message::SetConfiguration { configuration: 1 });
        let (id, status) = self.wait_for(|message| matches!(message, Message::ConfigurationStatus { .. }));
        assert_eq!((id, status), (1, Message::ConfigurationStatus { status: 0, configuration: 1 }));
    }

    fn read(&mut self, id: u64) {
        let head = BulkHead { endpoint: 0x82, status: 0, length: 128, stream: 0 };
        self.say(id, &Message::BulkPacket(head, Vec::new()));
    }

    /// Sends a text and reads it back in capitals, with sixteen reads ahead, as Linux does.
    fn echo(&mut self, text: &[u8]) {
        (100..116).for_each(|id| self.read(id));
        let head = BulkHead { endpoint: 1, status: 0, length: text.len() as u32, stream: 0 };
        self.say(7, &Message::BulkPacket(head, text.to_vec()));
        let (mut back, mut written, mut asked) = (Vec::new(), false, 16);
        while back.len() < text.len() || !written {
            match self.next() {
                (7, Message::BulkPacket(head, _)) => {
                    assert_eq!((head.status, head.length), (0, text.len() as u32));
                    written = true;
                }
                (id @ 100.., Message::BulkPacket(head, data)) => {
                    assert_eq!(head.status, 0);
                    back.extend(data);
                    if back.len() < text.len() {
                        self.read(id);
                    } else {
                        asked -= 1;
                    }
                }
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(back, text.to_ascii_uppercase());
        // Each pending request is answered, and the request that has ended is not answered again.
        (100..116).for_each(|id| self.say(id, &Message::CancelDataPacket));
        for _ in 0..asked {
            let (_, message) = self.next();
            let Message::BulkPacket(head, data) = message else { panic!("{message:?}") };
            // The empty packet after a full one may have come as well.
            assert!(head.status == 1 || data.is_empty(), "{head:?}");
        }
    }
}

#[test]
fn a_peer_of_usbredir_has_an_image_of_other_peoples_crates_at_its_usb() {
    let mut peer = Peer::plug_in();
    peer.configure();
    for size in [1, 64, 700, 4_096] {
        let text: Vec<u8> = (0..size).map(|index| b'a' + (index % 26) as u8).collect();
        peer.echo(&text);
    }
    // The image starts over: its device goes, and comes back once that has been acknowledged.
    let restart = |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        stopped.session.reset_by_pin(stopped.stop.at, stopped.stop.instruction_count, stopped.host);
    };
    peer.read(200);
    peer.offered.pass();
    peer.offered.bench.vm.with(restart);
    let cancelled = peer.wait_for(|message| matches!(message, Message::BulkPacket(..)));
    assert!(matches!(cancelled, (200, Message::BulkPacket(BulkHead { status: 1, .. }, _))), "{cancelled:?}");
    assert_eq!(peer.next().1, Message::DeviceDisconnect);
    peer.say(0, &Message::DeviceDisconnectAck);
    peer.wait_for(|message| matches!(message, Message::DeviceConnect(_)));
    peer.configure();
    peer.echo(b"once more");
}

#[test]
fn a_closed_connection_pulls_the_cable_out_of_the_image() {
    let mut peer = Peer::plug_in();
    peer.configure();
    peer.echo(b"here");
    let Peer { mut offered, .. } = peer;
    offered.socket.shutdown(std::net::Shutdown::Both).expect("it was open");
    while offered.is_plugged() {
        offered.pass();
    }
    assert_clean(&mut offered.bench);
}

/// Encodes USBIP_CMD_SUBMIT of a control transfer.
fn control(sequence: u32, setup: [u8; 8]) -> Vec<u8> {
    let length = u32::from(u16::from_le_bytes([setup[6], setup[7]]));
    let head = [1, sequence, 0x1_0002, u32::from(setup[0] >> 7), 0, 0, length, 0, u32::MAX, 0];
    [head.map(u32::to_be_bytes).concat(), setup.to_vec()].concat()
}

/// Encodes USBIP_CMD_SUBMIT of a bulk transfer.
fn bulk(sequence: u32, input: bool, endpoint: u32, length: u32) -> Vec<u8> {
    let head = [1, sequence, 0x1_0002, u32::from(input), endpoint, 0, length, 0, u32::MAX, 0, 0, 0];
    head.map(u32::to_be_bytes).concat()
}

/// Decodes sequence, status and length of an answer.
fn answer(bytes: &[u8]) -> [u32; 3] {
    [4, 20, 24].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn a_client_of_usbip_has_an_image_of_other_peoples_crates_at_its_usb() {
    let mut client = Offered::connect(USBIP);
    client.send(&[1, 0x11, 0x80, 5, 0, 0, 0, 0]);
    let list = client.take(12 + 312 + 8);
    assert_eq!((list[11], &list[0x138..0x13C]), (1, &[0x16, 0xC0, 0x27, 0xDD][..]));
    let mut import = vec![1, 0x11, 0x80, 3, 0, 0, 0, 0, b'1', b'-', b'1'];
    import.resize(40, 0);
    client.send(&import);
    assert_eq!(client.take(320)[..8], [1, 0x11, 0, 3, 0, 0, 0, 0]);
    client.send(&control(1, [0x80, 6, 0, 1, 0, 0, 18, 0]));
    let descriptor = client.take(48 + 18);
    assert_eq!((answer(&descriptor), descriptor[56..60].to_vec()), ([1, 0, 18], vec![0xC0, 0x16, 0xDD, 0x27]));
    client.send(&control(2, [0, 9, 1, 0, 0, 0, 0, 0]));
    assert_eq!(answer(&client.take(48)), [2, 0, 0]);
    client.send(&bulk(3, true, 2, 64));
    client.send(&[bulk(4, false, 1, 5), b"hello".to_vec()].concat());
    assert_eq!(answer(&client.take(48)), [4, 0, 5]);
    let back = client.take(48 + 5);
    assert_eq!((answer(&back), &back[48..]), ([3, 0, 5], &b"HELLO"[..]));
    assert_clean(&mut client.bench);
}
