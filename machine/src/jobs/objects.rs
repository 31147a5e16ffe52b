//! Which object of a file its lines make, as M486 and `EXCLUDE_OBJECT_START` say. Nothing is left out by it.

use heapless::String;

use crate::sessions::Reply;

/// What is known of the objects of a file.
#[derive(Debug, Default)]
pub struct Objects {
    /// How many the file has said that there are.
    count: u32,
    /// The one whose lines are read; empty for none.
    current: String<32>,
}

impl Objects {
    /// The text of M486: Marlin's `T3`, `S1`, `S-1`, `ACube`; `D`, `B` and `E` where Klipper's commands
    /// define, begin and end one. Without text says what is known.
    pub fn label(&mut self, text: &str, reply: &mut Reply<'_>) -> Result<(), &'static str> {
        let (letter, rest) = text.split_at_checked(1).unwrap_or(("", ""));
        let rest = rest.trim();
        match letter {
            "" => reply.say(format_args!("objects: {}, this one: {}\n", self.count, self.name())),
            "T" => self.count = rest.parse().unwrap_or(0),
            "D" => self.count = self.count.saturating_add(1),
            "S" | "A" | "B" => {
                let (number, name) = rest.split_once(" A").unwrap_or(("", rest));
                self.current.clear();
                if !(letter == "S" && (rest.starts_with('-') || number.starts_with('-'))) {
                    // A long name is cut: it is shown, no more.
                    let _ = name.chars().try_for_each(|letter| self.current.push(letter));
                }
            }
            "E" => self.current.clear(),
            _ => return Err("M486: objects cannot be left out yet"),
        }
        Ok(())
    }

    /// The object whose lines are read.
    pub fn name(&self) -> &str {
        if self.current.is_empty() { "none" } else { &self.current }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::bench::Desk;

    #[test]
    fn the_object_that_is_made_is_known() {
        let (mut objects, mut desk) = (Objects::default(), Desk::new());
        for (text, name) in [
            ("T3", "none"),
            ("S0 ACube (1)", "Cube (1)"),
            ("S1", "1"),
            ("ABall", "Ball"),
            ("S-1", "none"),
            ("Bx", "x"),
            ("E", "none"),
        ] {
            desk.hears(|reply| assert_eq!(objects.label(text, reply), Ok(())));
            assert_eq!(objects.name(), name, "{text}");
        }
        assert_eq!(desk.hears(|reply| assert!(objects.label("", reply).is_ok())), "objects: 3, this one: none\n");
        desk.hears(|reply| assert!(objects.label("P1", reply).is_err()));
        desk.hears(|reply| assert!(objects.label("Q\u{e4}", reply).is_err()));
    }
}
