//! Greatest depth of a stack, from the image: each function's frame, and who calls whom.
//!
//! A call by a register can lead to the functions that the caller has as constants, else to those that its
//! own callers have, else to those that tables hold for the caller's crate (objects of its traits, rows of
//! its tables). Recursive functions are followed as often as [`NESTING`] says. A panic ends the program
//! and is not counted: its own depth belongs into the margin.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail};
use petgraph::algo::tarjan_scc;
use petgraph::graph::DiGraph;

use super::calls::{self, Function};
use super::pointers::Pointers;

/// How often a function may be on the stack at once, where it leads back to itself: by what its name holds.
const NESTING: [(&str, u8); 18] = [
    // A reply formats a finding, that an error, that a quantity, that a number. GRBL's framing formats once
    // more below, but no number, which is what takes the stack.
    ("core::fmt::write", 4),
    // Derived `Debug`s, and text set in by them: only a panic and the log say them.
    (">::debug_", 2),
    ("DebugStruct>::field", 2),
    ("(U,T) as core::fmt::Debug>", 2),
    ("<&dyn core::fmt::Debug as", 2),
    ("<core::fmt::builders::PadAdapter", 1),
    // A name that ends with a separator has its last part before it.
    ("core::str::iter::SplitInternal<P>::next_back", 2),
    // A row's setter calls what finds its field; neither calls another row's.
    ("core::ops::function::FnOnce::call_once", 2),
    // A sensor that is made of sensors, and so on: there are `units::MAX_HEATERS`.
    ("config::check::combined_sensors::leads_back", 9),
    ("thermal::combined::read_within", 9),
    // `MOST_NESTED` of `gcode::expression`, and the value that holds all of them.
    ("gcode::expression::Reader::value", 11),
    // `DEEPEST` of `macros::value`: lists and dicts within each other, and what holds all of them.
    ("macros::literal::Reader::value", 9),
    ("macros::run::", 9),
    // `map` and `select` take another filter, and that is none of them.
    ("macros::filters::", 2),
    // The form of a field in `format` may have fields itself, whose forms have none.
    ("macros::format::braces::fill", 2),
    // `DEEPEST` of `macros::parser`: parts of an expression within each other.
    ("macros::parser::", 33),
    // An answer that cannot be sent ends what it answers.
    ("machine::executor::stack::fail", 2),
    // A motion in inverse time mode is taken apart once.
    ("program::meaning::moves::motion_block", 2),
];

/// First function on the executor's stack.
pub const EXECUTOR: &str = "bsp_prime::thread_stack::enter";
/// First function on the main stack.
pub const RESET: &str = "Reset";
/// Functions that begin a panic or another end of the program.
pub const PANIC: &str = "__rustc::rust_begin_unwind";
pub const END: &str = "firmware::fault::end";

/// A path down a stack: each function with the bytes it has there while it calls the next one.
pub type Descent = Vec<(String, i64)>;

/// The functions of an image, and what each may call.
pub struct Graph {
    functions: BTreeMap<u64, Function>,
    calls: BTreeMap<u64, BTreeMap<u64, i64>>,
    /// Functions that lead to each other have the same number.
    circles: BTreeMap<u64, usize>,
}

impl Graph {
    /// Reads them from an image with its symbols.
    ///
    /// # Errors
    /// The bytes are no ELF file.
    pub fn read(elf: &[u8]) -> Result<Self> {
        let functions = calls::functions(elf)?;
        let pointers = Pointers::read(elf, &functions)?;
        let mut calls = BTreeMap::new();
        for (&address, function) in &functions {
            let mut targets = function.calls.clone();
            if let Some(depth) = function.by_register {
                for target in pointers.candidates(address, &functions) {
                    let most = targets.entry(target).or_insert(depth);
                    *most = depth.max(*most);
                }
            }
            targets.retain(|target, _| functions.get(target).is_some_and(|target| !is_left(&target.name)));
            calls.insert(address, targets);
        }
        Ok(Self { circles: circles(&calls), functions, calls })
    }

    /// The function whose address a word is.
    pub fn name_of(&self, word: u32) -> Option<String> {
        self.functions.get(&u64::from(word & !1)).map(|function| function.name.clone())
    }

    /// Every function, the largest frames first.
    pub fn by_frame(&self) -> Vec<&Function> {
        let mut functions: Vec<_> = self.functions.values().collect();
        functions.sort_by_key(|function| -function.frame);
        functions
    }

