//! Tests of the controller at its registers, clock by clock: 25 MHz on the bus, 40 ns a clock.

use rigless::mcu::{Operate, Single};
use rigless::soc::Layout;
use rigless::soc::Width;
use rigless::soc::stm32h743::builder;
use rigless::soc::stm32h743::generated::SDMMC1;
use rigless::time::VirtualNanos;
use sim::models::sd_card::SdCard;

use super::state::*;
use super::*;

const CLOCK_NS: u64 = 40;
const KERNEL_HZ: u64 = 200_000_000;
/// Register CLKCR: CLKDIV 4 with one line; WIDBUS = 1 is four lines.
const ONE_LINE: u64 = 4;
const FOUR_LINES: u64 = 4 | 1 << 14;
const SHORT: u64 = 1 << 8;
const BLOCK_512: u64 = 9 << 4;
const ERRORS: u64 = flag::DCRCFAIL | flag::DTIMEOUT | flag::TXUNDERR | flag::RXOVERR;

/// A controller with a card in transfer state behind it.
struct Bench {
    slot: Single<Sdmmc>,
    now_ns: u64,
}

impl Bench {
    fn new(clock: u64) -> Self {
        let content = (0..64 * 1024_u32).flat_map(u32::to_le_bytes).collect();
        let mut slot = Single::new(builder(), "SDMMC1", Sdmmc::new(Some(SdCard::new(content)))).expect("a slot");
        slot.model.kernel_hz = KERNEL_HZ;
        let mut bench = Self { slot, now_ns: 0 };
        bench.write(Register::Clkcr, clock);
        bench.write(Register::Power, POWER_ON);
        bench.run(POWER_UP_CLOCKS);
        bench.write(Register::Dtimer, 1_000_000);
        bench.identify(clock & 1 << 14 != 0);
        bench
    }

    fn write(&mut self, register: Register, value: u64) {
        let address = SDMMC1.base + u64::from(register.spec().offset);
        self.slot.write(VirtualNanos(self.now_ns), address, Width::W32, value).expect("a register");
    }

    fn read(&mut self, register: Register) -> u64 {
        let address = SDMMC1.base + u64::from(register.spec().offset);
        self.slot.read(VirtualNanos(self.now_ns), address, Width::W32).expect("a register")
    }

    fn status(&mut self) -> u64 {
        self.read(Register::Star)
    }

    fn run_ns(&mut self, nanoseconds: u64) {
        self.now_ns += nanoseconds;
        self.slot.advance_to(VirtualNanos(self.now_ns));
    }

    fn run(&mut self, clocks: u64) {
        self.run_ns(clocks * CLOCK_NS);
    }

    /// Runs clock by clock until one of these flags is up. Returns the number of clocks.
    #[track_caller]
    fn run_until(&mut self, flags: u64) -> u64 {
        for clocks in 0..1_000_000 {
            if self.status() & flags != 0 {
                return clocks;
            }
            self.run(1);
        }
        panic!("no {flags:#x}: {:#x}", self.status());
    }

    fn start(&mut self, index: u64, argument: u64, extra: u64) {
        self.write(Register::Icr, flag::CLEARABLE);
        self.write(Register::Argr, argument);
        self.write(Register::Cmdr, index | CPSMEN | extra);
    }

    #[track_caller]
    fn command(&mut self, index: u64, argument: u64, extra: u64) -> u64 {
        self.start(index, argument, extra);
        self.run_until(flag::CMDREND | flag::CMDSENT | flag::CTIMEOUT | flag::CCRCFAIL);
        self.read(Register::Resp1r)
    }

    fn identify(&mut self, wide: bool) {
        self.command(0, 0, 0);
        self.command(8, 0x1AA, SHORT);
        loop {
            self.command(55, 0, SHORT);
            if self.command(41, 0x4010_0000, 2 << 8) >> 31 == 1 {
                break;
            }
            self.run(10_000);
        }
        self.command(2, 0, 3 << 8);
        let address = self.command(3, 0, SHORT) & 0xFFFF_0000;
        self.command(7, address, SHORT);
        if wide {
            self.command(55, address, SHORT);
            self.command(6, 2, SHORT);
        }
    }

