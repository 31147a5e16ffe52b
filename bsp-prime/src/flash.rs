//! The chip's flash as updates see it ([`update::Flash`]): two banks of eight sectors, programmed in words of
//! 32 bytes (RM0399 chapter 4).
//!
//! A bank that is erased or programmed cannot be read meanwhile: any access, of code or data, waits (RM0399
//! section 4.3.7). A word takes 0.1 ms and the step interrupt needs no flash, so the application may write a
//! word at any time. An erase takes seconds, and only the boot stage erases: the code that waits for its end
//! runs from ITCM with interrupts off.
//!
//! The waits for the end of an operation have no bound of their own. There is no way to end an operation, and
//! a bank that never ends one stalls the core with the next fetch from it: the watchdog bounds the waits.

use core::ops::Range;
use core::ptr::addr_of;

use cortex_m::peripheral::SCB;
use stm32h7xx_hal::pac;
use update::{Failed, Flash, Sector, Unreadable, WORD, Word};

/// The array's first address and its size (RM0399 section 4.3.4).
const START: u32 = 0x0800_0000;
const BYTES: u32 = 2 * BANK_BYTES;
const BANK_BYTES: u32 = 1 << 20;
const SECTORS_OF_A_BANK: u32 = 8;

/// The keys of KEYR, in order (RM0399 section 4.5.1).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// Program and erase 64 bits at a time, which VDD of 3.3 V allows (RM0399 section 4.3.9).
const PARALLELISM: u8 = 0b11;
/// Flags of SR (RM0399 section 4.9.5), which CCR clears at the same places: BSY, QW; WRPERR, PGSERR, STRBERR,
/// INCERR, OPERR; RDPERR and RDSERR, which block what comes after them; EOP, SNECCERR, DBECCERR.
mod flag {
    pub const BUSY: u32 = 1 << 0 | 1 << 2;
    pub const FAILED: u32 = 1 << 17 | 1 << 18 | 1 << 19 | 1 << 21 | 1 << 22;
    pub const ALL: u32 = FAILED | 1 << 16 | 1 << 23 | 1 << 24 | 1 << 25 | 1 << 26;
}

/// CCR of the core: BFHFNMIGN, data bus faults at the priority of FAULTMASK are passed over (ARMv7-M ARM
/// B3.2.8).
const IGNORE_BUS_FAULTS: u32 = 1 << 8;
/// CFSR: PRECISERR, IMPRECISERR, BFARVALID (B3.2.15); written ones clear.
const BUS_FAULT: u32 = 1 << 9 | 1 << 10 | 1 << 15;

/// Access to the flash for reading and writing.
#[derive(Debug)]
pub struct BoardFlash {
    registers: pac::FLASH,
}

impl BoardFlash {
    /// Takes the flash. From now on a word that its error correction cannot read is an error instead of a
    /// fault.
    pub(crate) fn new(registers: pac::FLASH, scb: &mut SCB) -> Self {
        // SAFETY: BFHFNMIGN alone changes, which matters where FAULTMASK is set: in `read_guarded`.
        unsafe { scb.ccr.modify(|ccr| ccr | IGNORE_BUS_FAULTS) };
        Self { registers }
    }

    fn bank(&self, at: u32) -> &pac::flash::BANK {
        if at < BANK_BYTES { self.registers.bank1() } else { self.registers.bank2() }
    }

    /// Opens a bank's control register and clears what earlier operations, or reads, have left.
    fn open(&self, at: u32) -> Result<&pac::flash::BANK, Failed> {
        let bank = self.bank(at);
        if bank.sr.read().bits() & flag::BUSY != 0 {
            return Err(Failed);
        }
        // SAFETY: ones clear flags.
        bank.ccr.write(|w| unsafe { w.bits(flag::ALL) });
        if bank.cr.read().lock().bit_is_set() {
            for key in KEYS {
                // SAFETY: RM0399 section 4.5.1: the two keys in this order, with no other write between.
                bank.keyr.write(|w| unsafe { w.bits(key) });
            }
        }
        if bank.cr.read().lock().bit_is_set() { Err(Failed) } else { Ok(bank) }
    }

    /// Closes the control register and returns the result of the operation.
    fn close(bank: &pac::flash::BANK) -> Result<(), Failed> {
        let status = bank.sr.read().bits();
        // SAFETY: everything off, locked.
        bank.cr.write(|w| unsafe { w.psize().bits(PARALLELISM).lock().set_bit() });
        if status & flag::FAILED == 0 { Ok(()) } else { Err(Failed) }
    }
}

impl Flash for BoardFlash {
    fn read(&mut self, at: u32) -> Result<Word, Unreadable> {
        if at > BYTES - WORD as u32 || !at.is_multiple_of(WORD as u32) {
            return Err(Unreadable);
        }
        let mut word = [0; WORD];
        self.read_into(at, &mut word).map(|()| word)
    }

