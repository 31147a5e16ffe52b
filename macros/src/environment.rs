//! The machine as macros see it.

/// Something of the machine's that has parts: `printer`, the status of an object, a list in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object {
    /// The caller's number for it.
    pub id: u32,
    /// Kind of the thing: lookup, dict, list or tuple.
    pub kind: Kind,
}

/// Kinds of objects, by the operations that a template may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Members by name, `in` and `for`, and no methods, as `printer` has it.
    Lookup,
    /// A dict with all its methods.
    Dict,
    /// As a list; elements by number, and by name where the caller knows names (`position.x`).
    List,
    /// As a tuple, otherwise like a list.
    Tuple,
}

/// A value that the caller hands in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Given<'a> {
    /// Nothing, which Python calls `None`.
    None,
    /// A truth value, `True` or `False`.
    Bool(bool),
    /// A whole number of 64 bits.
    Int(i64),
    /// A real number, a float of Python.
    Float(f64),
    /// A text, which is copied when it is handed in.
    Text(&'a str),
    /// Text of a Python literal, which is read when it is asked for: `[1, 2]`.
    Literal(&'a str),
    /// Something with members or elements of its own.
    Object(Object),
}

/// Requests to the machine that a template makes while it is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// `action_respond_info`: tell the consoles.
    Respond,
    /// `action_raise_error`: the rendering ends behind it.
    RaiseError,
    /// `action_emergency_stop`: stop the machine now.
    EmergencyStop,
    /// `action_call_remote_method`: the text is the method's name.
    CallRemoteMethod,
}

/// The machine as macros see it. Everything is looked up when it is asked for.
pub trait Environment {
    /// A variable of the macro, `params`, `rawparams` or `printer`; none if there is none of that name.
    fn variable(&mut self, name: &str) -> Option<Given<'_>>;
    /// Member of an object by name.
    fn member(&mut self, object: Object, name: &str) -> Option<Given<'_>>;
    /// Number of members or elements of an object.
    fn length(&mut self, object: Object) -> usize;
    /// Name of a member of an object, or element of a list, by number from 0.
    fn element(&mut self, object: Object, index: usize) -> Option<Given<'_>>;
    /// Does something at once.
    fn act(&mut self, action: Action, text: &str);
    /// A random number below a limit.
    fn random(&mut self, limit: usize) -> usize;
}

/// A machine without anything: for literals and for templates that ask for nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nothing;

impl Environment for Nothing {
    fn variable(&mut self, _: &str) -> Option<Given<'_>> {
        None
    }

    fn member(&mut self, _: Object, _: &str) -> Option<Given<'_>> {
        None
    }

    fn length(&mut self, _: Object) -> usize {
        0
    }

    fn element(&mut self, _: Object, _: usize) -> Option<Given<'_>> {
        None
    }

    fn act(&mut self, _: Action, _: &str) {}

    fn random(&mut self, _: usize) -> usize {
        0
    }
}