    /// Starts a read or a write of these blocks through the FIFO.
    fn transfer(&mut self, index: u64, block: u64, blocks: u64, direction: u64) {
        self.write(Register::Dlenr, blocks * 512);
        self.write(Register::Dctrl, BLOCK_512 | direction);
        self.start(index, block, SHORT | CMDTRANS);
    }

    fn content(&self, block: usize) -> &[u8] {
        &self.slot.model.card().expect("a card").content()[block * 512..][..512]
    }
}

#[test]
fn words_come_in_one_by_one_and_the_end_comes_after_the_checksum() {
    for (clock, word_clocks) in [(ONE_LINE, 32), (FOUR_LINES, 8)] {
        let mut bench = Bench::new(clock);
        bench.transfer(17, 1, 1, DTDIR);
        assert_eq!(bench.status() & (flag::RXFIFOE | flag::DPSMACT), flag::RXFIFOE | flag::DPSMACT);
        while bench.status() & flag::RXFIFOE != 0 {
            bench.run(1);
        }
        for word in 0..127 {
            assert_eq!(bench.read(Register::Fifor), 128 + word);
            assert_ne!(bench.status() & flag::RXFIFOE, 0);
            bench.run(word_clocks - 1);
            assert_ne!(bench.status() & flag::RXFIFOE, 0, "word {word} comes early");
            bench.run(1);
            assert_eq!(bench.status() & flag::RXFIFOE, 0, "word {word} comes late");
        }
        assert_eq!(bench.read(Register::Fifor), 255);
        assert_eq!(bench.read(Register::Dcntr), 0);
        assert_eq!(bench.run_until(flag::DATAEND | ERRORS), 17);
        assert_eq!(bench.status() & (ERRORS | flag::DPSMACT | flag::RXFIFOE), 0);
    }
}

#[test]
fn the_end_waits_until_the_fifo_is_read() {
    let mut bench = Bench::new(FOUR_LINES);
    bench.transfer(17, 0, 1, DTDIR);
    for _ in 0..120 {
        while bench.status() & flag::RXFIFOE != 0 {
            bench.run(1);
        }
        bench.read(Register::Fifor);
    }
    bench.run(10_000);
    assert_eq!(bench.status() & (flag::DATAEND | ERRORS), 0);
    assert_ne!(bench.status() & flag::RXFIFOHF, 0, "eight words are left");
    for word in 120..128 {
        assert_eq!(bench.status() & flag::DATAEND, 0);
        assert_eq!(bench.read(Register::Fifor), word);
    }
    assert_eq!(bench.status() & (flag::DATAEND | ERRORS | flag::DPSMACT), flag::DATAEND);
}

#[test]
fn a_word_read_too_early_counts_as_read() {
    let mut bench = Bench::new(ONE_LINE);
    bench.write(Register::Dlenr, 8);
    bench.write(Register::Dctrl, 3 << 4 | DTDIR);
    bench.command(55, 0x5A51_0000, SHORT);
    bench.start(51, 0, SHORT | CMDTRANS);
    while bench.status() & flag::RXFIFOE != 0 {
        bench.run(1);
    }
    assert_eq!(bench.read(Register::Fifor), 0x0080_3502);
    assert_eq!(bench.read(Register::Fifor), 0);
    assert_eq!(bench.run_until(flag::DATAEND | ERRORS), 32 + 17);
    assert_eq!(bench.status() & ERRORS, 0);
}

