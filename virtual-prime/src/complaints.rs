//! Complaints of the emulator at the end of a run: a lint of the image's use of the hardware.

use rigless::mcu::Mcu;
use rigless::session::Session;
use rigless::soc::stm32h743::generated::syscfg;

use crate::board::PrimeBoard;

/// Part of the emulator's complaint about clocks above the limit of the voltage scale. The emulator knows
/// scales 1 to 3; in scale 0, which SYSCFG_PWRCR.ODEN selects (RM0399 section 7.6.2), the limits are higher
/// and the complaint is wrong.
const OVER_SCALE: &str = "for the voltage scale in use";

/// Returns the complaints of a run, one line each. Left out: [`OVER_SCALE`] in scale 0.
#[must_use]
pub fn complaints(session: &Session<PrimeBoard>) -> Vec<String> {
    let overdrive = register(session, "SYSCFG", syscfg::Register::Pwrcr) & 1 != 0;
    let told = session
        .told()
        .filter(|told| !(overdrive && told.reason.ends_with(OVER_SCALE)))
        .map(|told| format!("{} {}: {}", told.instance, told.register, told.reason));
    let refused = session.refused().values().map(|fault| format!("refused: {fault}"));
    let unimplemented = session.unimplemented().values().map(|gap| {
        format!(
            "no model: {} {} (first at pc {:#010x}, {} reads, {} writes)",
            gap.instance, gap.register, gap.program_counter, gap.reads, gap.writes
        )
    });
    let undefined = session.undefined().iter().map(|(address, gap)| {
        format!("no register at {address:#010x} in {} (first at pc {:#010x})", gap.instance, gap.program_counter)
    });
    let unmapped = session.unmapped().into_iter().map(|unmapped| unmapped.to_string());
    let unrouted =
        session.unrouted().iter().map(|(instance, line)| format!("{instance}: interrupt {line} has no line"));
    let resets =
        session.resets().iter().map(|reset| format!("reset at {:.6} s: {:?}", reset.at.0 as f64 * 1e-9, reset.cause));
    told.chain(refused)
        .chain(unimplemented)
        .chain(undefined)
        .chain(unmapped)
        .chain(unrouted)
        .chain(resets)
        .chain(session.board().wrong_modes().cloned())
        .collect()
}

fn register<R: rigless::soc::Layout>(session: &Session<PrimeBoard>, instance: &str, register: R) -> u64 {
    session.board().mcu.bus().registers(instance).map_or(0, |file| file.get(register))
}
