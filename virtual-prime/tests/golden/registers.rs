//! Reading of the registers of every block on the bus.
//!
//! Left out: registers that can only be read or only be written (states and commands, not configuration),
//! second names of the same register (timer inputs, the views of one core on RCC and EXTI), and words that a
//! read would take away.

use std::collections::BTreeMap;

use rigless::emulator::{Access, AccessKind};
use rigless::mcu::Mcu;
use rigless::soc::{Access as Directions, Layout, ReadAction, RegisterSpec, Width};

use crate::common::velvet::Velvet;

/// Register values by name, as `RCC.CR`.
pub type Registers = BTreeMap<String, u64>;

/// A row of any register table, by its number.
#[derive(Clone, Copy, Debug)]
struct Row(usize);

impl Layout for Row {
    const REGISTERS: &'static [RegisterSpec] = &[];

    fn from_index(index: usize) -> Option<Self> {
        Some(Self(index))
    }

    fn index(self) -> usize {
        self.0
    }
}

fn is_configuration(table: &[RegisterSpec], row: usize) -> bool {
    let register = &table[row];
    let both_ways = !matches!(register.access, Directions::ReadOnly | Directions::WriteOnly);
    let second_name = table[..row].iter().any(|earlier| earlier.offset == register.offset);
    both_ways && !second_name && register.read == ReadAction::None && !register.name.starts_with("C1_")
}

/// Reads the present values of all registers.
pub fn registers(velvet: &mut Velvet) -> Registers {
    let all = velvet.bench.vm.with(|stopped| {
        let at = stopped.stop.at;
        let mcu = &mut stopped.session.board_mut().mcu;
        let mut all = Registers::new();
        for slot in 0..mcu.bus().slots().len() {
            let (bus, model) = mcu.split(slot);
            let (registers, block) = (bus.slots()[slot].registers(), bus.slots()[slot].peripheral());
            for row in (0..block.registers.len()).filter(|row| is_configuration(block.registers, *row)) {
                let shown = model.as_ref().and_then(|model| model.peek(row, registers, at));
                let name = format!("{}.{}", block.name, block.registers[row].name);
                all.insert(name, shown.unwrap_or_else(|| registers.get(Row(row))));
            }
        }
        all
    });
    let mut all = all.expect("the run goes on");
    all.insert("PWR.CR3".into(), supply(velvet));
    all
}

/// Reads PWR_CR3 as the core does: the model behind it is of a part without the SMPS converter, and holds
/// another value.
fn supply(velvet: &mut Velvet) -> u64 {
    /// Address of PWR_CR3, RM0399 section 7.8.4.
    const PWR_CR3: u64 = 0x5802_480C;
    let read = |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        let access =
            Access::new(AccessKind::Read, PWR_CR3, Width::W32, 0).at(stopped.stop.instruction_count, stopped.stop.at);
        stopped.session.access(access, stopped.host).0
    };
    velvet.bench.vm.with(read).expect("the run goes on")
}