#[test]
fn a_full_fifo_overruns_and_stays_so_until_the_transfer_is_stopped() {
    let mut bench = Bench::new(FOUR_LINES);
    bench.transfer(17, 0, 1, DTDIR);
    bench.run_until(flag::RXFIFOF);
    assert_eq!(bench.run_until(ERRORS), 8);
    assert_eq!(bench.status() & (ERRORS | flag::DPSMACT), flag::RXOVERR | flag::DPSMACT);
    // Until the transfer is stopped, the data path takes no new settings.
    bench.write(Register::Dlenr, 8);
    assert_eq!(bench.read(Register::Dlenr), 512);
    bench.write(Register::Dctrl, FIFORST);
    assert_ne!(bench.status() & flag::RXFIFOE, 0, "flushed");
    bench.command(12, 0, SHORT | CMDSTOP);
    assert_eq!(bench.status() & (flag::DABORT | flag::DPSMACT | flag::CMDREND), flag::DABORT | flag::CMDREND);
    bench.write(Register::Dlenr, 8);
    assert_eq!(bench.read(Register::Dlenr), 8);
}

#[test]
fn flow_control_stops_the_clock_instead() {
    let mut bench = Bench::new(FOUR_LINES | HWFC_EN);
    bench.transfer(18, 0, 2, DTDIR);
    for word in 0..256 {
        if word % 100 == 0 {
            bench.run(30_000);
        }
        while bench.status() & flag::RXFIFOE != 0 {
            bench.run(1);
        }
        assert_eq!(bench.read(Register::Fifor), word);
    }
    bench.run_until(flag::DATAEND | ERRORS);
    assert_eq!(bench.status() & ERRORS, 0);
}

#[test]
fn words_go_out_at_the_pace_of_the_bus() {
    for (clock, word_clocks) in [(ONE_LINE, 32), (FOUR_LINES, 8)] {
        let mut bench = Bench::new(clock);
        bench.transfer(24, 5, 1, 0);
        // Before the card's response no data go out.
        for word in 0..16 {
            bench.write(Register::Fifor, word);
        }
        assert_eq!(bench.status() & (flag::TXFIFOF | flag::TXFIFOHE | flag::TXFIFOE), flag::TXFIFOF);
        bench.run_until(flag::CMDREND);
        let first = (0..100).find(|_| {
            bench.run(1);
            bench.status() & flag::TXFIFOF == 0
        });
        assert!(first.is_some());
        assert_eq!(bench.run_until(flag::TXFIFOHE), 7 * word_clocks);
        for word in 16..128 {
            while bench.status() & flag::TXFIFOF != 0 {
                bench.run(1);
            }
            bench.write(Register::Fifor, word);
        }
        bench.run_until(flag::DATAEND | ERRORS);
        assert_eq!(bench.status() & ERRORS, 0);
        let written: Vec<u8> = (0..128_u32).flat_map(u32::to_le_bytes).collect();
        assert_eq!(bench.content(5), written);
    }
}

#[test]
fn an_empty_fifo_in_mid_block_is_an_underrun_or_stops_the_clock() {
    for (clock, underrun) in [(FOUR_LINES, true), (FOUR_LINES | HWFC_EN, false)] {
        let mut bench = Bench::new(clock);
        bench.transfer(24, 5, 1, 0);
        bench.run_until(flag::CMDREND);
        // In Wait_S no time-out runs.
        bench.run(100_000);
        assert_eq!(bench.status() & ERRORS, 0);
        bench.write(Register::Fifor, 7);
        bench.write(Register::Fifor, 7);
        bench.run(1_000);
        assert_eq!(bench.status() & ERRORS, if underrun { flag::TXUNDERR } else { 0 });
        if underrun {
            continue;
        }
        for _ in 2..128 {
            bench.run(50);
            bench.write(Register::Fifor, 7);
        }
        bench.run_until(flag::DATAEND | ERRORS);
        assert_eq!(bench.status() & ERRORS, 0);
        assert_eq!(bench.content(5)[508..], [7, 0, 0, 0]);
    }
}