    fn read_into(&mut self, at: u32, into: &mut [u8]) -> Result<(), Unreadable> {
        if u64::from(at) + into.len() as u64 > u64::from(BYTES) {
            return Err(Unreadable);
        }
        if read_guarded((START + at) as *const u8, into) {
            return Ok(());
        }
        for bank in [self.registers.bank1(), self.registers.bank2()] {
            // SAFETY: ones clear flags.
            bank.ccr.write(|w| unsafe { w.bits(flag::ALL) });
        }
        Err(Unreadable)
    }

    fn program(&mut self, at: u32, word: &Word) -> Result<(), Failed> {
        if at > BYTES - WORD as u32 || !at.is_multiple_of(WORD as u32) {
            return Err(Failed);
        }
        let bank = self.open(at)?;
        // SAFETY: RM0399 section 4.3.9, single write sequence: PG, eight stores in one flash word, then the
        // hardware programs it.
        unsafe {
            bank.cr.modify(|_, w| w.psize().bits(PARALLELISM).pg().set_bit());
            // Flash is normal memory, the register a device: only a barrier orders their accesses.
            cortex_m::asm::dsb();
            let to = (START + at) as *mut u32;
            for (index, bytes) in word.chunks_exact(4).enumerate() {
                let value = bytes.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
                to.add(index).write_volatile(value);
            }
        }
        cortex_m::asm::dsb();
        while bank.sr.read().bits() & flag::BUSY != 0 {}
        Self::close(bank)?;
        forget_cached(at..at + WORD as u32);
        if self.read(at) == Ok(*word) { Ok(()) } else { Err(Failed) }
    }

    fn erase(&mut self, sector: Sector) -> Result<(), Failed> {
        // Sector 0 holds the boot stage and is never erased.
        if sector.0 == 0 || sector.0 >= 2 * SECTORS_OF_A_BANK {
            return Err(Failed);
        }
        let sector_bytes = BANK_BYTES / SECTORS_OF_A_BANK;
        let at = sector.0 * sector_bytes;
        let bank = self.open(at)?;
        // RM0399 section 4.3.10, sector erase sequence: SER and SNB, then START, then the end of QW.
        let number = (sector.0 % SECTORS_OF_A_BANK) as u8;
        // SAFETY: the fields' values are in range.
        bank.cr.modify(|_, w| unsafe { w.psize().bits(PARALLELISM).ser().set_bit().snb().bits(number) });
        let start = bank.cr.read().bits() | START_ERASE;
        // SAFETY: the registers are this bank's, whose owner this value is.
        cortex_m::interrupt::free(|_| unsafe { start_and_wait(bank.cr.as_ptr(), start, bank.sr.as_ptr()) });
        let result = Self::close(bank);
        forget_cached(at..at + sector_bytes);
        result
    }
}

/// Control register CR: bit START.
const START_ERASE: u32 = 1 << 7;

/// Begins an erase and waits for its end. From ITCM: while the bank is busy nothing can be fetched from it.
///
/// # Safety
/// `control` and `status` are CR and SR of an unlocked bank, and interrupts are off: their handlers are in
/// flash.
#[unsafe(link_section = ".itcm.flash_erase")]
#[inline(never)]
unsafe fn start_and_wait(control: *mut u32, start: u32, status: *mut u32) {
    // SAFETY: registers, as the caller says.
    unsafe {
        control.write_volatile(start);
        core::arch::asm!("dsb");
        while status.read_volatile() & flag::BUSY != 0 {}
    }
}

/// Copies bytes of the flash, and returns whether the error correction could restore them. If two bits of a
/// word are wrong, the flash answers with a bus error (RM0399 section 4.7.9).
///
/// No exception but the NMI is taken meanwhile: 512 bytes are read at once at most, which takes 2 us.
fn read_guarded(from: *const u8, into: &mut [u8]) -> bool {
    // SAFETY: the caller's range lies in flash, where every address may be read. With FAULTMASK set and
    // BFHFNMIGN a bus error is noted in CFSR alone, and the load gives anything.
    unsafe {
        core::arch::asm!("cpsid f", options(nostack, preserves_flags));
        from.copy_to_nonoverlapping(into.as_mut_ptr(), into.len());
        cortex_m::asm::dsb();
        let status = addr_of!((*SCB::PTR).cfsr).cast::<u32>().cast_mut();
        let faults = status.read_volatile() & BUS_FAULT;
        if faults != 0 {
            status.write_volatile(faults);
        }
        core::arch::asm!("cpsie f", options(nostack, preserves_flags));
        faults == 0
    }
}

/// Invalidates the data cache for these bytes, counted from the beginning of the flash.
fn forget_cached(bytes: Range<u32>) {
    // SAFETY: the flash is write-through, so no line of it is dirty and nothing is lost; the range is whole
    // lines.
    unsafe {
        let mut core = cortex_m::Peripherals::steal();
        core.SCB.invalidate_dcache_by_address((START + bytes.start) as usize, bytes.len());
    }
}
