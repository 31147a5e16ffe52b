//! Identification of a card: from power-on to the transfer state (PL 6.00 sections 4.2, 4.3 and 6.4.1), four
//! bits wide and at the fastest clock that card and host allow.

use super::error::{SdError, Unsupported};
use super::host::{Answer, Command, Direction, Fault, Host, Place, Power, Progress, Transfer};
use super::registers::{CardInfo, Cid, Csd, has_high_speed, offers_high_speed, refusal, scr_knows_switch, status};
use super::{BLOCK_BYTES, SCRATCH_SLOT};

/// Bus clock while a card is identified: 100 to 400 kHz (section 6.6.6, fOD).
const IDENTIFY_HZ: u32 = 400_000;
/// Each state of the power sequence lasts a millisecond at least (section 6.4.1).
const POWER_STATE_US: u64 = 1_000;
/// Longer than the 74 clocks that a card gets before its first command: 185 us at 400 kHz.
const FIRST_CLOCKS_US: u64 = 250;
/// Limit of the card's start, which may take a second (section 4.2.3).
const READY_LIMIT_US: u64 = 1_000_000;
/// Period of the question whether the card is ready.
const READY_PERIOD_US: u64 = 1_000;
/// Longest time that a card may hold D0 low after being selected.
const BUSY_LIMIT_US: u64 = 500_000;
/// Limit of a command, above its time with data at 400 kHz, and above the host's own timeouts.
const COMMAND_LIMIT_US: u64 = 1_200_000;
/// Voltage window of the host in the OCR, 2.7 to 3.6 V (section 5.1).
const OUR_VOLTAGES: u32 = 0x00FF_8000;
const HIGH_CAPACITY: u32 = 1 << 30;
const READY: u32 = 1 << 31;
/// CMD8: 2.7 to 3.6 V, and a pattern that the card repeats.
const INTERFACE_CONDITION: u32 = 0x1AA;
/// CMD6: function 1 of group 1 (high speed), the other groups as they are; asked first, then set.
const ASK_HIGH_SPEED: u32 = 0x00FF_FFF1;
const SET_HIGH_SPEED: u32 = 0x80FF_FFF1;
const SCR_BYTES: u16 = 8;
const SWITCH_BYTES: u16 = 64;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    PowerCycle,
    PowerOff,
    FirstClocks,
    GoIdle,
    InterfaceCondition,
    AnnounceConditions,
    Conditions,
    WaitForReady,
    AskMmc,
    AllCids,
    Address,
    Csd,
    Select,
    AnnounceWidth,
    Width,
    BlockLength,
    AnnounceScr,
    Scr,
    AskHighSpeed,
    SetHighSpeed,
    AnnounceScrAgain,
    ScrAgain,
    /// CMD12: ends the remains of a register's transfer in card and host.
    Cut,
}

/// Result of a step.
enum Outcome {
    Next(Step),
    Done,
    Failed(SdError),
}

/// Identification in progress.
#[derive(Clone, Debug)]
pub(super) struct Identify {
    step: Step,
    since_us: u64,
    began_us: u64,
    /// The card has answered a command.
    has_answered: bool,
    is_version_two: bool,
    conditions: u32,
    info: CardInfo,
    can_switch: bool,
    scr: [u8; SCR_BYTES as usize],
    /// Highest clock that is tried, Hz.
    most_hz: u32,
    has_begun: bool,
}

impl Identify {
    /// Creates an identification; the bus is not made faster than `most_hz`.
    pub const fn new(most_hz: u32) -> Self {
        Self {
            step: Step::PowerCycle,
            since_us: 0,
            began_us: 0,
            has_answered: false,
            is_version_two: false,
            conditions: 0,
            info: CardInfo {
                kind: super::Kind::Sdhc,
                blocks: 0,
                is_protected: false,
                is_fast: false,
                cid: Cid([0; 4]),
                relative_address: 0,
            },
            can_switch: false,
            scr: [0; SCR_BYTES as usize],
            most_hz,
            has_begun: false,
        }
    }

    /// Advances as far as possible without waiting. Returns the result once the identification has ended.
    pub fn advance(&mut self, host: &mut impl Host, now_us: u64) -> Option<Result<CardInfo, SdError>> {
        if !core::mem::replace(&mut self.has_begun, true) {
            self.enter(Step::PowerCycle, host, now_us);
        }
        loop {
            match self.outcome(host, now_us)? {
                Outcome::Next(step) => self.enter(step, host, now_us),
                Outcome::Done => return Some(Ok(self.info)),
                Outcome::Failed(error) => return Some(Err(error)),
            }
        }
    }

