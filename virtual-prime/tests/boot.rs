//! The boot stage: its time at a start, and the state in which it leaves the chip to the application.

use crate::common::MS;
use crate::common::velvet::Plan;

/// Address of RCC_CFGR (RM0399 section 9.7.6), and its field SW.
const RCC_CFGR: u64 = 0x5802_4410;
const SW: u64 = 0b111;
const HSI: u64 = 0b000;
const PLL: u64 = 0b011;
/// Time limit for the image under test, with which a full flash is over as well. The digest takes 61
/// instructions a byte: a faster one (38) is 6.6 kB longer, in the image as well.
const LIMIT_NS: u64 = 275 * MS;

/// The limit counts instructions, one a cycle: on silicon the digest of an image takes about as many cycles
/// as here instructions, as the core issues two at a time and waits now and then.
#[test]
fn an_ordinary_start_is_soon_over() {
    let mut velvet = Plan::new().watching(RCC_CFGR..RCC_CFGR + 4).held();
    velvet.bench.vm.run_for(LIMIT_NS);
    let switches = velvet.bench.writes.take();
    let to_pll = switches.iter().position(|write| write.value & SW == PLL).expect("it runs from the PLL");
    let handed_over = switches[to_pll..].iter().find(|write| write.value & SW == HSI).expect("it is over");
    println!("after {} us", handed_over.at_ns / 1000);
}
