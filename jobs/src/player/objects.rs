//! The objects of a print, as M486 and Klipper's `EXCLUDE_OBJECT_*` name them: the one that lines make, and
//! those that are left out.

use base::sessions::Reply;
use heapless::{String, Vec};
use motion::Part;

/// Greatest number of objects that can be told apart.
const MOST: usize = 64;
/// Greatest number of letters of a name that are shown.
const NAME: usize = 40;

/// An object of the print.
#[derive(Clone, Debug)]
struct Object {
    /// Number of the object; none for an object that only has a name.
    number: Option<u16>,
    /// Name, or its beginning if it is longer.
    name: String<NAME>,
    /// Check sum of the whole name.
    sum: u32,
    is_left_out: bool,
    /// Outline: least X and Y, greatest X and Y, mm.
    outline: Option<[f32; 4]>,
}

/// Objects of a print, as far as they are known.
#[derive(Debug, Default)]
pub struct Objects {
    /// Number of objects that the file has stated.
    count: u16,
    all: Vec<Object, MOST>,
    /// Place of the object whose lines are read.
    current: Option<usize>,
    /// The block that is read does not belong to the print.
    is_aside: bool,
    /// Objects of which planned moves are not made either, a bit each.
    cut: u64,
}

/// An object of the print, as it is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectShown<'o> {
    /// Name, or its beginning if it is longer.
    pub name: &'o str,
    /// Outline: least X and Y, greatest X and Y, mm.
    pub outline: Option<[f32; 4]>,
    /// Whether its moves are not made.
    pub is_left_out: bool,
}

/// Author of a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// The file, at its present place.
    File,
    /// A person, while the motors make this part: an object is left out at once.
    Person(Part),
}

impl Objects {
    /// The text of M486: Marlin's `T3`, `S1`, `S-1`, `AName`, `P1`, `U1` and `C`; `D`, `O`, `B`, `E`, `X`,
    /// `Y` and `R` where Klipper's commands define one, define it with an outline, begin and end one, leave
    /// one out by its name, take it in again, and take all in again. Without text says what is known.
    ///
    /// # Errors
    /// When there is no such object, or there are too many.
    pub fn label(&mut self, text: &str, by: By, reply: &mut Reply<'_>) -> Result<(), &'static str> {
        let (letter, rest) = text.split_at_checked(1).unwrap_or(("", ""));
        let rest = rest.trim();
        match letter {
            "" => self.list(by, reply),
            "T" => self.count = rest.parse().unwrap_or(0),
            "S" => return self.begin_numbered(rest),
            "A" => self.name_current(rest),
            "D" => drop(self.named(rest)),
            "O" => self.define(rest)?,
            "B" => self.current = self.named(rest),
            "E" => self.current = None,
            "P" => self.of_number(rest).map(|place| self.leave_out(place, by))?,
            "U" => self.of_number(rest).map(|place| self.take_in(place))?,
            "C" => {
                let place = self.made(by).ok_or("M486 C: no object is made now")?;
                self.leave_out(place, by);
            }
            "X" => self.of_name(rest).map(|place| self.leave_out(place, by))?,
            "Y" => self.of_name(rest).map(|place| self.take_in(place))?,
            "R" => (0..self.all.len()).for_each(|place| self.take_in(place)),
            _ => return Err("M486 takes T, S, A, P, U or C"),
        }
        Ok(())
    }

    /// Returns the object at a place, in the order in which they were named.
    #[must_use]
    pub fn shown(&self, place: usize) -> Option<ObjectShown<'_>> {
        let Object { name, outline, is_left_out, .. } = self.all.get(place)?;
        Some(ObjectShown { name, outline: *outline, is_left_out: *is_left_out })
    }

    /// Returns the place of the object whose lines are read.
    #[must_use]
    pub const fn current(&self) -> Option<usize> {
        self.current
    }

    /// Returns the rectangle around the outlines of all objects that are made: least X and Y, greatest X and
    /// Y. `None` where no outline is known, or one of them has none.
    pub fn area(&self) -> Option<[[f64; 2]; 2]> {
        let mut around: Option<[f32; 4]> = None;
        for object in self.all.iter().filter(|object| !object.is_left_out) {
            let [left, near, right, far] = object.outline?;
            let [l, n, r, f] = around.unwrap_or([left, near, right, far]);
            around = Some([l.min(left), n.min(near), r.max(right), f.max(far)]);
        }
        let [left, near, right, far] = around?.map(f64::from);
        Some([[left, near], [right, far]])
    }