    fn enter(&mut self, step: Step, host: &mut impl Host, now_us: u64) {
        (self.step, self.since_us) = (step, now_us);
        let address = self.info.relative_address;
        match step {
            Step::PowerCycle => host.power(Power::Cycle),
            Step::PowerOff => host.power(Power::Off),
            Step::FirstClocks => {
                host.set_bus(IDENTIFY_HZ, false);
                host.power(Power::On);
            }
            Step::WaitForReady => {}
            Step::GoIdle => host.begin(Command::new(0, 0).answered(Answer::None), None),
            Step::InterfaceCondition => host.begin(Command::new(8, INTERFACE_CONDITION), None),
            Step::AnnounceConditions => host.begin(Command::new(55, 0), None),
            Step::Conditions => {
                let argument = OUR_VOLTAGES | if self.is_version_two { HIGH_CAPACITY } else { 0 };
                host.begin(Command::new(41, argument).answered(Answer::ShortUnchecked), None);
            }
            Step::AskMmc => host.begin(Command::new(1, 0).answered(Answer::ShortUnchecked), None),
            Step::AllCids => host.begin(Command::new(2, 0).answered(Answer::Long), None),
            Step::Address => host.begin(Command::new(3, 0), None),
            Step::Csd => host.begin(Command::new(9, address).answered(Answer::Long), None),
            Step::Select => host.begin(Command::new(7, address), None),
            Step::AnnounceWidth | Step::AnnounceScr | Step::AnnounceScrAgain => {
                host.begin(Command::new(55, address), None);
            }
            // ACMD6: four bits, as every card can (section 3.2).
            Step::Width => host.begin(Command::new(6, 0b10), None),
            Step::BlockLength => host.begin(Command::new(16, BLOCK_BYTES as u32), None),
            Step::Scr | Step::ScrAgain => host.begin(Command::new(51, 0), Some(register(SCR_BYTES))),
            Step::AskHighSpeed => host.begin(Command::new(6, ASK_HIGH_SPEED), Some(register(SWITCH_BYTES))),
            Step::Cut => host.begin(Command::new(12, 0), None),
            Step::SetHighSpeed => host.begin(Command::new(6, SET_HIGH_SPEED), Some(register(SWITCH_BYTES))),
        }
    }

    /// Returns the result of the step; `None` as long as it goes on.
    fn outcome(&mut self, host: &mut impl Host, now_us: u64) -> Option<Outcome> {
        let passed = now_us.saturating_sub(self.since_us);
        match self.step {
            Step::PowerCycle => return (passed >= POWER_STATE_US).then_some(Outcome::Next(Step::PowerOff)),
            Step::PowerOff => return (passed >= POWER_STATE_US).then_some(Outcome::Next(Step::FirstClocks)),
            Step::FirstClocks => return (passed >= FIRST_CLOCKS_US).then_some(Outcome::Next(Step::GoIdle)),
            Step::WaitForReady => {
                return (passed >= READY_PERIOD_US).then_some(Outcome::Next(Step::AnnounceConditions));
            }
            _ => {}
        }
        let done = match host.progress() {
            Progress::Busy if passed < COMMAND_LIMIT_US => return None,
            Progress::Busy => Err(Fault::TooLate),
            Progress::Done => Ok(()),
            Progress::Failed(fault) => Err(fault),
        };
        self.has_answered |= done.is_ok() && !matches!(self.step, Step::GoIdle);
        if self.step == Step::Select && done.is_ok() && host.is_held_busy() {
            return (passed > BUSY_LIMIT_US).then_some(Outcome::Failed(SdError::StaysBusy(7)));
        }
        Some(self.after(done, host, now_us))
    }

    fn after(&mut self, done: Result<(), Fault>, host: &mut impl Host, now_us: u64) -> Outcome {
        match done {
            Ok(()) => self.after_answer(host, now_us),
            Err(fault) => self.after_fault(fault, host, now_us),
        }
    }

    fn after_fault(&mut self, fault: Fault, host: &mut impl Host, now_us: u64) -> Outcome {
        use Outcome::{Failed, Next};
        match (self.step, fault) {
            // Only cards since version 2 know CMD8, and only they may be of high capacity.
            (Step::InterfaceCondition, Fault::NoAnswer) => Next(self.first_conditions(now_us)),
            // A MultiMediaCard knows neither of these commands nor CMD8. A card that answered before and does
            // not now has gone.
            (Step::AnnounceConditions | Step::Conditions, Fault::NoAnswer) if !self.has_answered => Next(Step::AskMmc),
            (Step::AskMmc, _) => Failed(SdError::NoCard),
            // A card that cannot do the fast mode, or damages data in it, works at the usual clock.
            (
                Step::AnnounceScr
                | Step::Scr
                | Step::AskHighSpeed
                | Step::SetHighSpeed
                | Step::AnnounceScrAgain
                | Step::ScrAgain,
                _,
            ) => Next(Step::Cut),
            (Step::Cut, _) => self.stay_slow(host),
            (step, fault) => Failed(SdError::of(fault, index(step))),
        }
    }