#[test]
fn power_on_is_for_good_until_the_block_is_reset() {
    let mut bench = Bench::new(FOUR_LINES);
    bench.write(Register::Power, 0);
    assert_eq!(bench.read(Register::Power) & POWER_ON, POWER_ON);
    bench.slot.drive(VirtualNanos(bench.now_ns), |model, file, context| {
        file.reset();
        model.reset_line(file, context);
    });
    assert_eq!(bench.read(Register::Power), 0);
    bench.write(Register::Power, 0b10);
    assert_eq!(bench.read(Register::Power), 0b10);
    bench.write(Register::Power, 0b01);
    assert_eq!(bench.read(Register::Power), 0b10, "01 is reserved");
    bench.write(Register::Power, POWER_ON);
    assert_eq!(bench.read(Register::Power), POWER_ON);
    assert_eq!(bench.status(), 0);
}

#[test]
fn busy_after_a_response_is_shown_until_the_card_is_ready() {
    let mut bench = Bench::new(FOUR_LINES);
    bench.transfer(25, 5, 1, 0);
    bench.run_until(flag::CMDREND);
    for word in 0..128 {
        while bench.status() & flag::TXFIFOF != 0 {
            bench.run(1);
        }
        bench.write(Register::Fifor, word);
    }
    // The block is sent and the card programs: that is the data path's business, and not BUSYD0.
    bench.run(16 * 8 + 100);
    assert_eq!(bench.status() & (flag::DPSMACT | flag::BUSYD0 | flag::DATAEND), flag::DPSMACT);
    bench.command(12, 0, SHORT | CMDSTOP);
    assert_ne!(bench.status() & flag::BUSYD0, 0);
    bench.run_until(flag::BUSYD0END);
    assert_eq!(bench.status() & (flag::BUSYD0 | flag::DTIMEOUT), 0);
}

#[test]
fn a_card_that_says_nothing_runs_into_the_data_timeout() {
    let mut bench = Bench::new(FOUR_LINES);
    bench.write(Register::Dtimer, 1_000);
    bench.transfer(17, 0, 1, DTDIR);
    assert_eq!(bench.run_until(flag::DTIMEOUT | flag::DATAEND), 1_000);
    assert_ne!(bench.status() & flag::DPSMACT, 0);
    bench.command(12, 0, SHORT | CMDSTOP);
    assert_eq!(bench.status() & flag::DPSMACT, 0);
}

#[test]
fn a_card_pulled_out_damages_the_block_and_then_answers_nothing() {
    let mut bench = Bench::new(FOUR_LINES | HWFC_EN);
    bench.transfer(17, 0, 1, DTDIR);
    bench.run_until(flag::RXFIFOHF);
    bench.slot.model.insert(None);
    for _ in 0..128 {
        while bench.status() & flag::RXFIFOE != 0 {
            bench.run(1);
        }
        bench.read(Register::Fifor);
    }
    bench.run_until(ERRORS | flag::DATAEND);
    assert_eq!(bench.status() & (ERRORS | flag::DATAEND), flag::DCRCFAIL);
    bench.start(13, 0, SHORT);
    assert_eq!(bench.run_until(flag::CTIMEOUT | flag::CMDREND), 48 + 64);
    assert_eq!(bench.status() & flag::CMDREND, 0);
}

#[test]
fn different_widths_at_both_ends_damage_every_block() {
    let mut bench = Bench::new(FOUR_LINES | HWFC_EN);
    bench.write(Register::Clkcr, ONE_LINE | HWFC_EN);
    bench.transfer(17, 0, 1, DTDIR);
    for _ in 0..128 {
        while bench.status() & flag::RXFIFOE != 0 {
            bench.run(1);
        }
        bench.read(Register::Fifor);
    }
    bench.run_until(ERRORS | flag::DATAEND);
    assert_eq!(bench.status() & (ERRORS | flag::DATAEND), flag::DCRCFAIL);
}

