//! The image for a Klipper host on the virtual board: a host identifies it, configures it, moves a motor,
//! reads what it measures, and other firmware takes its place.
//!
//! The host here is written from the protocol's description and shares nothing with the image.

use std::path::PathBuf;

use config::BoardId;
use sim::models::sd_card::SdCard;
use sim::models::tmc26x::Chip;
use sim::world::WorldConfig;
use units::Actuator;
use virtual_prime::board::PrimeBoard;
use virtual_prime::sd_image;
use virtual_prime::usb_desk::cdc::Serial;
use virtual_prime::usb_desk::dfu::{Dfu, state};
use virtual_prime::usb_desk::{Device, UsbHost};
use virtual_prime::vm::Span;

use crate::common::velvet::{CONFIG, image};
use crate::common::{Bench, MS, boot_elf};

/// Ticks of the board's clock in a millisecond.
const TICKS: u32 = 200_000;
/// Time in which an answer comes, milliseconds.
const PATIENCE_MS: u64 = 100;

/// The image, which `make firmware` puts beside the firmware.
fn controller() -> PathBuf {
    image().with_file_name("controller")
}

/// CRC-16/MCRF4XX.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc: u16, _| if crc & 1 != 0 { crc >> 1 ^ 0x8408 } else { crc >> 1 })
    })
}

/// Appends an integer: groups of seven bits, the highest first.
fn put(bytes: &mut Vec<u8>, value: u32) {
    let value = i64::from(value as i32);
    for shift in [28, 21, 14, 7] {
        let limit = 1_i64 << (shift - 2);
        if value >= 3 * limit || value < -limit {
            bytes.push((value >> shift) as u8 & 0x7F | 0x80);
        }
    }
    bytes.push(value as u8 & 0x7F);
}

/// Takes an integer from the front.
fn take(bytes: &mut &[u8]) -> u32 {
    let mut next = || {
        let (first, rest) = bytes.split_first().expect("an integer");
        *bytes = rest;
        *first
    };
    let mut byte = next();
    let sign = if byte & 0x60 == 0x60 { !0x1F } else { 0 };
    let mut value = u32::from(byte & 0x7F) | sign;
    while byte & 0x80 != 0 {
        byte = next();
        value = value << 7 | u32::from(byte & 0x7F);
    }
    value
}

/// A parameter of a command.
enum Word<'a> {
    Number(u32),
    Bytes(&'a [u8]),
}

/// A way for bytes to the board and back, in which time passes.
trait Wire {
    fn send(&mut self, bytes: &[u8]);
    fn receive(&mut self) -> Vec<u8>;
}

impl Wire for Bench {
    fn send(&mut self, bytes: &[u8]) {
        self.console.send(bytes);
    }

    fn receive(&mut self) -> Vec<u8> {
        assert_eq!(self.vm.run_for(MS), Span::Reached);
        self.console.receive()
    }
}

/// A serial port of the USB socket.
struct Socket {
    bench: Bench,
    host: UsbHost,
    port: Serial,
}

impl Wire for Socket {
    fn send(&mut self, bytes: &[u8]) {
        self.port.write(&mut self.host.at(&mut self.bench.vm), bytes).expect("the board takes it");
    }

    fn receive(&mut self) -> Vec<u8> {
        let mut desk = self.host.at(&mut self.bench.vm);
        let listening = self.port.listen(&mut desk, 64);
        desk.wait(listening).expect("an answer").data
    }
}

/// A Klipper host.
struct Host<W> {
    wire: W,
    sequence: u8,
    heard: Vec<u8>,
    /// The dictionary's text.
    dictionary: String,
}