    /// Defines an object and the rectangle around its outline: `x,y,x,y name`.
    fn define(&mut self, rest: &str) -> Result<(), &'static str> {
        const MEANT: &str = "M486 O takes least X and Y, greatest X and Y, and a name: O10,20,50,60 part";
        let (box_of, name) = rest.split_once(' ').ok_or(MEANT)?;
        let mut outline = [0.0_f32; 4];
        let mut numbers = box_of.split(',');
        for number in &mut outline {
            let read = numbers.next().and_then(gcode::read_f32);
            *number = read.filter(|number| number.is_finite()).ok_or(MEANT)?;
        }
        let [left, near, right, far] = outline;
        if numbers.next().is_some() || left > right || near > far {
            return Err(MEANT);
        }
        if let Some(object) = self.named(name).and_then(|place| self.all.get_mut(place)) {
            object.outline = Some(outline);
        }
        Ok(())
    }

    /// Returns the object that is made: by the motors, where a person asks, or by the line that is read.
    fn made(&self, by: By) -> Option<usize> {
        let of_motors = match by {
            By::Person(part) => usize::from(part).checked_sub(1),
            By::File => None,
        };
        of_motors.or(self.current).filter(|place| *place < self.all.len())
    }

    fn leave_out(&mut self, place: usize, by: By) {
        if let Some(object) = self.all.get_mut(place) {
            object.is_left_out = true;
            self.cut |= if by == By::File { 0 } else { 1 << place };
        }
    }

    fn take_in(&mut self, place: usize) {
        if let Some(object) = self.all.get_mut(place) {
            object.is_left_out = false;
            self.cut &= !(1 << place);
        }
    }

    // --- moves that are planned ---

    /// Whether a file or a host has named any objects.
    #[inline]
    pub fn are_known(&self) -> bool {
        !self.all.is_empty()
    }

    /// Sets whether the block that is read belongs to the print.
    pub const fn counts(&mut self, yes: bool) {
        self.is_aside = !yes;
    }

    /// Returns the part that the moves of the block being read belong to: one more than the object's place.
    #[inline]
    pub fn part(&self) -> Part {
        self.current.filter(|_| !self.is_aside).map_or(0, |place| place as Part + 1)
    }

    /// Whether moves that are planned may have to be dropped.
    #[inline]
    pub const fn is_cutting(&self) -> bool {
        self.cut != 0
    }

    /// Whether planned moves of this part have to be dropped.
    pub const fn is_cut(&self, part: Part) -> bool {
        part > 0 && self.cut >> (part - 1) & 1 != 0
    }

    /// Notes that only planned moves of these parts still wait to be dropped.
    pub fn has_cut_but(&mut self, parts: impl Iterator<Item = Part>) {
        let waiting = parts.filter(|part| *part > 0).fold(0, |bits, part| bits | 1_u64 << (part - 1));
        self.cut &= waiting;
    }

    /// Returns the objects that are left out, a bit each in the order in which the file names them.
    pub fn left_out(&self) -> u64 {
        let bits = self.all.iter().enumerate().filter(|(_, object)| object.is_left_out);
        bits.fold(0, |bits, (place, _)| bits | 1 << place)
    }

    /// Leaves out these objects, and no others.
    pub fn set_left_out(&mut self, bits: u64) {
        self.all.iter_mut().enumerate().for_each(|(place, object)| object.is_left_out = bits >> place & 1 != 0);
    }

    /// Whether the lines that are read make an object that is left out.
    pub fn is_left_out(&self) -> bool {
        self.current.and_then(|current| self.all.get(current)).is_some_and(|object| object.is_left_out)
    }

    /// Returns the name of the object that is made.
    pub fn name(&self, by: By) -> &str {
        self.made(by).and_then(|place| self.all.get(place)).map_or("none", |object| &object.name)
    }

    fn list(&self, by: By, reply: &mut Reply<'_>) {
        let count = usize::from(self.count).max(self.all.len());
        reply.say(format_args!("objects: {count}, this one: {}\n", self.name(by)));
        for object in &self.all {
            let state = if object.is_left_out { " (left out)" } else { "" };
            match object.number {
                Some(number) => reply.say(format_args!("{number}: {}{state}\n", object.name)),
                None => reply.say(format_args!("{}{state}\n", object.name)),
            }
        }
    }

    /// Begins an object by its number: `S1`, `S1 A"Name"`, `S-1`.
    fn begin_numbered(&mut self, rest: &str) -> Result<(), &'static str> {
        let (number, name) = rest.split_once('A').map_or((rest, None), |(number, name)| (number, Some(name)));
        let number = number.trim();
        if number.starts_with('-') {
            self.current = None;
            return Ok(());
        }
        let number = number.parse().map_err(|_| "M486 S: which object? A number is needed, or -1 for none")?;
        self.current = self.numbered(number);
        if let Some(name) = name {
            self.name_current(name);
        }
        Ok(())
    }

    fn name_current(&mut self, name: &str) {
        if let Some(object) = self.current.and_then(|current| self.all.get_mut(current)) {
            (object.name, object.sum) = beginning_and_sum(unquoted(name));
        }
    }

    /// Finds or adds the object of this number, and returns its place. `None` where there are too many: it
    /// cannot be left out.
    fn numbered(&mut self, number: u16) -> Option<usize> {
        let known = self.all.iter().position(|object| object.number == Some(number));
        known.or_else(|| {
            let mut name = String::new();
            // A number fits in a name.
            let _ = core::fmt::write(&mut name, format_args!("{number}"));
            let object = Object { number: Some(number), sum: sum(&name), name, is_left_out: false, outline: None };
            self.all.push(object).ok().map(|()| self.all.len() - 1)
        })
    }

    /// Finds or adds an object by its name.
    fn named(&mut self, name: &str) -> Option<usize> {
        let (name, sum) = beginning_and_sum(unquoted(name));
        let known = self.all.iter().position(|object| object.sum == sum);
        known.or_else(|| {
            let object = Object { number: None, name, sum, is_left_out: false, outline: None };
            self.all.push(object).ok().map(|()| self.all.len() - 1)
        })
    }

    fn of_number(&mut self, text: &str) -> Result<usize, &'static str> {
        let number: u16 = text.parse().map_err(|_| "M486: which object? A number is needed")?;
        let known = self.all.iter().position(|object| object.number == Some(number));
        // The object may come later in the file.
        let place = if number < self.count { self.numbered(number) } else { known };
        place.ok_or("there is no object of this number: see M486")
    }

    fn of_name(&self, name: &str) -> Result<usize, &'static str> {
        let (_, sum) = beginning_and_sum(unquoted(name));
        let place = self.all.iter().position(|object| object.sum == sum);
        place.ok_or("there is no object of this name: see EXCLUDE_OBJECT_DEFINE")
    }
}