#[test]
fn the_fifo_is_closed_while_the_data_path_is_idle() {
    let mut bench = Bench::new(FOUR_LINES);
    bench.write(Register::Fifor, 5);
    assert_eq!(bench.read(Register::Fifor), 0);
    assert_eq!(bench.status() & (flag::RXFIFOE | flag::TXFIFOE | flag::TXFIFOHE), 0);
}

/// Register CLKCR with CLKDIV 2: 50 MHz.
const FAST: u64 = 2 | 1 << 14;

/// Switches the card to high speed (CMD6).
fn switch(bench: &mut Bench) {
    bench.write(Register::Dlenr, 64);
    bench.write(Register::Dctrl, 6 << 4 | DTDIR);
    bench.start(6, 0x80FF_FFF1, SHORT | CMDTRANS);
    for _ in 0..16 {
        while bench.status() & flag::RXFIFOE != 0 {
            bench.run(1);
        }
        bench.read(Register::Fifor);
    }
    bench.run_until(flag::DATAEND | ERRORS);
}

/// Reads a block through the FIFO at this clock. Returns the time of the words, ns, and the final flags.
fn timed_block(bench: &mut Bench, clock: u64) -> (u64, u64) {
    bench.write(Register::Clkcr, clock | HWFC_EN);
    bench.transfer(17, 0, 1, DTDIR);
    while bench.status() & flag::RXFIFOE != 0 {
        bench.run_ns(20);
    }
    let began_ns = bench.now_ns;
    for _ in 0..128 {
        while bench.status() & flag::RXFIFOE != 0 {
            bench.run_ns(20);
        }
        bench.read(Register::Fifor);
    }
    let took_ns = bench.now_ns - began_ns;
    bench.run_until(ERRORS | flag::DATAEND);
    (took_ns, bench.status() & (ERRORS | flag::DATAEND))
}

#[test]
fn a_faster_bus_takes_less_time_once_the_card_is_set_to_high_speed() {
    let mut bench = Bench::new(FOUR_LINES);
    assert_eq!(timed_block(&mut bench, FOUR_LINES), (127 * 8 * 40, flag::DATAEND));
    // Before the switch to high speed everything arrives damaged.
    assert_eq!(timed_block(&mut bench, FAST).1, flag::DCRCFAIL);
    bench.command(12, 0, SHORT | CMDSTOP);
    bench.write(Register::Clkcr, FOUR_LINES | HWFC_EN);
    switch(&mut bench);
    assert_eq!(timed_block(&mut bench, FAST), (127 * 8 * 20, flag::DATAEND));
}

#[test]
fn an_answer_that_arrives_damaged_is_told() {
    let mut bench = Bench::new(FOUR_LINES);
    bench.slot.model.card_mut().expect("a card").trouble().damaged_answers = 1;
    bench.start(13, 0x5A51_0000, SHORT);
    assert_eq!(bench.run_until(flag::CMDREND | flag::CCRCFAIL | flag::CTIMEOUT), 48 + 8 + 48);
    assert_eq!(bench.status() & (flag::CMDREND | flag::CCRCFAIL), flag::CCRCFAIL);
}

/// A card may take 100 ms to its first block, PL 6.00 section 4.6.2.1.
#[test]
fn a_card_that_takes_its_time_is_waited_for_as_long_as_the_timer_says() {
    let mut bench = Bench::new(FOUR_LINES | HWFC_EN);
    bench.slot.model.card_mut().expect("a card").trouble().slow_reads = (20_000_000, 1);
    bench.transfer(17, 0, 1, DTDIR);
    bench.run_ns(20_000_000);
    assert_eq!(bench.status() & (flag::RXFIFOE | ERRORS), flag::RXFIFOE);
    bench.run_ns(300_000);
    assert_eq!(bench.status() & (flag::RXFIFOE | ERRORS), 0);
}
