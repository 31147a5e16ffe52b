//! The image for a Klipper host on the virtual board: a host identifies it, configures it, moves a motor,
//! reads what it measures, and other firmware takes its place.

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

use crate::common::klipper_host::{Host, Socket, Word, take};
use crate::common::velvet::{CONFIG, image};
use crate::common::{Bench, MS, boot_elf};

/// Ticks of the board's clock in a millisecond.
const TICKS: u32 = 200_000;
/// The image, which `make firmware` puts beside the firmware.
fn controller() -> PathBuf {
    image().with_file_name("controller")
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
const STEP_INSTRUCTIONS: u64 = 76;

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
