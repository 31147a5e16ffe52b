//! From reset to a machine that listens: configuration, motion, heat, wiring, drivers, in this order.
//!
//! Whatever is wrong with the configuration is said on every console with its line. An error leaves the part it concerns off;
//! a fatal one leaves the machine safe: nothing is wired, nothing moves or heats, but consoles and card work, so that the file
//! can be mended over them.

use config::{BoardId, Diagnostic, DriverKind, MachineConfig, Reader, Summary};
use heapless::Vec;
use units::{Actuator, Duty, Micros};

use crate::console::Target;
use crate::controller::Controller;
use crate::heat::HeaterSettings;
use crate::modal::Modal;
use crate::motion_config::motion_config;
use crate::ports::{MotorDrivers, OpenMode, Ports, StorageError};
use crate::safe_file;
use crate::state::Event;
use crate::supervisor::DriverTrouble;
use crate::switches::SwitchBank;
use crate::tools::Tools;
use crate::wait::yield_once;

/// Where the configuration is.
pub const CONFIG_PATH: &str = "/sd/config.ini";
/// The motor supply has been read by then: two periods of the slow task, and its conversions.
const SUPPLY_READING_TIMEOUT: Micros = Micros::from_millis(250);
/// Findings that are told one by one; the rest is counted.
const FINDINGS: usize = 12;

impl<P: Ports> Controller<P> {
    pub(crate) async fn boot(&mut self) {
        self.consoles.set_count(self.ports.consoles());
        self.target = Target::All;
        let board = self.ports.board();
        self.say(format_args!("Velvet {} on Prime, board id {}\n", board.version, board.board_id));
        if board.after_watchdog {
            self.say(format_args!("WARNING: the watchdog reset the board: the firmware had stopped answering\n"));
        }
        if board.second_core_starts {
            self.say(format_args!(
                "WARNING: the chip's second core (Cortex-M4) is set to start and may run anything: set the option byte BCM4 to \
                 0, with STM32CubeProgrammer: STM32_Programmer_CLI -c port=SWD -ob BCM4=0\n"
            ));
        }
        let mut findings = Vec::new();
        let since = self.ports.now();
        let read = self.read_config(&mut findings).await;
        self.config_took = self.ports.now().since(since);
        let usable = self.report_config(&findings, read).await;
        if usable {
            self.start_machine().await;
        }
        self.crippled = !usable || self.crippled;
        if self.crippled {
            self.apply(Event::Halt);
            self.say(format_args!(
                "There was a fatal error in the config.ini this must be fixed to continue\nOnly some shell commands are \
                 allowed and sdcard access\n"
            ));
        } else {
            self.load_at_boot().await;
            self.queue_boot_files();
        }
        self.say(format_args!("Welcome to Smoothie\nok\n"));
        self.drain().await;
    }

    async fn read_config(&mut self, findings: &mut Vec<Diagnostic, FINDINGS>) -> Result<Summary, StorageError> {
        self.ports.mount()?;
        // A change that a power cut stopped half way.
        safe_file::settle(&mut self.ports, CONFIG_PATH)?;
        let file = self.ports.open(CONFIG_PATH, OpenMode::Read)?;
        let board = BoardId::from_id(self.ports.board().board_id);
        let mut reader = Reader::new(&mut self.config, board, findings);
        let mut chunk = [0; 512];
        loop {
            match self.ports.read(file, &mut chunk)? {
                0 => break,
                count => reader.feed(chunk.get(..count).unwrap_or(&[])),
            }
        }
        let summary = reader.finish();
        self.ports.close(file)?;
        Ok(summary)
    }

    /// Says what was found; true when the machine may be started.
    async fn report_config(
        &mut self,
        findings: &Vec<Diagnostic, FINDINGS>,
        read: Result<Summary, StorageError>,
    ) -> bool {
        for finding in findings {
            self.say(format_args!("config.ini: {finding}\n"));
            self.drain().await;
        }
        match read {
            Err(error) => {
                self.say(format_args!("ERROR: cannot read {CONFIG_PATH}: {}\n", error.text()));
                false
            }
            Ok(summary) => {
                let told = findings.len() as u32;
                let more = summary.total().saturating_sub(told);
                if more > 0 {
                    self.say(format_args!("config.ini: and {more} more\n"));
                }
                if summary.is_usable() {
                    self.tell_what_is_off();
                }
                summary.is_usable()
            }
        }
    }

