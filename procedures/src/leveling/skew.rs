//! M852: skew correction of axes that are not square to each other.

use core::fmt::Write as _;

use base::bed::MeshName;
use base::failure::{Answer, Failure, Outcome};
use base::ports::{MotionPort, OpenMode, Storage, StorageError};
use base::safe_file::{self, Draft};
use base::sessions::Reply;
use motion::Skew;
use program::Words;

use super::compensation::recompensate;
use super::words::{SQUARE, configured, skew_of, square};
use base::hands::Hands;

/// Sets the skew of the configuration at boot, before anything moves.
pub fn configure(motion: &mut impl MotionPort, config: &config::MachineConfig, reply: &mut Reply<'_>) {
    let skew = configured(&config.leveling);
    if let Err(error) = motion.motion(|motion| motion.set_skew(skew)) {
        reply.say(format_args!("ERROR: config.ini: [skew correction] {error}\n"));
    }
}

/// M852: sets skew factors I (XY), J (XZ), K (YZ), or the measured lengths A (AC), B (BD), D (AD) of a square
/// in plane P; without words reports them. M852.1 reports the factor of a square, and changes nothing.
pub fn skew<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    if words.code().subcode > 1 {
        return profile(hands, words);
    }
    let measured = square(hands.texts(), words)?;
    if words.code().subcode == 1 {
        let factor = measured.ok_or_else(|| Failure::refused(&SQUARE))?;
        say_lean(hands, factor);
        return Ok(Answer::Ok);
    }
    let before = hands.motion(|motion| motion.compensation().skew());
    let changed = skew_of(hands.texts(), before, words)?;
    if let Some(skew) = changed {
        recompensate(hands, |motion| motion.set_skew(skew))?;
    }
    let skew = changed.unwrap_or(before);
    if let Some(factor) = measured {
        say_lean(hands, factor);
    }
    hands.say(format_args!("Skew factors: XY {:.8} XZ {:.8} YZ {:.8}\n", skew.xy, skew.xz, skew.yz));
    Ok(Answer::Ok)
}

/// Reports a factor in words.
fn say_lean<'c>(hands: &mut impl Hands<'c>, factor: f64) {
    let (degrees, hundred) = (libm::atan(factor).to_degrees(), 100.0 * factor);
    hands.say(format_args!(
        "The corner A is {:.3} degrees, {:+.3} mm on 100 mm: a factor of {factor:.8}\n",
        90.0 - degrees,
        hundred
    ));
}

// --- profiles ---

/// Ending of a profile's file name.
const ENDING: &str = ".skew";
/// Greatest length of a profile, bytes: a line of M852.
const LONGEST: usize = 128;

/// SKEW_PROFILE: M852.2 saves the skew under a name, M852.3 loads it, M852.4 deletes the file. The file is a
/// line as M500 writes it, so that it can be read, and played.
fn profile<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    let texts = hands.texts();
    let name = words
        .text()
        .and_then(|text| MeshName::read(text).ok())
        .ok_or_else(|| Failure::refused(&"a profile needs a name, P\"name\": 24 letters, digits, - and _ at most"))?;
    let mut path = heapless::String::<40>::new();
    // The path has room for a name of 24 letters.
    let _ = write!(path, "/sd/{}{ENDING}", name.as_str());
    let failed = |error: StorageError| texts.about_file(&path, error.text());
    match words.code().subcode {
        2 => {
            let Skew { xy, xz, yz } = hands.motion(|motion| motion.compensation().skew());
            let mut text = heapless::String::<LONGEST>::new();
            // The text has room for three factors below 1, of eight decimals.
            let _ = writeln!(text, "M852 I{xy:.8} J{xz:.8} K{yz:.8}");
            write_file(hands.storage(), &path, text.as_bytes()).map_err(failed)?;
            hands.card_has_kept().map_err(failed)?;
            hands.say(format_args!("skew saved to {path}\n"));
        }
        3 => {
            let skew = read_file(hands.storage(), &path)
                .map_err(failed)?
                .ok_or_else(|| texts.refused(format_args!("{path} holds no skew: a line M852 I J K is meant")))?;
            recompensate(hands, |motion| motion.set_skew(skew))?;
            let Skew { xy, xz, yz } = skew;
            hands.say(format_args!("Skew factors: XY {xy:.8} XZ {xz:.8} YZ {yz:.8}\n"));
        }
        _ => {
            safe_file::remove(hands.storage(), &path).map_err(failed)?;
            hands.say(format_args!("{path} deleted\n"));
        }
    }
    Ok(Answer::Ok)
}

fn write_file(storage: &mut impl Storage, path: &str, bytes: &[u8]) -> Result<(), StorageError> {
    let mut draft = Draft::begin(storage, path)?;
    match draft.write(storage, bytes) {
        Ok(_) => draft.finish(storage),
        Err(error) => {
            draft.give_up(storage);
            Err(error)
        }
    }
}

/// Reads the skew of a file; `None` when it holds none.
fn read_file(storage: &mut impl Storage, path: &str) -> Result<Option<Skew>, StorageError> {
    safe_file::settle(storage, path)?;
    let file = storage.open(path, OpenMode::Read)?;
    let mut bytes = [0; LONGEST];
    let read = storage.read(file, &mut bytes);
    // The file was only read, so closing it loses nothing.
    let _ = storage.close(file);
    let text = core::str::from_utf8(bytes.get(..read?).unwrap_or_default()).unwrap_or_default();
    Ok(parse(text))
}

fn parse(text: &str) -> Option<Skew> {
    let mut words = text.split_ascii_whitespace();
    words.next().filter(|code| *code == "M852")?;
    let mut factor = |letter| gcode::read_f64(words.next()?.strip_prefix(letter)?).filter(|factor| factor.is_finite());
    Some(Skew { xy: factor('I')?, xz: factor('J')?, yz: factor('K')? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_is_a_line_of_m852() {
        let skew = Skew { xy: 0.001_234_56, xz: -0.02, yz: 0.0 };
        assert_eq!(parse("M852 I0.00123456 J-0.02000000 K0.00000000\n"), Some(skew));
        for text in ["", "M852", "M852 I1 J2", "M852 I1 J2 Kx", "M851 I1 J2 K3", "M852 I1 J2 KNaN"] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