fn unquoted(name: &str) -> &str {
    name.trim().trim_matches('"')
}

fn beginning_and_sum(name: &str) -> (String<NAME>, u32) {
    let mut beginning = String::new();
    let _ = name.chars().try_for_each(|letter| beginning.push(letter));
    (beginning, sum(name))
}

/// Returns FNV-1a of a name, in which case does not count: cut names are told apart by it.
fn sum(name: &str) -> u32 {
    name.bytes().fold(0x811C_9DC5, |sum, byte| (sum ^ u32::from(byte.to_ascii_uppercase())).wrapping_mul(0x0100_0193))
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::Desk;

    fn told(texts: &[&str]) -> (Objects, std::string::String) {
        let (mut objects, mut desk) = (Objects::default(), Desk::new());
        for text in texts {
            desk.hears(|reply| assert_eq!(objects.label(text, By::File, reply), Ok(()), "{text}"));
        }
        let known = desk.hears(|reply| assert_eq!(objects.label("", By::File, reply), Ok(())));
        (objects, known)
    }

    #[test]
    fn the_object_that_is_made_is_known() {
        for (text, name) in [
            ("T3", "none"),
            ("S0 A\"Cube (1)\"", "Cube (1)"),
            ("S0 ACube (1)", "Cube (1)"),
            ("S1", "1"),
            ("S-1", "none"),
            ("Bx", "x"),
            ("E", "none"),
        ] {
            assert_eq!(told(&[text]).0.name(By::File), name, "{text}");
        }
        assert_eq!(told(&["S1", "ABall"]).0.name(By::File), "Ball");
        assert_eq!(told(&["T3", "S0", "ABall", "P0", "S-1"]).1, "objects: 3, this one: none\n0: Ball (left out)\n");
    }

    #[test]
    fn an_object_is_left_out_by_number_by_name_or_while_it_is_made() {
        assert!(told(&["T3", "P1", "S1"]).0.is_left_out(), "before it has begun");
        assert!(!told(&["T3", "P1", "S2"]).0.is_left_out());
        assert!(told(&["S1", "C"]).0.is_left_out(), "at once");
        assert!(!told(&["S1", "C", "U1"]).0.is_left_out());
        assert!(told(&["Da", "Db", "XB", "Bb"]).0.is_left_out(), "case does not count");
        assert!(!told(&["Da", "Xa", "R", "Ba"]).0.is_left_out());
    }

    #[test]
    fn the_area_is_around_the_outlines_of_what_is_made() {
        let area = |texts: &[&str]| told(texts).0.area();
        assert_eq!(area(&[]), None);
        assert_eq!(area(&["O10,20,30,40 a"]), Some([[10.0, 20.0], [30.0, 40.0]]));
        assert_eq!(area(&["O10,20,30,40 a", "O-5,25.5,12,90 b"]), Some([[-5.0, 20.0], [30.0, 90.0]]));
        assert_eq!(area(&["O10,20,30,40 a", "O-5,25.5,12,90 b", "Xb"]), Some([[10.0, 20.0], [30.0, 40.0]]));
        assert_eq!(area(&["O10,20,30,40 a", "Db"]), None, "one could be anywhere");
        let mut desk = Desk::new();
        for text in ["O", "O1,2,3 a", "O1,2,3,4", "O3,2,1,4 a", "O1,2,3,nan a", "O1,2,3,4,5 a"] {
            desk.hears(|reply| assert!(Objects::default().label(text, By::File, reply).is_err(), "{text}"));
        }
    }

    #[test]
    fn a_person_means_what_the_motors_make_and_at_once() {
        let (mut objects, mut desk) = (told(&["S0 AOne", "S1 ATwo"]).0, Desk::new());
        let mut says = |objects: &mut Objects, text: &str, by: By| {
            desk.hears(|reply| assert_eq!(objects.label(text, by, reply), Ok(()), "{text}"))
        };
        assert_eq!(objects.part(), 2);
        assert!(says(&mut objects, "", By::Person(1)).starts_with("objects: 2, this one: One\n"));
        says(&mut objects, "C", By::Person(1));
        assert_eq!((objects.left_out(), objects.is_cut(1), objects.is_cut(2)), (0b01, true, false));
        says(&mut objects, "C", By::Person(0));
        assert_eq!((objects.left_out(), objects.is_cut(2)), (0b11, true), "while nothing moves, what is read");
        objects.has_cut_but([0, 2].into_iter());
        assert!(!objects.is_cut(1) && objects.is_cut(2));
        says(&mut objects, "U1", By::File);
        assert!(!objects.is_cutting());
        says(&mut objects, "P0", By::File);
        assert!(!objects.is_cutting(), "the file means what comes behind");
        objects.counts(false);
        assert_eq!(objects.part(), 0);
    }

    #[test]
    fn names_that_begin_alike_are_told_apart() {
        let (one, two) = (format!("{}1", "x".repeat(50)), format!("{}2", "x".repeat(50)));
        let left_out = format!("X{one}");
        assert!(told(&[&format!("D{one}"), &left_out, &format!("B{one}")]).0.is_left_out());
        assert!(!told(&[&format!("D{one}"), &left_out, &format!("B{two}")]).0.is_left_out());
    }

    #[test]
    fn what_is_not_there_cannot_be_left_out() {
        let mut desk = Desk::new();
        for text in ["P1", "Xcube", "C", "S", "P", "Q\u{e4}"] {
            desk.hears(|reply| assert!(Objects::default().label(text, By::File, reply).is_err(), "{text}"));
        }
    }

    proptest::proptest! {
        #[test]
        fn any_text_is_taken_or_refused(texts in proptest::collection::vec("[TSAPUCDOBEXYR][ -~]{0,60}", 0..100)) {
            let (mut objects, mut desk) = (Objects::default(), Desk::new());
            for text in &texts {
                desk.hears(|reply| { let _ = objects.label(text, By::File, reply); });
            }
            let _ = objects.name(By::File);
        }
    }
}