impl<W: Wire> Host<W> {
    /// Identifies the board.
    fn new(wire: W) -> Self {
        let mut host = Self { wire, sequence: 1, heard: Vec::new(), dictionary: String::new() };
        let mut packed = Vec::new();
        loop {
            let mut command = vec![1];
            put(&mut command, packed.len() as u32);
            put(&mut command, 40);
            let answers = host.exchange(&command);
            let Some(mut answer) = answers.iter().find_map(|answer| answer.strip_prefix(&[0])) else { continue };
            assert_eq!(take(&mut answer), packed.len() as u32);
            assert_eq!(usize::from(answer[0]), answer.len() - 1);
            if answer.len() == 1 {
                break;
            }
            packed.extend_from_slice(&answer[1..]);
        }
        let text = miniz_oxide::inflate::decompress_to_vec_zlib(&packed).expect("zlib data");
        host.dictionary = String::from_utf8(text).expect("text");
        host
    }

    /// Number of a message, from the dictionary: a format is the name and words with an equals sign.
    fn number(&self, name: &str) -> u32 {
        let is_format = |text: &str| {
            let mut words = text.split(' ');
            words.next() == Some(name) && words.all(|word| word.contains('='))
        };
        let texts: Vec<&str> = self.dictionary.split('"').collect();
        let number = texts.windows(2).filter(|pair| is_format(pair[0])).find_map(|pair| {
            let number = pair[1].trim_matches(|c: char| !c.is_ascii_digit() && c != '-');
            number.parse::<i32>().ok()
        });
        number.unwrap_or_else(|| panic!("no {name} in {}", self.dictionary)) as u32
    }

    /// Sends a block until it is acknowledged. Returns the contents of the blocks that came meanwhile.
    fn exchange(&mut self, content: &[u8]) -> Vec<Vec<u8>> {
        let mut answers = Vec::new();
        for _ in 0..3 {
            let mut block = vec![content.len() as u8 + 5, 0x10 | self.sequence];
            block.extend_from_slice(content);
            let sum = crc(&block);
            block.extend_from_slice(&[(sum >> 8) as u8, sum as u8, 0x7E]);
            self.wire.send(&block);
            let sent = self.sequence;
            for _ in 0..PATIENCE_MS {
                let is_acknowledged = self.listen(&mut answers);
                if is_acknowledged && self.sequence == (sent + 1) & 15 {
                    return answers;
                }
                if is_acknowledged {
                    break;
                }
            }
        }
        panic!("a block is not acknowledged");
    }

    /// Takes what came in. Returns whether an empty block was among it.
    fn listen(&mut self, answers: &mut Vec<Vec<u8>>) -> bool {
        self.heard.extend(self.wire.receive());
        let mut is_acknowledged = false;
        while let Some(&length) = self.heard.first().filter(|length| self.heard.len() >= usize::from(**length)) {
            let block: Vec<u8> = self.heard.drain(..usize::from(length)).collect();
            let (body, end) = block.split_at(block.len() - 3);
            assert_eq!(end, [(crc(body) >> 8) as u8, crc(body) as u8, 0x7E], "{block:02x?}");
            self.sequence = body[1] & 15;
            if body.len() == 2 { is_acknowledged = true } else { answers.push(body[2..].to_vec()) }
        }
        is_acknowledged
    }

