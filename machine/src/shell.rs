//! Console commands: `help`, `version`, `ls`, `$G` and the like.

use gcode::Block;
use units::Axis;

use crate::console::Target;
use crate::controller::Controller;
use crate::failure::{Answer, Failure};
use crate::help::{self, COMMANDS};
use crate::ports::Ports;
use crate::state::State;

impl<P: Ports> Controller<P> {
    /// Runs a console command. False when it was not carried out, which has been said.
    pub(crate) async fn run_command(&mut self, line: &str) -> bool {
        let (word, arguments) = line.split_once([' ', '\t']).unwrap_or((line, ""));
        let arguments = arguments.trim();
        if let Some(text) = help::help(word).filter(|_| help::is_asked(arguments)) {
            self.say(format_args!("{text}\nok\n"));
            return true;
        }
        let answered = match word {
            word if word.starts_with('$') => self.dollar_command(word, arguments, line).await,
            "m23" | "m32" | "m117" => Ok(Some(Answer::Ok)),
            _ => self.shell_command(word, arguments).await,
        };
        let carried_out = matches!(answered, Ok(Some(_)));
        match answered {
            Ok(Some(Answer::Ok)) => self.say(format_args!("ok\n")),
            Ok(Some(_)) => {}
            Ok(None) if line.starts_with('$') => self.say(format_args!("error:Invalid statement\n")),
            Ok(None) => self.say(format_args!("error:Unsupported command - {line}\n")),
            Err(Failure::Halted) => self.say_locked(),
            Err(Failure::Alarm(text)) => self.alarm(&text),
            Err(Failure::Refused(text)) => self.say(format_args!("error:{text}\n")),
        }
        carried_out
    }

    async fn shell_command(&mut self, word: &str, arguments: &str) -> Result<Option<Answer>, Failure> {
        match word {
            "help" => {
                for (command, _) in COMMANDS {
                    self.say(format_args!("{command}\n"));
                }
            }
            "version" => {
                self.version_command();
                return Ok(Some(Answer::Said));
            }
            "mem" => {
                let memory = self.ports.memory();
                self.say(format_args!("static: {} bytes\n", memory.static_bytes));
                if let Some(bytes) = memory.stack_unused_bytes {
                    self.say(format_args!("stack never used: {bytes} bytes\n"));
                }
                let (millis, bytes) = (self.config_took.0 as f64 / 1_000.0, config::READING_BYTES);
                self.say(format_args!("configuration: read in {millis:.2} ms within {bytes} bytes\n"));
                return Ok(Some(Answer::Said));
            }
            "ls" => self.list_command(arguments).await,
            "cat" => {
                self.cat_command(arguments).await;
                return Ok(Some(Answer::Said));
            }
            "rm" => {
                self.remove_command(arguments);
                return Ok(Some(Answer::Said));
            }
            "mv" | "mkdir" | "cd" => self.directory_command(word, arguments),
            "echo" => self.say(format_args!("{arguments}\n")),
            "switch" => self.switch_command(arguments.split_ascii_whitespace()),
            "reset" => {
                self.say(format_args!("Reset will occur in 1 second\n"));
                self.ports.request_reset();
            }
            "config-get" | "config-set" | "config-load" | "load" => {
                return self.settings_command(word, arguments).await;
            }
            "get" => return self.get_command(arguments),
            _ => return self.job_command(word, arguments).await,
        }
        Ok(Some(Answer::Ok))
    }

    async fn job_command(&mut self, word: &str, arguments: &str) -> Result<Option<Answer>, Failure> {
        match word {
            "play" if self.crippled => {
                return Err(Failure::refused("the configuration has errors: mend config.ini and reset"));
            }
            "play" if self.state == State::Halt => return Err(Failure::Halted),
            "play" => {
                self.needs("player", "")?;
                self.play_command(arguments);
            }
            "progress" => self.progress_command(arguments),
            "abort" => self.abort_command().await,
            "suspend" | "resume" if self.state == State::Halt => return Err(Failure::Halted),
            "suspend" | "resume" if self.config.off("player", "").is_some() => self.needs("player", "")?,
            "suspend" => return self.suspend(arguments.starts_with(['l', 'h'])).await.map(Some),
            "resume" => return self.resume().await.map(Some),
            _ => return Ok(None),
        }
        Ok(Some(Answer::Ok))
    }

