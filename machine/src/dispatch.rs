//! One line: is it whole, what does it ask, who does it, how is it answered.

use gcode::{Block, Code, Letter, Line, Refusal};

use crate::console::Target;
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::modal::PathMode;
use crate::ports::Ports;
use crate::splines::Splines;
use crate::state::State;

/// M-codes that run while halted: ends, power, temperatures and reports.
const ALLOWED_WHILE_HALTED: [u16; 17] = [2, 5, 9, 30, 80, 81, 105, 106, 107, 112, 114, 115, 119, 500, 503, 911, 999];
/// M-codes that run on a machine whose configuration cannot be used: card and identity.
const ALLOWED_WHEN_CRIPPLED: [u16; 8] = [20, 21, 28, 29, 30, 110, 115, 112];

impl<P: Ports> Controller<P> {
    /// Runs a line from a console: its own line numbers, and an upload takes it first.
    pub(crate) async fn run_console_line(&mut self, console: u8, line: &[u8]) {
        let Some(source) = self.consoles.get_mut(console) else { return };
        match source.decoder.decode(line) {
            Ok(decoded) if self.uploads_from(console) && !matches!(decoded, Line::Console(_)) => {
                self.upload_line(line, &decoded);
            }
            Ok(decoded) => {
                // Whoever typed it reads how it went.
                let _carried_out = self.run_decoded(decoded, line).await;
            }
            Err(refusal) => self.say_refusal(refusal, line),
        }
    }

    /// Runs a line that comes from the machine itself: a file, a switch, the configuration. False when it was not carried out, which
    /// has been said.
    pub(crate) async fn run_line(&mut self, line: &[u8]) -> bool {
        match decoder_expecting(line).decode(line) {
            Ok(decoded) => return self.run_decoded(decoded, line).await,
            Err(Refusal::Resend { .. }) => {
                if let Ok(text) = core::str::from_utf8(line) {
                    self.alarm_quietly(text);
                }
            }
            Err(refusal) => self.say_refusal(refusal, line),
        }
        false
    }

    /// A line in a file whose checksum is wrong: the file is damaged.
    fn alarm_quietly(&mut self, line: &str) {
        let text = message(format_args!("checksum does not match: {line}"));
        self.alarm(&text);
    }

    async fn run_decoded(&mut self, decoded: Line<'_>, line: &[u8]) -> bool {
        match decoded {
            Line::Blank => {
                self.say(format_args!("ok\n"));
                true
            }
            Line::Console(command) => self.run_command(command).await,
            Line::Code(blocks) => self.run_blocks(blocks, line).await,
        }
    }

    async fn run_blocks(&mut self, blocks: gcode::Blocks<'_>, line: &[u8]) -> bool {
        let mut answer = Ok(Answer::Ok);
        let mut last = None;
        for block in blocks {
            let block = match block {
                Ok(block) => block,
                Err(error) => {
                    self.say_refusal(Refusal::Syntax(error), line);
                    return false;
                }
            };
            last = block.code;
            answer = self.run_block(&block).await;
            if answer.is_err() {
                break;
            }
        }
        let carried_out = answer.is_ok();
        self.say_answer(answer, last);
        carried_out
    }

    fn say_answer(&mut self, answer: Outcome, code: Option<Code>) {
        match (answer, code) {
            (Ok(Answer::Ok), _) | (Ok(Answer::Unknown), None) => self.say(format_args!("ok\n")),
            (Ok(Answer::Said), _) => {}
            (Ok(Answer::Unknown), Some(code)) => {
                // Of a file nobody reads the answers, and a G-code mostly says where to go.
                if self.target == Target::Nobody && code.letter == Letter::G {
                    self.announce(format_args!("// WARNING {code} is not known here and was passed over\n"));
                }
                self.say(format_args!("ok - {code} ignored\n"));
            }
            (Err(Failure::Halted), _) => self.say_locked(),
            (Err(Failure::Alarm(text)), _) => self.alarm(&text),
            (Err(Failure::Refused(text)), _) => {
                if self.target == Target::Nobody {
                    self.announce(format_args!("error:{text}\n"));
                }
                self.say(format_args!("error:{text}\nok\n"));
            }
        }
    }

    fn say_refusal(&mut self, refusal: Refusal, line: &[u8]) {
        if let Refusal::Resend { .. } = refusal {
            return self.say(format_args!("{refusal}\n"));
        }
        let text = core::str::from_utf8(line).unwrap_or("(not text)");
        let prefix = if self.config.general.grbl_mode { "error:" } else { "// WARNING " };
        if self.target == Target::Nobody {
            self.announce(format_args!("{prefix}gcode parse failed {refusal} - {text}\n"));
        }
        self.say(format_args!("{prefix}gcode parse failed {refusal} - {text}\n"));
        if !self.config.general.grbl_mode {
            self.say(format_args!("ok\n"));
        }
    }

    /// Runs one command, if the machine's state allows it.
    pub(crate) async fn run_block(&mut self, block: &Block<'_>) -> Outcome {
        let allowed =
            |list: &[u16]| matches!(block.code, Some(Code { letter: Letter::M, number, .. }) if list.contains(&number));
        if self.crippled && !allowed(&ALLOWED_WHEN_CRIPPLED) {
            return Err(Failure::refused("the configuration has errors: mend config.ini and reset"));
        }
        self.wait_release().await;
        if self.state == State::Halt && !self.crippled && !allowed(&ALLOWED_WHILE_HALTED) {
            return Err(Failure::Halted);
        }
        let by_switch = self.switch_code(block).await?;
        if !by_switch {
            self.needs_for(block)?;
        }
        let answer = match block.code {
            None => self.motion_words(block).await?,
            Some(code) => match code.letter {
                Letter::G => self.run_g(code, block).await?,
                Letter::M => self.run_m(code, block).await?,
                Letter::T => self.select_tool(code.number).await?,
            },
        };
        Ok(if by_switch && answer == Answer::Unknown { Answer::Ok } else { answer })
    }

