//! Values that a macro sees while it is rendered: its variables and parameters, the configuration's text, the
//! machine. Everything is looked up when it is asked for; nothing else happens meanwhile, so it is as it was
//! when the macro was called.

use core::fmt::Write as _;
use core::marker::PhantomData;

use ::macros::{Action, Environment, Given, Kind, Object};
use base::bed::MeshName;
use base::failure::Failure;
use base::reason::Alarm;
use base::snapshot::Snapshot;
use gcode::Extended;
use printer_cfg::{Scratch, Section, Setting, Trouble, Use};

use super::hands::{MacroHands, Seen, refused};
use super::objects::{self, Thing};
use super::{saved, status};

/// Words that a macro was called with.
pub(super) enum Parameters<'p> {
    /// Keys and values of a command by name.
    Named(Extended<'p>),
    /// Letters and numbers behind a code, or its text.
    Coded(&'p str),
}

impl Parameters<'_> {
    /// Keys and values in their order.
    fn at(&self, place: usize) -> Option<(&str, &str)> {
        match self {
            Self::Named(command) => command.parameters().nth(place),
            Self::Coded(words) => {
                words.split_ascii_whitespace().map(|word| word.split_at_checked(1).unwrap_or((word, ""))).nth(place)
            }
        }
    }

    /// Returns the value of a parameter, whose name is in upper case.
    fn get(&self, name: &str) -> Option<&str> {
        if name.bytes().any(|byte| byte.is_ascii_lowercase()) {
            return None;
        }
        let all = (0..).map_while(|place| self.at(place));
        all.filter(|(key, _)| key.eq_ignore_ascii_case(name)).last().map(|(_, value)| value)
    }

    fn rest(&self) -> &str {
        match self {
            Self::Named(command) => command.rest(),
            Self::Coded(words) => words,
        }
    }
}

/// Whether a macro may do something while it is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Acts {
    /// What it asks for is done at once.
    AtOnce,
    /// Nothing is done: a file is looked at.
    Never,
}

/// The machine as a macro sees it.
pub(super) struct Look<'l, 'c, H> {
    pub hands: &'l mut H,
    section: Section,
    parameters: &'l Parameters<'l>,
    pub snapshot: &'l Snapshot,
    /// Reason for which the macro cannot go on, beside its own errors.
    trouble: Option<Failure>,
    acts: Acts,
    /// The macro has asked for something that may be otherwise later.
    pub depends_on_state: bool,
    of: PhantomData<&'c ()>,
}