    /// Sets every part up from the configuration. What fails cripples the machine.
    async fn start_machine(&mut self) {
        self.modal = Modal::new(self.config.motion.default_feed_rate, self.config.motion.default_seek_rate);
        if let Some(offset) = self.config.motion.set_g92 {
            self.modal.g92 = offset;
        }
        self.tools = Tools::new(&self.config.extruders);
        self.switches = SwitchBank::new(&self.config.switches);
        let now = self.ports.now();
        self.limits.configure(&self.config, now);
        self.configure_motion();
        self.configure_levelling();
        self.configure_heat();
        self.wire();
        if !self.crippled {
            self.switches_to_startup_state();
            self.ports.heat(crate::heat::HeatControl::enable_outputs);
            self.ports.supervisor(|supervisor| supervisor.expect_fet_supply(true));
            self.await_supply_reading().await;
            self.configure_drivers();
        }
    }

    fn configure_motion(&mut self) {
        let configured = match motion_config(&self.config) {
            Ok(config) => self.ports.motion(|motion| motion.configure(config)),
            Err(solution) => {
                self.say(format_args!(
                    "ERROR: config.ini: the geometry of arm_solution {solution:?} fits no machine\n"
                ));
                self.crippled = true;
                return;
            }
        };
        if let Err(error) = configured {
            self.say(format_args!("ERROR: config.ini: {error}\n"));
            self.crippled = true;
        }
    }

    fn configure_heat(&mut self) {
        let Self { ports, config, .. } = self;
        let all_fit = ports
            .heat(|heat| config.temperatures.iter().all(|heater| heat.add(HeaterSettings::from(heater)).is_some()));
        if !all_fit {
            self.say(format_args!("ERROR: config.ini: more temperature controls than this board has\n"));
            self.crippled = true;
        }
    }

    fn wire(&mut self) {
        let Self { ports, config, consoles, .. } = self;
        let mut report = |text: &str| consoles.write(Target::All, format_args!("ERROR: config.ini: {text}\n"));
        if !ports.wire(config, &mut report) {
            self.crippled = true;
        }
    }

    /// Lets the motor supply's monitor give its first reading: drivers without supply are not to be called silent.
    async fn await_supply_reading(&mut self) {
        if !self.config.voltages.iter().any(|monitor| monitor.name == "vmotor") {
            return;
        }
        let since = self.ports.now();
        while self.ports.voltage("vmotor").is_none() && self.ports.now().since(since) < SUPPLY_READING_TIMEOUT {
            self.ports.report_alive();
            yield_once().await;
        }
    }

    /// Writes the drivers' registers and currents. Without motor supply they cannot answer; the supervisor does it when
    /// the supply comes.
    fn configure_drivers(&mut self) {
        let internal = internal_motors(&self.config);
        let check = self.config.motors.check_driver_errors;
        self.ports.supervisor(|supervisor| supervisor.configure(internal, check));
        let supplied = self.ports.voltage("vmotor").is_none_or(|volts| volts >= crate::supervisor::MOTOR_SUPPLY_OFF);
        for motor in Actuator::ALL {
            if internal & motor.bit() == 0 || !supplied {
                continue;
            }
            let current = self.config.actuators[motor].current;
            let set = self.ports.drivers(|drivers| {
                drivers.initialise(motor)?;
                current.map_or(Ok(None), |amps| drivers.set_current(motor, amps).map(Some))
            });
            if set.is_err() {
                self.ports.supervisor(|supervisor| supervisor.mark_told(motor, DriverTrouble::Silent));
                self.announce(format_args!(
                    "ERROR: motor driver {} does not answer, check its supply and SPI wiring\n",
                    motor.name()
                ));
            }
        }
        self.ports.set_motor_power(true);
    }

    /// Boot states of switch outputs.
    fn switches_to_startup_state(&mut self) {
        for index in 0..self.config.switches.len() {
            self.drive_switch_at_startup(index);
        }
    }
}

/// Motors with a driver of ours, one bit each.
pub(crate) fn internal_motors(config: &MachineConfig) -> u8 {
    config
        .actuators()
        .filter(|(_, actuator)| actuator.driver != DriverKind::External)
        .fold(0, |bits, (motor, _)| bits | motor.bit())
}

/// Full on or off, for a digital output.
pub(crate) const fn full_or_off(on: bool) -> Duty {
    if on { Duty::FULL } else { Duty::OFF }
}