    fn after_answer(&mut self, host: &mut impl Host, now_us: u64) -> Outcome {
        use Outcome::{Failed, Next};
        let [answer, ..] = host.answer();
        match self.step {
            Step::InterfaceCondition => {
                if answer & 0xFFF != INTERFACE_CONDITION {
                    return Failed(SdError::Unsupported(Unsupported::Voltage));
                }
                self.is_version_two = true;
                Next(self.first_conditions(now_us))
            }
            Step::AskMmc => Failed(SdError::Unsupported(Unsupported::Mmc)),
            Step::Cut => self.stay_slow(host),
            Step::GoIdle => Next(Step::InterfaceCondition),
            Step::AnnounceConditions => Next(Step::Conditions),
            Step::Conditions => self.heard_conditions(answer, now_us),
            Step::AllCids => {
                self.info.cid = Cid(host.answer());
                Next(Step::Address)
            }
            Step::Address => {
                self.info.relative_address = answer & 0xFFFF_0000;
                Next(Step::Csd)
            }
            Step::Csd => self.heard_csd(host.answer()),
            Step::Select if answer & status::CARD_IS_LOCKED != 0 => Failed(SdError::Unsupported(Unsupported::Locked)),
            Step::Select | Step::AnnounceWidth | Step::Width | Step::BlockLength
                if answer & status::ERRORS & !status::CARD_IS_LOCKED != 0 =>
            {
                Failed(refusal(index(self.step), answer & status::ERRORS))
            }
            Step::Select => Next(Step::AnnounceWidth),
            Step::AnnounceWidth => Next(Step::Width),
            Step::Width => {
                host.set_bus(self.most_hz.min(self.info.highest_hz()), true);
                Next(Step::BlockLength)
            }
            Step::BlockLength if !self.can_switch || self.most_hz <= self.info.highest_hz() => Outcome::Done,
            Step::BlockLength => Next(Step::AnnounceScr),
            Step::AnnounceScr => Next(Step::Scr),
            Step::Scr => {
                self.scr = read(host);
                if scr_knows_switch(&self.scr) { Next(Step::AskHighSpeed) } else { Outcome::Done }
            }
            Step::AskHighSpeed if offers_high_speed(&read::<64>(host)) => Next(Step::SetHighSpeed),
            Step::SetHighSpeed if has_high_speed(&read::<64>(host)) => {
                self.info.is_fast = true;
                host.set_bus(self.most_hz.min(self.info.highest_hz()), true);
                Next(Step::AnnounceScrAgain)
            }
            Step::AskHighSpeed | Step::SetHighSpeed => Outcome::Done,
            Step::AnnounceScrAgain => Next(Step::ScrAgain),
            Step::ScrAgain => {
                // The register SCR must read the same at the fast clock as at the usual one.
                if read(host) == self.scr { Outcome::Done } else { self.stay_slow(host) }
            }
            // Steps without a command were left above.
            Step::PowerCycle | Step::PowerOff | Step::FirstClocks | Step::WaitForReady => Failed(SdError::Host),
        }
    }

    /// A card that is set to high speed works at every clock up to that.
    fn stay_slow(&mut self, host: &mut impl Host) -> Outcome {
        self.info.is_fast = false;
        host.set_bus(self.most_hz.min(self.info.highest_hz()), true);
        Outcome::Done
    }

    const fn first_conditions(&mut self, now_us: u64) -> Step {
        self.began_us = now_us;
        Step::AnnounceConditions
    }

    fn heard_conditions(&mut self, conditions: u32, now_us: u64) -> Outcome {
        if conditions & READY == 0 {
            let waits = now_us.saturating_sub(self.began_us) < READY_LIMIT_US;
            return if waits { Outcome::Next(Step::WaitForReady) } else { Outcome::Failed(SdError::StaysBusy(41)) };
        }
        if conditions & OUR_VOLTAGES == 0 {
            return Outcome::Failed(SdError::Unsupported(Unsupported::Voltage));
        }
        self.conditions = conditions;
        Outcome::Next(Step::AllCids)
    }

    fn heard_csd(&mut self, words: [u32; 4]) -> Outcome {
        match Csd::of(words) {
            Ok(csd) => {
                self.info.kind = csd.kind(self.conditions & HIGH_CAPACITY != 0);
                (self.info.blocks, self.info.is_protected) = (csd.blocks, csd.is_protected);
                self.can_switch = csd.can_switch;
                Outcome::Next(Step::Select)
            }
            Err(error) => Outcome::Failed(error),
        }
    }
}

const fn register(bytes: u16) -> Transfer {
    Transfer { direction: Direction::FromCard, blocks: 1, block_bytes: bytes, place: Place::Slot(SCRATCH_SLOT) }
}

/// Returns the bytes of a register transfer.
#[inline(never)]
fn read<const BYTES: usize>(host: &impl Host) -> [u8; BYTES] {
    let (mut block, mut bytes) = ([0; BLOCK_BYTES], [0; BYTES]);
    host.load(SCRATCH_SLOT, &mut block);
    bytes.iter_mut().zip(block).for_each(|(to, from)| *to = from);
    bytes
}

const fn index(step: Step) -> u8 {
    match step {
        Step::InterfaceCondition => 8,
        Step::AnnounceConditions | Step::AnnounceWidth | Step::AnnounceScr | Step::AnnounceScrAgain => 55,
        Step::Conditions => 41,
        Step::AskMmc => 1,
        Step::AllCids => 2,
        Step::Address => 3,
        Step::Csd => 9,
        Step::Select => 7,
        Step::Width | Step::AskHighSpeed | Step::SetHighSpeed => 6,
        Step::BlockLength => 16,
        Step::Scr | Step::ScrAgain => 51,
        _ => 0,
    }
}
