//! Sensors behind converter chips, read by the image over SPI1 and over the drivers' SPI4.

use rigless::mcu::Mcu;
use rigless::soc::stm32h743::generated::spi1;
use sim::models::converter::Leads;
use sim::world::Fault;

use crate::common::velvet::{Plan, SECOND, Velvet};

/// Plans a machine with the hot end's sensor behind this chip.
fn hotend(kind: &str, channel: u8) -> Plan {
    let lines = [format!("sensor = {kind}"), format!("spi_channel = {channel}"), "spi_select_pin = PD10".into()];
    lines.iter().fold(Plan::new(), |plan, line| plan.set(&format!("[temperature control] hotend.{line}")))
}

fn celsius(velvet: &mut Velvet, name: &str) -> f64 {
    velvet.world(|world| world.heater_c(world.heater_index(name).expect("a heater of this machine")))
}

/// Opens the sensor, and asserts a halt with these words within so many milliseconds.
fn opens(velvet: &mut Velvet, words: &str) {
    velvet.inject(&Fault::ThermistorOpen("hotend".into()));
    velvet.hear_until("MINTEMP or MAXTEMP triggered on T", SECOND);
    velvet.hear(50);
    let said = velvet.said();
    assert!(said.contains(words), "{said}");
    velvet.assert_safe();
}

#[test]
fn a_max31855_on_channel_0_heats_and_halts_when_it_opens() {
    let mut velvet = hotend("max31855", 0).start();
    velvet.ask("M109 S60", 60 * SECOND);
    velvet.hear(5 * SECOND);
    // The hot end overshoots on the way up.
    let is = celsius(&mut velvet, "hotend");
    assert!((57.0..70.0).contains(&is), "{is} C: {}", velvet.said());
    let registers = velvet.bench.vm.with(|stopped| {
        let bus = stopped.session.board().mcu.bus();
        bus.registers("SPI1")
            .map(|file| [spi1::Register::Cfg1, spi1::Register::Cfg2].map(|register| file.get(register)))
    });
    let [cfg1, cfg2] = registers.flatten().expect("a bus");
    // RM0399 sections 53.11.3 and 53.11.4: MBR of 200 MHz, at most 1 MHz; words of 8 bits; CPOL and CPHA
    // clear.
    assert!(200_000_000 >> ((cfg1 >> 28 & 0b111) + 1) <= 1_000_000 && cfg1 & 0x1F == 7, "{cfg1:#010x}");
    assert_eq!((cfg2 >> 25 & 1, cfg2 >> 24 & 1), (0, 0), "{cfg2:#010x}");
    opens(&mut velvet, "thermocouple open: check its plug and wires");
}

/// The chip tests the wires every five seconds, while the heater goes on; an open wire is found although the
/// reading looks right.
#[test]
fn a_max31865_tests_its_wires() {
    let mut velvet = hotend("max31865", 0).set("[temperature control] hotend.rtd_wires = 4").start();
    velvet.ask("M104 S60", SECOND);
    velvet.hear(12 * SECOND);
    assert!(!velvet.said().contains("WARNING") && celsius(&mut velvet, "hotend") > 40.0, "{}", velvet.said());
    let from = velvet.now_ms();
    velvet.inject(&Fault::SensorLead("hotend".into(), Leads::ForceOpen));
    velvet.hear_until("its FORCE wires and rtd_wires", 6 * SECOND);
    velvet.hear_until("MINTEMP or MAXTEMP triggered on T", SECOND);
    assert!(velvet.now_ms() - from < 5_600, "{} ms", velvet.now_ms() - from);
    velvet.hear(50);
    velvet.assert_safe();
}

/// Three clocks on one bus: the drivers' mode 3 at 391 kHz, the platinum chip's mode 3 and the thermocouple
/// chip's mode 0 at twice that.
#[test]
fn chips_on_channel_1_and_the_drivers_take_turns() {
    let bed = ["sensor = max31855", "spi_channel = 1", "spi_select_pin = PD12"];
    let plan =
        bed.iter().fold(hotend("max31865", 1), |plan, line| plan.set(&format!("[temperature control] bed.{line}")));
    let mut velvet = plan.start();
    velvet.ask("M104 S60", SECOND);
    velvet.ask("M140 S40", SECOND);
    velvet.ask("G28", 60 * SECOND);
    velvet.ask("M109 S60", 60 * SECOND);
    velvet.type_in("M105");
    let said = velvet.hear(100);
    let of = |label: &str| {
        let rest = said.split_once(label).map_or("", |(_, rest)| rest);
        rest.split_whitespace().next().and_then(|number| number.parse::<f64>().ok()).unwrap_or(f64::NAN)
    };
    let (hotend_c, bed_c) = (celsius(&mut velvet, "hotend"), celsius(&mut velvet, "bed"));
    assert!((of("T:") - hotend_c).abs() < 4.0 && (of("B:") - bed_c).abs() < 5.0, "{said}: {hotend_c}, {bed_c} C");
    let said = velvet.said().to_owned();
    assert!(!said.contains("WARNING") && !said.contains("motor driver"), "{said}");
    opens(&mut velvet, "platinum sensor open: check its plug, its wires and rtd_wires");
}
