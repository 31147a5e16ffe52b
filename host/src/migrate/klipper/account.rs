//! The account of a migration: what became of every section and option, each exactly once.

use serde::Serialize;

use super::source::Source;

/// Fate of a section or an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The new file says the same.
    Converted,
    /// There is nothing to be said on this board.
    Needless,
    /// Velvet has nothing that does the same.
    Refused,
}

/// Fate of a section or an option, with the reason.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    pub class: Class,
    /// Whether it stays in printer.cfg, which the board reads; such an option counts as converted.
    pub kept: bool,
    pub reason: String,
    /// Nearest thing in Velvet, of what is refused.
    pub nearest: String,
    /// Settings of the new file that it became, as `[section] key = value`.
    pub becomes: Vec<String>,
}

impl Verdict {
    /// Makes a verdict of a class.
    pub fn new(class: Class, reason: impl Into<String>) -> Self {
        Self { class, kept: false, reason: reason.into(), nearest: String::new(), becomes: Vec::new() }
    }

    /// Makes the verdict on an option that Velvet needs no counterpart of.
    pub fn needless(reason: impl Into<String>) -> Self {
        Self::new(Class::Needless, reason)
    }

    /// Makes the verdict on an option that Velvet cannot follow, with the nearest thing it has.
    pub fn refused(reason: impl Into<String>, nearest: impl Into<String>) -> Self {
        Self { nearest: nearest.into(), ..Self::new(Class::Refused, reason) }
    }

    /// Makes the verdict on an option that the board reads from the printer.cfg itself.
    pub fn kept(reason: impl Into<String>) -> Self {
        Self { kept: true, ..Self::new(Class::Converted, reason) }
    }
}

/// How many sections or options have which fate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Count {
    pub all: usize,
    pub converted: usize,
    /// Options of `converted` that stay in printer.cfg.
    pub kept: usize,
    pub needless: usize,
    pub refused: usize,
}

impl Count {
    fn add(&mut self, verdict: &Verdict) {
        self.all += 1;
        self.kept += usize::from(verdict.kept);
        *match verdict.class {
            Class::Converted => &mut self.converted,
            Class::Needless => &mut self.needless,
            Class::Refused => &mut self.refused,
        } += 1;
    }
}

/// Verdicts on one section and its options, in the order of the source.
#[derive(Debug, Default)]
pub struct OfSection {
    pub section: Option<Verdict>,
    pub options: Vec<Option<Verdict>>,
}

/// Verdicts on all sections of a source.
#[derive(Debug)]
pub struct Account(pub Vec<OfSection>);

impl Account {
    /// Makes an account in which no option has a verdict yet.
    pub fn new(source: &Source) -> Self {
        let of = |count: usize| OfSection { section: None, options: (0..count).map(|_| None).collect() };
        Self(source.sections.iter().map(|section| of(section.options.len())).collect())
    }

    /// Returns the place of a verdict: on an option, or on the section itself.
    pub fn at(&mut self, section: usize, option: Option<usize>) -> Option<&mut Option<Verdict>> {
        let of_section = self.0.get_mut(section)?;
        match option {
            Some(option) => of_section.options.get_mut(option),
            None => Some(&mut of_section.section),
        }
    }

    /// Counts the options by their fate.
    pub fn options(&self) -> Count {
        let mut count = Count::default();
        for verdict in self.0.iter().flat_map(|section| section.options.iter().flatten()) {
            count.add(verdict);
        }
        count
    }

    /// Counts the sections by their fate.
    pub fn sections(&self) -> Count {
        let mut count = Count::default();
        for verdict in self.0.iter().filter_map(|section| section.section.as_ref()) {
            count.add(verdict);
        }
        count
    }
}