impl<'l, 'c, H: MacroHands<'c>> Look<'l, 'c, H> {
    /// Looks at the machine for a macro of a section.
    pub fn new(
        hands: &'l mut H,
        section: Section,
        parameters: &'l Parameters<'l>,
        snapshot: &'l Snapshot,
        acts: Acts,
    ) -> Self {
        Self { hands, section, parameters, snapshot, trouble: None, acts, depends_on_state: false, of: PhantomData }
    }

    /// Takes the reason why the macro cannot go on.
    pub const fn take_trouble(&mut self) -> Option<Failure> {
        self.trouble.take()
    }

    fn text(&mut self) -> &mut Scratch {
        self.hands.macros().memory.text
    }

    /// Gives the text that was read last. One that is too long is an error, never cut.
    pub(super) fn read_text<'t>(&'t mut self, give: fn(&'t str) -> Given<'t>) -> Option<Given<'t>> {
        if self.text().is_cut() {
            let texts = self.hands.world().texts;
            self.trouble = Some(texts.refused(format_args!("a value has more than {} bytes", printer_cfg::SCRATCH)));
            return None;
        }
        self.text().text().map(give)
    }

    /// Gives a text that is written.
    pub fn write<'t>(
        &'t mut self,
        text: core::fmt::Arguments<'_>,
        give: fn(&'t str) -> Given<'t>,
    ) -> Option<Given<'t>> {
        let scratch = self.text();
        scratch.fill(core::iter::empty());
        // Too much of it is seen by its length.
        let _ = scratch.write_fmt(text);
        self.read_text(give)
    }

    /// Reads an option into memory. False: there is none.
    fn read_option(&mut self, section: Section, key: &str) -> bool {
        let Seen { macros, world, .. } = self.hands.seen();
        let memory = &mut macros.memory;
        match memory.store.read((section, key), &mut world.ports, |text| memory.text.fill(text)) {
            Ok(read) => read.is_some(),
            Err(trouble) => self.fail(&trouble),
        }
    }

    fn fail(&mut self, trouble: &Trouble) -> bool {
        self.trouble = Some(refused(self.hands, trouble));
        false
    }

    /// Gives a variable of a macro.
    fn variable_of(&mut self, section: Section, name: &str) -> Option<Given<'_>> {
        if !self.hands.macros().memory.store.has(section, Use::Variables) {
            return None;
        }
        self.depends_on_state |= self.hands.macros().memory.store.looks().changes_variables;
        // A name with upper case cannot be: the configuration's options have none.
        let mut key = heapless::String::<96>::new();
        write!(key, "variable_{name}").ok()?;
        if self.hands.macros().memory.variables.get(section, name).is_some() {
            return self.hands.macros().memory.variables.get(section, name).map(Given::Literal);
        }
        if self.read_option(section, &key) { self.read_text(Given::Literal) } else { None }
    }

    /// Gives an option of the configuration: as Klipper has read it, or as it is written.
    fn option(&mut self, section: Section, key: &str, is_read: bool) -> Option<Given<'_>> {
        let stand_in = printer_cfg::stand_in(key).filter(|_| is_read);
        let is_written = self.read_option(section, key) || stand_in.is_some_and(|key| self.read_option(section, key));
        if !is_written {
            if is_read && key == "max_extrude_cross_section" {
                return self.cross_section(section);
            }
            let Seen { macros, world, .. } = self.hands.seen();
            let memory = &mut macros.memory;
            let options = memory.store.open(section, &mut world.ports).ok()?;
            let value = printer_cfg::default_of(options.name(), key).filter(|_| is_read)?;
            drop(options);
            memory.text.fill(value.bytes());
        }
        if !is_read {
            return self.read_text(Given::Text);
        }
        match printer_cfg::read_setting(key, self.text()) {
            Setting::Bool(is) => Some(Given::Bool(is)),
            Setting::Int(number) => Some(Given::Int(number)),
            Setting::Float(number) => Some(Given::Float(number)),
            Setting::List => self.read_text(Given::Literal),
            Setting::Text => self.read_text(Given::Text),
        }
    }

    /// Gives the greatest cross section of a line where none is written, mm²: in Klipper the square of twice
    /// the nozzle's diameter.
    fn cross_section(&mut self, section: Section) -> Option<Given<'_>> {
        if !self.read_option(section, "nozzle_diameter") {
            return None;
        }
        match printer_cfg::read_setting("nozzle_diameter", self.text()) {
            Setting::Float(mm) => Some(Given::Float(4.0 * mm * mm)),
            Setting::Bool(_) | Setting::Int(_) | Setting::List | Setting::Text => None,
        }
    }

    /// Gives the key of the option at a place.
    fn option_at(&mut self, section: Section, place: usize) -> Option<Given<'_>> {
        let Seen { macros, world, .. } = self.hands.seen();
        let mut options = macros.memory.store.open(section, &mut world.ports).ok()?;
        for _ in 0..=place {
            if !options.go_on() {
                return None;
            }
        }
        macros.memory.text.fill(options.key().bytes());
        drop(options);
        self.read_text(Given::Text)
    }

    /// Gives the name of the section at a place.
    fn section_at(&mut self, place: usize) -> Option<Given<'_>> {
        let Seen { macros, world, .. } = self.hands.seen();
        let section = Section(u16::try_from(place).ok()?);
        if place >= macros.memory.store.sections() {
            return None;
        }
        let options = macros.memory.store.open(section, &mut world.ports).ok()?;
        macros.memory.text.fill(options.name().bytes());
        drop(options);
        self.read_text(Given::Text)
    }

    /// Counts what there is until nothing is given.
    fn count(&mut self, thing: Thing) -> usize {
        let mut count = 0;
        while self.at(thing, count).is_some() {
            count += 1;
        }
        count
    }

    fn at(&mut self, thing: Thing, place: usize) -> Option<Given<'_>> {
        match thing {
            Thing::Parameters => {
                let parameters = self.parameters;
                let (key, _) = parameters.at(place)?;
                self.text().fill(key.bytes().map(|byte| byte.to_ascii_uppercase()));
                self.read_text(Given::Text)
            }
            Thing::Options(section, _) => self.option_at(section, place),
            Thing::SavedVariables => {
                saved::name_at(self.hands, place)?;
                self.read_text(Given::Text)
            }
            Thing::Vector(which) => objects::vector(self, which).get(place).copied().map(Given::Float),
            Thing::Printer | Thing::Settings(_) => match place.checked_sub(self.hands.macros().memory.store.sections())
            {
                None => self.section_at(place),
                Some(place) if thing == Thing::Printer => objects::name_at(place).map(Given::Text),
                Some(_) => None,
            },
            Thing::PrintObjects => {
                self.hands.jobs().objects.shown(place).map(|_| Thing::PrintObject(place as u8).given())
            }
            Thing::PrintObject(_) => ["name", "center", "polygon"].get(place).map(|name| Given::Text(name)),
            Thing::Profiles => {
                let name = self.mesh_at(place)?;
                self.text().fill(name.as_str().bytes());
                self.read_text(Given::Text)
            }
            Thing::Macro(_) | Thing::Configfile | Thing::Saved | Thing::Status(..) => None,
        }
    }

    /// Returns the name of the mesh at a place among those on the card.
    fn mesh_at(&mut self, place: usize) -> Option<MeshName> {
        procedures::leveling::name_at(&mut self.hands.world().ports, place)
    }
}