    /// The deepest path from the function of this name.
    ///
    /// # Errors
    /// There is none, or functions lead back to themselves that [`NESTING`] does not know.
    pub fn deepest(&self, name: &str) -> Result<Descent> {
        let found = self.functions.iter().find(|(_, function)| function.name == name);
        let (&root, _) = found.with_context(|| format!("the image has no function {name}"))?;
        let mut search = Search { graph: self, known: BTreeMap::new(), path: Vec::new() };
        search.depth(root, ANEW)?;
        Ok(search.descent(root))
    }
}

/// Depth of the stack from a function on: in bytes, and by which call.
type Depth = (i64, Option<(u64, Nesting)>);
/// Entries that are left to each function of [`NESTING`].
type Nesting = [u8; NESTING.len()];

/// Before any of them is entered.
const ANEW: Nesting = {
    let (mut times, mut at) = ([0; NESTING.len()], 0);
    while at < NESTING.len() {
        times[at] = NESTING[at].1;
        at += 1;
    }
    times
};

struct Search<'g> {
    graph: &'g Graph,
    known: BTreeMap<(u64, Nesting), Depth>,
    path: Vec<(u64, Nesting)>,
}

impl Search<'_> {
    fn depth(&mut self, address: u64, mut left: Nesting) -> Result<Option<i64>> {
        let Some(function) = self.graph.functions.get(&address) else { return Ok(Some(0)) };
        let entered = (address, left);
        if let Some(&(bytes, _)) = self.known.get(&entered) {
            return Ok(Some(bytes));
        }
        for ((name, _), left) in NESTING.iter().zip(&mut left) {
            if function.name.contains(name) {
                let Some(fewer) = left.checked_sub(1) else { return Ok(None) };
                *left = fewer;
            }
        }
        if let Some(begin) = self.path.iter().position(|on_path| *on_path == entered) {
            let circle: Vec<_> =
                self.path[begin..].iter().map(|(at, _)| self.graph.functions[at].name.as_str()).collect();
            bail!("functions call each other without an end that is known: {}", circle.join(" -> "));
        }
        self.path.push(entered);
        let mut most = (function.frame, None);
        for (&target, &held) in &self.graph.calls[&address] {
            let is_circle = self.graph.circles[&target] == self.graph.circles[&address];
            let left = if is_circle { left } else { ANEW };
            if let Some(below) = self.depth(target, left)?.filter(|below| held + below > most.0) {
                most = (held + below, Some((target, left)));
            }
        }
        self.path.pop();
        self.known.insert(entered, most);
        Ok(Some(most.0))
    }

    fn descent(&self, root: u64) -> Descent {
        let mut descent = Vec::new();
        let mut at = Some((root, ANEW));
        while let Some((entered, &(bytes, next))) = at.and_then(|entered| Some((entered, self.known.get(&entered)?))) {
            let below = next.and_then(|next| self.known.get(&next)).map_or(0, |(below, _)| *below);
            descent.push((self.graph.functions[&entered.0].name.clone(), bytes - below));
            at = next;
        }
        descent
    }
}

fn circles(calls: &BTreeMap<u64, BTreeMap<u64, i64>>) -> BTreeMap<u64, usize> {
    let mut graph = DiGraph::<u64, ()>::new();
    let nodes: BTreeMap<u64, _> = calls.keys().map(|address| (*address, graph.add_node(*address))).collect();
    for (caller, targets) in calls {
        targets.keys().for_each(|target| {
            graph.add_edge(nodes[caller], nodes[target], ());
        });
    }
    let found = tarjan_scc(&graph).into_iter().enumerate();
    found
        .flat_map(|(number, nodes)| nodes.into_iter().map(move |node| (node, number)))
        .map(|(node, number)| (graph[node], number))
        .collect()
}

/// Whether nothing comes back from a function, or it has a stack of its own: what ends the program, and the
/// executor.
fn is_left(name: &str) -> bool {
    let fails =
        ["core::panicking::", "core::option::", "core::result::", "core::slice::", "core::str::", "core::cell::"];
    let is_failure = name.contains("fail") || name.contains("panic");
    [PANIC, END, EXECUTOR].contains(&name) || is_failure && fails.iter().any(|begin| name.starts_with(begin))
}