    /// Gives a command, and returns the numbers of the first answer of this name.
    fn ask(&mut self, command: &str, words: &[Word<'_>], answer: &str) -> Vec<u32> {
        let number = self.number(answer);
        let answers = self.give(command, words);
        let mut found = answers.iter().filter_map(|answer| {
            let mut rest = answer.as_slice();
            (take(&mut rest) == number).then_some(rest)
        });
        let mut rest = found.next().unwrap_or_else(|| panic!("{command}: no {answer} in {answers:02x?}"));
        let mut numbers = Vec::new();
        while !rest.is_empty() {
            numbers.push(take(&mut rest));
        }
        numbers
    }

    fn give(&mut self, command: &str, words: &[Word<'_>]) -> Vec<Vec<u8>> {
        let mut content = Vec::new();
        put(&mut content, self.number(command));
        for word in words {
            match word {
                Word::Number(number) => put(&mut content, *number),
                Word::Bytes(bytes) => {
                    content.push(bytes.len() as u8);
                    content.extend_from_slice(bytes);
                }
            }
        }
        self.exchange(&content)
    }

    /// Gives a command of numbers alone, to which nothing is answered.
    fn tell(&mut self, command: &str, numbers: &[u32]) {
        let words: Vec<Word<'_>> = numbers.iter().copied().map(Word::Number).collect();
        let answers = self.give(command, &words);
        let refusal = self.number("is_shutdown");
        let is_refused = answers.iter().any(|answer| take(&mut answer.as_slice()) == refusal);
        assert!(!is_refused, "{command} {numbers:?}: {answers:02x?}");
    }

    fn clock(&mut self) -> u32 {
        self.ask("get_clock", &[], "clock")[0]
    }

    /// Lets time pass. Returns the answers that came.
    fn pass(&mut self, ms: u64) -> Vec<Vec<u8>> {
        let mut answers = Vec::new();
        for _ in 0..ms {
            self.listen(&mut answers);
        }
        answers
    }
}

/// Tolerance of the time between two steps: each may be late by 250 ns.
const STEP_TOLERANCE_NS: u64 = 250;

/// Number of a pin.
fn pin(port: char, number: u32) -> u32 {
    (u32::from(port) - u32::from('A')) * 16 + number
}

/// A board with the sample printer's machine.
fn board() -> PrimeBoard {
    let (machine, _) = config::parse(CONFIG.as_bytes(), BoardId::Prime2590, &mut ());
    PrimeBoard::new(WorldConfig::of(&machine, Chip::Tmc2590)).expect("the board's tables are right")
}

#[test]
fn a_host_configures_the_board_and_moves_a_motor() {
    let mut bench = boot_elf(&controller(), board());
    let world = bench.world();
    assert_eq!(bench.vm.run_for(500 * MS), Span::Reached);
    let mut host = Host::new(bench);
    assert!(host.dictionary.contains("\"CLOCK_FREQ\":200000000"), "{}", host.dictionary);
    assert_eq!(host.ask("get_config", &[], "config")[0], 0);
    host.tell("allocate_oids", &[4]);
    host.tell("config_stepper", &[0, pin('D', 3), pin('D', 4), u32::MAX, 20]);
    host.tell("config_analog_in", &[1, pin('F', 11)]);
    host.tell("config_spi", &[2, pin('J', 13), 0]);
    host.tell("spi_set_bus", &[2, 1, 3, 1_000_000]);
    host.tell("config_digital_out", &[3, pin('E', 0), 0, 0, 0]);
    host.tell("finalize_config", &[0x1234]);
    assert_eq!(host.ask("get_config", &[], "config")[..3], [1, 0x1234, 0]);
    // DRVCONF, DRVCTRL with steps on both edges: each answer of 20 bits is the driver's status.
    for register in [[0x0E, 0x00, 0x10], [0x00, 0x01, 0x00]] {
        host.ask("spi_transfer", &[Word::Number(2), Word::Bytes(&register)], "spi_transfer_response");
    }
    host.tell("update_digital_out", &[3, 1]);
    let start = host.clock().wrapping_add(50 * TICKS);
    host.tell("query_analog_in", &[1, start, TICKS, 8, 50 * TICKS, 2, 0, 0xFFFF, 0]);
    host.tell("reset_step_clock", &[0, start]);
    host.tell("set_next_step_dir", &[0, 1]);
    host.tell("queue_step", &[0, 20_000, 1_000, 0]);
    host.tell("set_next_step_dir", &[0, 0]);
    host.tell("queue_step", &[0, 10_000, 300, 0]);
    let reports = host.pass(300);
    let state = host.number("analog_in_state");
    assert!(reports.iter().any(|report| take(&mut report.as_slice()) == state), "{reports:02x?}");
    assert_eq!(host.ask("stepper_get_position", &[Word::Number(0)], "stepper_position"), [0, 700]);
    let world = world.lock();
    // Low is direction 0 here, and forward for the machine.
    assert_eq!(world.trace().tally(Actuator::Alpha).net_steps, -700);
    let edges = world.trace().edges();
    let distances: Vec<u64> = edges.windows(2).map(|pair| pair[1].time_ns - pair[0].time_ns).collect();
    let (slow, fast) = (&distances[..999], &distances[1_000..]);
    assert!(slow.iter().all(|ns| ns.abs_diff(100_000) <= STEP_TOLERANCE_NS), "{slow:?}");
    assert!(fast.iter().all(|ns| ns.abs_diff(50_000) <= STEP_TOLERANCE_NS), "{fast:?}");
    drop(world);
    assert_eq!(host.wire.vm.complaints(), Vec::<String>::new());
}

/// Level of a pin.
fn level(host: &mut Host<Bench>, pin: &'static str) -> bool {
    let pin = virtual_prime::pins::pin(pin);
    host.wire.vm.with(move |stopped| stopped.session.board().level(pin)).expect("the run goes on")
}

#[test]
fn heaters_are_off_a_second_after_the_host_s_last_word() {
    let mut bench = boot_elf(&controller(), board());
    assert_eq!(bench.vm.run_for(500 * MS), Span::Reached);
    let mut host = Host::new(bench);
    host.tell("allocate_oids", &[1]);
    host.tell("config_digital_out", &[0, pin('E', 0), 0, 0, 3_000 * TICKS]);
    host.tell("set_digital_out_pwm_cycle", &[0, 100 * TICKS]);
    host.tell("finalize_config", &[1]);
    let on = host.clock().wrapping_add(20 * TICKS);
    host.tell("queue_digital_out", &[0, on, 100 * TICKS]);
    host.pass(800);
    assert!(level(&mut host, "PE0"), "the heater is on");
    // PF14 enables by a low level.
    assert!(!level(&mut host, "PF14") && level(&mut host, "PD7"));
    host.pass(220);
    assert!(!level(&mut host, "PE0"), "on after a second of silence");
    // It goes on with the host, and ends when the host does not renew it in three seconds.
    host.clock();
    host.pass(2);
    assert!(level(&mut host, "PE0"));
    for _ in 0..25 {
        host.pass(80);
        host.clock();
    }
    assert!(!level(&mut host, "PE0"));
    assert_eq!(host.ask("get_config", &[], "config")[2], 1, "shut down");
}

/// Most instructions that a step of three motors may take, of interrupt and feed together.
const STEP_INSTRUCTIONS: u64 = 86;

#[test]
fn a_step_of_three_motors_takes_few_instructions() {
    const STEPS: u32 = 30_000;
    let mut bench = boot_elf(&controller(), board());
    assert_eq!(bench.vm.run_for(500 * MS), Span::Reached);
    let mut host = Host::new(bench);
    host.tell("allocate_oids", &[3]);
    for (oid, pins) in [('D', 3, 'D', 4), ('K', 2, 'G', 2), ('G', 3, 'G', 4)].into_iter().enumerate() {
        let (step, direction) = (pin(pins.0, pins.1), pin(pins.2, pins.3));
        host.tell("config_stepper", &[oid as u32, step, direction, u32::MAX, 20]);
    }
    host.tell("finalize_config", &[1]);
    let instructions = |host: &mut Host<Bench>| {
        let before = host.wire.vm.instructions();
        host.pass(100);
        host.wire.vm.instructions() - before
    };
    let quiet = instructions(&mut host);
    // As Klipper's benchmark has it: all motors step at the same ticks.
    let start = host.clock().wrapping_add(60 * TICKS);
    for oid in 0..3 {
        host.tell("reset_step_clock", &[oid, start]);
        host.tell("queue_step", &[oid, 600, STEPS, 0]);
    }
    let ahead = start.wrapping_sub(host.clock()) / TICKS;
    host.pass(u64::from(ahead) - 1);
    let busy = instructions(&mut host);
    for oid in 0..3 {
        let position = host.ask("stepper_get_position", &[Word::Number(oid)], "stepper_position");
        assert_eq!(position[1] as i32, -(STEPS as i32));
    }
    let each = (busy - quiet) / u64::from(3 * STEPS);
    println!("{each} instructions a step");
    assert!(each <= STEP_INSTRUCTIONS, "{each} instructions a step");
}

#[test]
fn a_host_at_the_usb_socket_identifies_the_board_and_resets_it() {
    let mut bench = boot_elf(&controller(), board());
    assert_eq!(bench.vm.run_for(500 * MS), Span::Reached);
    let mut usb = UsbHost::new();
    let device = enumerate(&mut usb, &mut bench);
    let port = *Serial::all(&device).first().expect("a serial port");
    port.set_lines(&mut usb.at(&mut bench.vm), true, true).expect("the port opens");
    let mut host = Host::new(Socket { bench, host: usb, port });
    let before = host.clock();
    assert!(host.clock().wrapping_sub(before) < 20 * TICKS);
    host.tell("reset", &[]);
    let Socket { mut bench, .. } = host.wire;
    assert_eq!(bench.vm.run_for(1_000 * MS), Span::Reached);
    let mut host = Host::new(bench);
    assert!(host.clock() < 1_500 * TICKS, "the clock began anew");
}

/// Plugs the board in.
fn enumerate(host: &mut UsbHost, bench: &mut Bench) -> Device {
    let mut desk = host.at(&mut bench.vm);
    desk.plug();
    desk.enumerate().expect("the image is a USB device")
}

#[test]
fn a_board_that_no_host_speaks_to_makes_way_for_a_download() {
    let mut bench = boot_elf(&controller(), board());
    assert_eq!(bench.vm.run_for(500 * MS), Span::Reached);
    let mut usb = UsbHost::new();
    let device = enumerate(&mut usb, &mut bench);
    let dfu = Dfu::of(&device).expect("an interface for it");
    let port = *Serial::all(&device).first().expect("a serial port");
    port.set_lines(&mut usb.at(&mut bench.vm), true, true).expect("the port opens");
    let Socket { mut bench, host: mut usb, .. } = Host::new(Socket { bench, host: usb, port }).wire;
    let refused = dfu.detach(&mut usb.at(&mut bench.vm), 1_000);
    assert!(refused.is_err_and(|error| error.is_stall()), "a host has just spoken");
    assert_eq!(bench.vm.run_for(6_000 * MS), Span::Reached);
    dfu.detach(&mut usb.at(&mut bench.vm), 1_000).expect("nobody speaks any more");
    assert_eq!(bench.vm.run_for(1_000 * MS), Span::Reached);
    let waiting = enumerate(&mut usb, &mut bench);
    let download = Dfu::of(&waiting).expect("the boot stage's download");
    assert_eq!(download.state(&mut usb.at(&mut bench.vm)), Ok(state::IDLE));
}

#[test]
fn other_firmware_on_the_card_takes_the_place_of_this_one() {
    let card = std::fs::read(image().with_file_name("flashme.bin")).expect("make firmware makes it");
    let mut board = board();
    let files = [("flashme.bin".to_owned(), card), ("config.ini".to_owned(), CONFIG.into())];
    board.insert(Some(SdCard::new(sd_image::build(None, &files).expect("a volume"))));
    let mut bench = boot_elf(&controller(), board);
    let mut said = Vec::new();
    for _ in 0..600 {
        assert_eq!(bench.vm.run_for(100 * MS), Span::Reached);
        said.extend(bench.console.receive());
        if String::from_utf8_lossy(&said).contains("Welcome to Smoothie") {
            return;
        }
    }
    panic!("it said: {}", String::from_utf8_lossy(&said));
}