impl<'c, H: MacroHands<'c>> Environment for Look<'_, 'c, H> {
    fn variable(&mut self, name: &str) -> Option<Given<'_>> {
        match name {
            "printer" => Some(Thing::Printer.given()),
            "params" => Some(Thing::Parameters.given()),
            "rawparams" => Some(Given::Text(self.parameters.rest())),
            name => self.variable_of(self.section, name),
        }
    }

    fn member(&mut self, object: Object, name: &str) -> Option<Given<'_>> {
        let store = &self.hands.macros().memory.store;
        match Thing::of(object.id) {
            Thing::Printer => match name {
                "configfile" => Some(Thing::Configfile.given()),
                "save_variables" => store.section(name).map(|_| Thing::Saved.given()),
                _ if name.starts_with("gcode_macro ") => {
                    store.section(name).map(|section| Thing::Macro(section).given())
                }
                name => objects::find(self, name),
            },
            Thing::Parameters => self.parameters.get(name).map(Given::Text),
            Thing::Macro(section) => self.variable_of(section, name),
            Thing::Configfile => match name {
                "settings" => Some(Thing::Settings(true).given()),
                "config" => Some(Thing::Settings(false).given()),
                _ => None,
            },
            Thing::Settings(is_read) => store.section(name).map(|section| Thing::Options(section, is_read).given()),
            Thing::Options(section, is_read) => self.option(section, name, is_read),
            Thing::Saved => (name == "variables").then_some(Thing::SavedVariables.given()),
            Thing::SavedVariables => {
                self.depends_on_state |= self.hands.macros().memory.store.looks().changes_variables;
                saved::read(self.hands, name)?;
                self.read_text(Given::Literal)
            }
            Thing::Status(kind, instance) => {
                self.depends_on_state |= !matches!(name, "axis_minimum" | "axis_maximum");
                status::value(self, kind, instance, name)
            }
            Thing::PrintObject(place) => status::print_object(self, place, name),
            // What a mesh is made of is not kept for macros, only that it is there.
            Thing::Profiles => {
                let mut names = (0..).map_while(|place| self.mesh_at(place));
                names.any(|known| known.as_str() == name).then_some(Given::Literal("{}"))
            }
            Thing::PrintObjects => None,
            Thing::Vector(which) => {
                let place = ["x", "y", "z", "e"].iter().position(|axis| *axis == name)?;
                objects::vector(self, which).get(place).copied().map(Given::Float)
            }
        }
    }

    fn length(&mut self, object: Object) -> usize {
        match Thing::of(object.id) {
            Thing::Printer => self.hands.macros().memory.store.sections() + objects::NAMES,
            Thing::Settings(_) => self.hands.macros().memory.store.sections(),
            thing => self.count(thing),
        }
    }

    fn element(&mut self, object: Object, index: usize) -> Option<Given<'_>> {
        self.at(Thing::of(object.id), index)
    }

    fn act(&mut self, action: Action, text: &str) {
        match action {
            Action::EmergencyStop if self.acts == Acts::Never => {
                self.trouble = Some(self.hands.world().texts.refused(format_args!("it stops the machine: {text}")));
            }
            Action::Respond | Action::CallRemoteMethod if self.acts == Acts::Never => {}
            Action::Respond => self.hands.announce(format_args!("// {text}\n")),
            Action::RaiseError => self.trouble = Some(self.hands.world().texts.because(text)),
            Action::EmergencyStop => self.hands.halt(Alarm::Abort, format_args!("ALARM: {text}\n")),
            Action::CallRemoteMethod => {
                self.hands.announce(format_args!("// NOTE {text}: no computer is here that could do it\n"));
            }
        }
    }

    fn random(&mut self, limit: usize) -> usize {
        self.depends_on_state = true;
        let now = base::ports::Clock::now(&self.hands.world().ports).0 as u32;
        let macros = self.hands.macros();
        // Numerical Recipes' generator, stirred by the time; the upper bits are the better ones.
        macros.random = (macros.random ^ now).wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((u64::from(macros.random) * limit as u64) >> 32) as usize
    }
}

/// Kinds of things for the operations that a macro may use on them.
pub(super) const fn kind_of(thing: Thing) -> Kind {
    match thing {
        Thing::Printer | Thing::Macro(_) | Thing::Configfile | Thing::Saved | Thing::Status(..) => Kind::Lookup,
        Thing::PrintObject(_) => Kind::Dict,
        Thing::PrintObjects => Kind::List,
        Thing::Parameters | Thing::Settings(_) | Thing::Options(..) | Thing::SavedVariables | Thing::Profiles => {
            Kind::Dict
        }
        Thing::Vector(_) => Kind::Tuple,
    }
}
