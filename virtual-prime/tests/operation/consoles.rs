//! Consoles beside each other: a flood on one leaves the others their turns, and a pipe into `virtual-prime
//! console` does too.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread;

use virtual_prime::typed::Typed;

use crate::common::velvet::{Plan, Velvet, image};
use crate::common::{FRAME_NS, MS};

const PROMISED_NS: u64 = 50 * MS;

/// A text without end, as a reader.
struct Endless {
    text: &'static [u8],
    at: usize,
}

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        for byte in &mut *buffer {
            *byte = self.text[self.at];
            self.at = (self.at + 1) % self.text.len();
        }
        Ok(buffer.len())
    }
}

/// Asks on UART 0 while a pipe fills the debug console. Returns the instant at which the first byte of the
/// answer arrives.
#[track_caller]
fn ask_beside(velvet: &mut Velvet, pipe: &mut Typed, question: &str) -> u64 {
    let uart = velvet.bench.uart.clone();
    uart.receive();
    uart.send(format!("{question}\n").as_bytes());
    for _ in 0..400 {
        pipe.hand_to(&velvet.bench.console);
        velvet.hear_for(FRAME_NS * 3);
        let sent = uart.unsent() == 0;
        if let Some(first) = uart.receive_timed().first()
            && sent
        {
            return first.at_ns - (uart.last_began_ns().expect("it was sent") + FRAME_NS);
        }
    }
    panic!("{question} is not answered");
}

/// Moves of 0.4 s each fill the look-ahead queue, and a sender of more of them has to wait.
#[test]
fn a_flood_of_moves_leaves_the_other_console_its_turns() {
    let mut velvet = Plan::new().start();
    let mut pipe = Typed::read(Endless { text: b"G90\nG1 X20 F3000\nG1 X1 F3000\n", at: 0 });
    for _ in 0..250 {
        pipe.hand_to(&velvet.bench.console);
        velvet.hear(1);
    }
    for question in ["G90", "M220 S100", "M105", "M301", "version", "?"] {
        let late_ns = ask_beside(&mut velvet, &mut pipe, question);
        println!("{question}: {late_ns} ns");
        assert!(late_ns <= PROMISED_NS, "{question}: {late_ns} ns");
        for _ in 0..37 {
            pipe.hand_to(&velvet.bench.console);
            velvet.hear(1);
        }
    }
    assert!(velvet.said().contains("ok\n"), "the flood is not answered");
}

/// A child process that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _gone_already = self.0.kill();
        let _status = self.0.wait();
    }
}

fn console() -> Running {
    let mut command = Command::new(env!("CARGO_BIN_EXE_virtual-prime"));
    command.arg("console").arg("--elf").arg(image());
    command.arg("--config").arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../config/samples/cartesian.ini"));
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    Running(command.spawn().expect("the command runs"))
}

#[test]
fn a_pipe_into_the_console_is_answered_to_its_end() {
    let mut running = console();
    let mut input = running.0.stdin.take().expect("a pipe");
    input.write_all(b"M115\nG91\nG1 X5 F600\nM400\nversion\n").expect("it listens");
    drop(input);
    let mut said = String::new();
    running.0.stdout.take().expect("a pipe").read_to_string(&mut said).expect("text");
    assert!(running.0.wait().expect("it ends").success());
    assert!(said.contains("FIRMWARE_NAME:") && said.contains("3 primary axis\n"), "{said}");
}

#[test]
fn a_pipe_without_end_leaves_the_other_consoles_alone() {
    let mut running = console();
    let mut input = running.0.stdin.take().expect("a pipe");
    // The input goes on until the process is gone.
    thread::spawn(move || while input.write_all(&b"M105\n".repeat(1_000)).is_ok() {});
    let mut output = running.0.stdout.take().expect("a pipe");
    thread::spawn(move || io::copy(&mut output, &mut io::sink()));
    let mut words = BufReader::new(running.0.stderr.take().expect("a pipe"));
    let mut line = String::new();
    let address = loop {
        line.clear();
        assert!(words.read_line(&mut line).expect("text") > 0, "it ended");
        if let Some((_, address)) = line.trim_end().split_once("UART 0 (USART3) on tcp ") {
            break address.to_owned();
        }
    };
    let mut uart = TcpStream::connect(address).expect("it listens");
    // The machine may not have booted yet, and then hears nothing.
    let mut asking = uart.try_clone().expect("a socket");
    thread::spawn(move || {
        while asking.write_all(b"version\n").is_ok() {
            thread::sleep(std::time::Duration::from_millis(300));
        }
    });
    let mut heard = Vec::new();
    let mut bytes = [0; 256];
    while !String::from_utf8_lossy(&heard).contains("Prime") {
        let count = uart.read(&mut bytes).expect("the other console");
        assert!(count > 0, "it closed");
        heard.extend(&bytes[..count]);
    }
}