    async fn run_g(&mut self, code: Code, block: &Block<'_>) -> Outcome {
        match (code.number, code.subcode) {
            (0..=3, 0) | (5, 0..=2) => self.motion_code(code, block).await,
            (5, 3) => self.close_nurbs(block).await,
            (4, 0) => self.dwell_code(block).await,
            (10, 0) if block.has('L') => self.set_offsets(block),
            (10, 0) => self.retract().await,
            (11, 0) => self.recover().await,
            (17..=21 | 49 | 53..=59 | 90 | 91, _) | (43, 0..=2) | (61, 0 | 1) | (64, 0) => {
                self.modal_code(code, block).await
            }
            (28, _) => self.home_code(code.subcode, block).await,
            (29..=32 | 38, subcode) => self.probing_code(code.number, subcode, block).await,
            (92, 0..=4) => self.g92(code.subcode, block).await,
            _ => Ok(Answer::Unknown),
        }
    }

    async fn run_m(&mut self, code: Code, block: &Block<'_>) -> Outcome {
        if code.subcode == 0
            && let Some(answer) = self.heat_code(code.number, block).await?
        {
            return Ok(answer);
        }
        match (code.number, code.subcode) {
            (2, 0) => self.end_program().await,
            (30, 0) => self.m30(block).await,
            (3 | 5, 0) => self.power_code(code.number, block),
            (17 | 18 | 84, 0) => self.motor_code(code.number, block).await,
            (20..=29 | 32, 0) => self.file_code(code.number, block).await,
            (82 | 83, 0) => {
                self.modal.e_absolute = code.number == 82;
                Ok(Answer::Ok)
            }
            (48 | 670, 0) => self.probe_m_code(code.number, block).await,
            (92, 0) => self.steps_per_mm_code(block).await,
            (110, 0) => Ok(Answer::Ok),
            (112, 0) => {
                self.halt(format_args!("ALARM: Emergency stop (M112)\n"));
                Ok(Answer::Ok)
            }
            (114, subcode) => self.report_position(subcode),
            (115, 0) => self.report_firmware(),
            (117, 0) => Ok(Answer::Ok),
            (119, 0) => self.report_endstops(),
            (120 | 121, 0) => self.save_or_restore(code.number),
            (143 | 301, 0) => self.heater_settings_code(code.number, block),
            (200 | 207 | 208 | 221, 0) => self.extruder_code(code.number, block),
            (900, 0) => self.pressure_advance_code(block).await,
            (203..=205, 0 | 1) | (220, 0) => self.limits_code(code, block),
            (206, 0) => self.home_offset_code(block),
            (303, 0) => self.autotune_code(block).await,
            (370 | 421 | 557 | 561 | 565 | 852, 0) | (374 | 375, 0 | 1) => self.levelling_code(code, block).await,
            (400, 0) => {
                self.wait_idle().await?;
                Ok(Answer::Ok)
            }
            (500..=504, 0) => self.override_code(code.number, block).await,
            (600 | 601, 0 | 1) => self.suspend_code(code).await,
            (665, 0) => self.arm_code(block).await,
            (666, 0) => self.trim_code(block),
            (906 | 907, 0) => self.current_code(code.number, block).await,
            (911, 0) => self.describe_drivers(block).await,
            (999, 0) => {
                if self.state == State::Halt {
                    self.clear_halt().await;
                }
                Ok(Answer::Ok)
            }
            _ => Ok(Answer::Unknown),
        }
    }

    /// M2, and M30 in GRBL mode.
    async fn end_program(&mut self) -> Outcome {
        if self.state == State::Halt {
            return Ok(Answer::Ok);
        }
        self.wait_idle().await?;
        self.modal.system = 0;
        self.modal.absolute = true;
        self.modal.path = PathMode::Exact;
        self.splines = Splines::default();
        self.ports.motion(|motion| motion.set_overrides(1.0, 1.0));
        Ok(Answer::Ok)
    }

    async fn m30(&mut self, block: &Block<'_>) -> Outcome {
        match block.text {
            _ if self.config.general.grbl_mode => self.end_program().await,
            Some(name) => self.remove_file(name),
            None => Ok(Answer::Ok),
        }
    }
}

/// A decoder for a line from a file: its number is taken as it is (order was checked, if at all, at the upload), its
/// checksum is not.
fn decoder_expecting(line: &[u8]) -> gcode::Decoder {
    let mut decoder = gcode::Decoder::new();
    let digits = line.trim_ascii_start().strip_prefix(b"N").unwrap_or(b"").trim_ascii_start();
    let number = digits.iter().take_while(|digit| digit.is_ascii_digit());
    let number = number.fold(0_i64, |sum, digit| sum.saturating_mul(10).saturating_add(i64::from(digit - b'0')));
    if number > 0 {
        let setting = message(format_args!("N{} M110", number - 1));
        // A number too large for the decoder is refused by it, here and with the line itself.
        let _ = decoder.decode(setting.as_bytes());
    }
    decoder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_a_file_may_have_any_number_but_must_have_its_checksum() {
        for (line, is_whole) in [
            (&b"N1 G28*18"[..], true),
            (b"N57 G28*33", true),
            (b"N57 G28*34", false),
            (b"  N57 G28", true),
            (b"G28", true),
        ] {
            let decoded = decoder_expecting(line).decode(line);
            assert_eq!(decoded.is_ok(), is_whole, "{}: {decoded:?}", line.escape_ascii());
        }
    }
}
