//! Images with an interrupt that begins to fail on a test's command: its vector leads to a stub that looks at
//! a word of memory first.

use std::path::PathBuf;

use object::{Object, ObjectSection};
use rigless::soc::Width;
use virtual_prime::image::Symbols;

use super::velvet::Velvet;

/// Address of the word: the last word of SRAM4 (RM0399 section 2.3.2), which the firmware does not use.
const SWITCH: u32 = 0x3800_FFFC;
/// Function whose place the stub takes: nobody asks for a status meanwhile.
const PLACE: &str = "report_status";
/// Number of the core's own vectors, which come before the chip's (ARMv7-M ARM B1.5.2).
const CORE_VECTORS: u64 = 16;

/// An interrupt: its number (RM0399 section 20.1.2), its name in the image, and the register whose zero
/// acknowledges it, where there is one.
#[derive(Clone, Copy, Debug)]
pub struct Interrupt {
    number: u64,
    name: &'static str,
    acknowledge: Option<u32>,
}

/// Interrupt of the step feed. TIM6_SR, RM0399 section 46.4.4.
pub const FEED: Interrupt = Interrupt { number: 54, name: "TIM6_DAC", acknowledge: Some(0x4000_1010) };
/// Interrupt of heat control, acknowledged in TIM7_SR.
pub const HEAT: Interrupt = Interrupt { number: 55, name: "TIM7", acknowledge: Some(0x4000_1410) };
/// Interrupt of the planner; software alone asks for it, by the interrupt that `firmware/src/main.rs` names.
pub const PLANNER: Interrupt = Interrupt { number: 138, name: "LPTIM2", acknowledge: None };
/// Interrupt of the watch over drivers and supplies; software alone asks for it.
pub const SLOW_WATCH: Interrupt = Interrupt { number: 93, name: "LPTIM1", acknowledge: None };

/// Way in which an interrupt fails.
#[derive(Clone, Copy, Debug)]
pub enum Failure {
    /// The handler does nothing and returns at once.
    Skips,
    /// The handler never returns.
    Hangs,
    /// The handler calls itself without end.
    OverflowsItsStack,
    /// The handler meets an undefined instruction.
    IsNoCode,
    /// The handler panics: an index beyond an array.
    Panics,
    /// The handler raises the NMI, as the clock security system does (RM0399 section 9.5.3): the emulator's
    /// model of that system sets the flags and leaves the wire away.
    RaisesNmi,
}

/// Encodes MOVW and MOVT (ARM DDI 0403E.b, A7.7.76 encoding T3, A7.7.79), which load a number into a
/// register.
pub fn put(register: u16, value: u32) -> [u16; 4] {
    let half = |code: u16, value: u16| {
        [code | (value >> 11 & 1) << 10 | value >> 12, (value >> 8 & 7) << 12 | register << 8 | value & 0xFF]
    };
    let [a, b] = half(0xF240, value as u16);
    let [c, d] = half(0xF2C0, (value >> 16) as u16);
    [a, b, c, d]
}

const BX_LR: u16 = 0x4770;

fn stub(address: u32, interrupt: Interrupt, failure: Failure, symbols: &Symbols) -> Vec<u16> {
    let function = |name: &str| symbols.function(name).expect(name).address as u32 | 1;
    let mut code = Vec::new();
    // LDR R1, [R0]; CMP R1, #0; BNE past the way to the real handler, BX R2.
    code.extend(put(0, SWITCH));
    code.extend([0x6801, 0x2900, 0xD104]);
    code.extend(put(2, function(interrupt.name)));
    code.push(0x4710);
    match failure {
        Failure::Skips => {
            if let Some(register) = interrupt.acknowledge {
                // MOVS R1, #0; STR R1, [R0].
                code.extend(put(0, register));
                code.extend([0x2100, 0x6001]);
            }
            code.push(BX_LR);
        }
        // Encodes B to itself.
        Failure::Hangs => code.push(0xE7FE),
        // Encodes PUSH {R0-R7, LR}; B to it.
        Failure::OverflowsItsStack => code.extend([0xB5FF, 0xE7FD]),
        // Encodes UDF #0, an undefined instruction.
        Failure::IsNoCode => code.push(0xDE00),
        Failure::Panics => panics(address, &mut code, function("panic_bounds_check")),
        Failure::RaisesNmi => {
            // NMIPENDSET of ICSR (ARMv7-M ARM B3.2.4). STR R1, [R0].
            code.extend(put(0, 0xE000_ED04));
            code.extend(put(1, 1 << 31));
            code.extend([0x6001, BX_LR]);
        }
    }
    code
}

/// Calls the panic of an index with a `core::panic::Location` that lies behind the code: `test.rs:42`.
fn panics(address: u32, code: &mut Vec<u16>, panic: u32) {
    const FILE: &[u8; 8] = b"test.rs\0";
    // Three registers' numbers and BX R3: 2 + 4 + 4 + 1 halfwords.
    let end = address + 2 * (code.len() as u32 + 11);
    let location = end.next_multiple_of(4);
    // MOVS R0, #7; MOVS R1, #3.
    code.extend([0x2007, 0x2103]);
    code.extend(put(2, location));
    code.extend(put(3, panic));
    code.push(0x4718);
    code.resize((location - address) as usize / 2, 0);
    let fields = [location + 16, FILE.len() as u32 - 1, 42, 1];
    code.extend(fields.iter().flat_map(|field| [*field as u16, (*field >> 16) as u16]));
    code.extend(FILE.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])));
}

/// Writes a copy of the firmware where this interrupt fails like this from [`throw`] on.
pub fn image(interrupt: Interrupt, failure: Failure) -> PathBuf {
    let original = super::velvet::image();
    let symbols = Symbols::read(&original).expect("an ELF file");
    let place = symbols.function(PLACE).expect(PLACE).address;
    let mut bytes = std::fs::read(&original).expect("the image");
    let code = stub(place as u32, interrupt, failure, &symbols);
    let (code_at, vector_at) = {
        let file = object::File::parse(&*bytes).expect("an ELF file");
        let in_file = |address: u64| {
            let holds = |section: &object::Section<'_, '_>| {
                (section.address()..section.address() + section.size()).contains(&address)
            };
            let section = file.sections().find(holds).expect("a section of the image");
            let (start, _) = section.file_range().expect("code is in the file");
            (start + address - section.address()) as usize
        };
        let table = file.section_by_name(".vector_table").expect("vectors").address();
        (in_file(place), in_file(table + 4 * (CORE_VECTORS + interrupt.number)))
    };
    for (target, halfword) in bytes[code_at..].chunks_exact_mut(2).zip(&code) {
        target.copy_from_slice(&halfword.to_le_bytes());
    }
    bytes[vector_at..vector_at + 4].copy_from_slice(&(place as u32 | 1).to_le_bytes());
    super::seal::seal(&mut bytes);
    let copy = std::env::temp_dir().join(format!("velvet-{}-{failure:?}-{}.elf", interrupt.name, std::process::id()));
    std::fs::write(&copy, bytes).expect("a temporary file");
    copy
}

/// Makes the interrupt fail from now on.
pub fn throw(velvet: &mut Velvet) {
    let write = |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        stopped.host.write(u64::from(SWITCH), Width::W32, 1).expect("SRAM4");
    };
    velvet.bench.vm.with(write).expect("the run goes on");
}

/// Ends the failure, where the fault is one that a reset ends.
pub fn throw_back(velvet: &mut Velvet) {
    let write = |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        stopped.host.write(u64::from(SWITCH), Width::W32, 0).expect("SRAM4");
    };
    velvet.bench.vm.with(write).expect("the run goes on");
}