    async fn dollar_command(&mut self, word: &str, arguments: &str, line: &str) -> Result<Option<Answer>, Failure> {
        match word {
            "$G" => {
                let target = self.target;
                self.report_modal(target);
            }
            "$#" => self.report_offsets(arguments.trim_start_matches('-').starts_with('v')).await,
            "$H" => {
                if self.crippled || self.state == State::Halt {
                    return Err(Failure::Halted);
                }
                return self
                    .home_code(if self.config.general.grbl_mode { 2 } else { 0 }, &Block::new(None, 1))
                    .await
                    .map(Some);
            }
            "$P" => return self.probe_command(arguments).await.map(Some),
            _ if line.starts_with("$J") => {
                let rest = line.strip_prefix("$J").unwrap_or("").trim_start_matches('=');
                return self.jog_command(rest).await.map(Some);
            }
            _ => return Ok(None),
        }
        Ok(Some(Answer::Ok))
    }

    fn version_command(&mut self) {
        let board = self.ports.board();
        let axes = self.config.actuators().count();
        self.say(format_args!(
            "{} on Prime. board_id: {:02X}\nBuild version: {}, Build date: {}, System Clock: {}MHz\r\n{axes} axis, 3 primary axis\n",
            board.mcu, board.board_id, board.version, board.build_date, board.core_mhz
        ));
    }

    /// `get pos|wcs|state|status|steps|temp|volts`
    fn get_command(&mut self, arguments: &str) -> Result<Option<Answer>, Failure> {
        let mut words = arguments.split_ascii_whitespace();
        let target = self.target;
        match words.next() {
            Some("pos") => self.get_positions(),
            Some("state") => self.report_modal(target),
            Some("status") => self.report_status(target),
            Some("steps") => self.get_step_times(),
            Some("temp") => self.get_temperatures(words.next()),
            Some("volts") => self.get_volts(words.next()),
            Some("wcs") => {
                let mut name = heapless::String::<8>::new();
                // Eight characters hold every name.
                let _ = crate::modal::write_system_name(&mut name, self.modal.system);
                self.say(format_args!("[current WCS: {name}]\n"));
            }
            _ => return Err(Failure::refused("get what? pos, wcs, state, status, steps, temp, volts")),
        }
        Ok(Some(Answer::Ok))
    }

    fn get_positions(&mut self) {
        let live = self.live_position();
        let (last, now) = (self.modal.work(&self.position), self.modal.work(&live));
        for (label, position) in [("last C", last), ("realtime WCS", now), ("MCS", live), ("MP", self.position)] {
            let [x, y, z] = [Axis::X, Axis::Y, Axis::Z].map(|axis| position[axis]);
            self.say(format_args!("{label}: X:{x:.4} Y:{y:.4} Z:{z:.4}\n"));
        }
        let steps = self.ports.motion(|motion| motion.steps());
        self.say(format_args!("RAW:"));
        for axis in Axis::ALL {
            let count = steps.0.get(axis as usize).copied().unwrap_or(0);
            self.say(format_args!(" {}:{count}", axis.letter()));
        }
        self.say(format_args!("\n"));
    }

    fn get_temperatures(&mut self, name: Option<&str>) {
        if name.is_none_or(|name| name == "chip")
            && let Some(celsius) = self.ports.chip_celsius()
        {
            self.say(format_args!("chip temp: {:.6}\n", celsius.0));
        }
        let Self { ports, config, consoles, target, .. } = self;
        ports.heat(|heat| {
            for ((_, controller), (_, heater)) in config.heaters().zip(heat.heaters()) {
                if name.is_some_and(|name| name != controller.name) {
                    continue;
                }
                let reading = heater.reading().map_or(f32::INFINITY, |celsius| celsius.0);
                let (id, goal, duty) = (controller.tool_id, heater.target().0, heater.duty().0);
                consoles.write(
                    *target,
                    format_args!(
                        "{}: {} ({id}) temp: {reading:.6}/{goal:.6} @{duty}\n",
                        controller.name, controller.designator
                    ),
                );
            }
        });
    }

    fn get_volts(&mut self, name: Option<&str>) {
        let say = |this: &mut Self, name: &str| match this.ports.voltage(name) {
            Some(volts) => this.say(format_args!("{name}: {:.6} v\n", volts.0)),
            None => this.say(format_args!("{name}: INF\n")),
        };
        match name {
            Some(name) => say(self, name),
            None => {
                for index in 0..self.config.voltages.len() {
                    if let Some(name) = self.config.voltages.get(index).map(|monitor| monitor.name.clone()) {
                        say(self, &name);
                    }
                }
            }
        }
    }

    /// Whether the present line came from a console, which then has a stop request of its own.
    pub(crate) const fn is_from_a_console(&self) -> bool {
        matches!(self.target, Target::Console(_))
    }
}
