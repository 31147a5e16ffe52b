//! Words of errors: what is wrong, and how to mend it.

use crate::chars::nth;

macro_rules! words {
    ($($(#[$doc:meta])* $name:ident $text:literal,)*) => {
        /// What is wrong, by the number of its words.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Words { $($(#[$doc])* $name,)* }

        /// The words, each with the end of a line behind it.
        const TEXTS: &str = concat!($($text, "\n",)*);
    };
}

words! {
    Raised "raised by the macro",
    TooDeep "lists and dicts within each other go down to 8: make them flatter",
    NoMemory "bytes of memory are too few for this macro: make it shorter",
    NoOutput "bytes of lines are the most that a macro may have: make it shorter",
    TooSlow "the macro takes too long: make its loops shorter",
    Undefined "this is not there: correct the name, or put |default(...) behind it",
    NoMessage "a message is missing",
    WantsDict "a dict is wanted here",
    WantsText "a string is wanted here: put |string behind it",
    WantsWhole "a whole number is wanted here: put |int behind it",
    WantsNumber "this is no number: put |int or |float behind it",
    WantsList "a list is wanted here: put |list before it",
    NotCallable "this cannot be called",
    ArgumentMissing "an argument is missing",
    TooManyArguments "there are more arguments than these, or one has another name",
    NamesLast "arguments without a name stand before those with one",
    NameInQuotes "the name of a filter or test has to stand in quotes",
    NoFilter "there is no filter of this name",
    NoTest "there is no test of this name",
    NoFilterOrTest "there is no filter or test of this name",
    MapOfMap "map cannot take map or select: use a loop",
    LoopOnlyCycles "a loop has cycle and no other function",
    LoopEnd "a loop with if does not know its end: go through a list made with select",
    NotIterable "this cannot be gone through: a list, dict, string or range can",
    LongRange "a range of more than 65535 numbers is too long here",
    NoLength "this has no length: a list, dict or string has",
    NoSlices "this has no slices: a list, tuple or string has",
    ZeroStep "the step may not be 0",
    NoText "this has no text: write one of its members",
    NoElement "the list has no element of this number",
    NoKey "the dict has no such key: use get, or give pop a second value",
    NotInList "this is not in it: ask with in before",
    NotHashable "this cannot be the key of a dict",
    Pairs "a dict is made of pairs of a key and a value",
    Fixed "values of the printer cannot be changed: copy them with |list or dict(...)",
    OnlyNamespaces "only members of a namespace can be set: make one with namespace()",
    OtherCount "the value has another number of parts than there are names",
    ZeroDivision "nothing can be divided by zero",
    Overflow "the result is beyond 64 bits: calculate with a point, as in 1.0",
    WholePower "a negative number has only whole powers",
    AddToText "this cannot be added to a string: join them with ~",
    NoOrder "these have no order: compare numbers with numbers and strings with strings",
    TextOrder "a string and this have no order: make a number of the string with |int or |float",
    ListSort "this function of lists is not known: use the filter sort",
    EmptySeparator "a string cannot be split by an empty one",
    OneCharacter "what fills has to be one character",
    KeyOrValue "dictsort sorts by key or value",
    RoundMethod "the method of round is common, ceil or floor",
    TruncateLength "the length for truncate is shorter than its end",
    TextsToJoin "only strings can be joined so: use the filter join",
    BraceMissing "a } is missing in the text: write {{ and }} for braces themselves",
    Conversion "behind ! stands s or r",
    ValueNotGiven "the text has a place for a value that is not given",
    TooManyValues "there are more values than % signs in the text",
    NestedBraces "braces within braces within braces are not known",
    FormPoint "a number is missing behind the point of the form",
    FormLong "the form goes on behind its letter",
    FormMisfit "this form does not fit the value: put |int or |float behind it",
    NoForm "there is no form of this letter behind %: write %% for a % sign",
    PercentName "%(name) wants a ) and a dict behind the %",
    NoCharacter "there is no character of this number",
    TooLong "the value is too long to be kept",
    NotUtf8 "the text is not UTF-8: save the file as UTF-8",
    StringEnd "a string has no end: put its quote behind it",
    CommentEnd "a comment that begins with {# has no end: put #} behind it",
    NameLetters "a name may only have the letters a to z, digits and _",
    Meaningless "this character has no meaning here",
    Brackets "too many brackets within brackets: put a part into a variable of its own",
    BracketOpen "this bracket closes none that is open: count the brackets",
    CharacterName "characters by name are not known: write the character itself",
    EscapeShort "an escape with x, u or U has too few digits",
    TooLarge "whole numbers go up to 9223372036854775807: write a smaller one, or one with a point",
    LeadingZero "a whole number may not begin with 0: leave it out",
    NumberMissing "a number is missing here",
    LiteralRest "something stands behind the value",
    LiteralEnd "a value does not end where it should: see the brackets and commas",
    LiteralWord "this is no value: a text has to stand in quotes",
    LiteralKey "the key of a dict is a string or a number here",
    ParenthesisMissing "a ) is missing before this",
    BracketMissing "a ] is missing before this",
    OutputEnd "a } is missing before this",
    TagEnd "%} is missing before this",
    CommaOrParenthesis "a , or ) is missing before this",
    CommaOrBracket "a , or ] is missing before this",
    CommaOrBrace "a , or } is missing before this",
    ColonMissing "a : is missing before this",
    InMissing "in is missing before this",
    ValueMissing "a value is missing before this",
    NameMissing "a name is missing before this",
    TwoTests "two tests cannot follow each other: put the first in parentheses",
    SliceAlone "a slice has to stand alone in its brackets",
    TooManyTags "too many tags within tags: make a macro of its own of a part",
    NoEnd "the tag that begins here has no end: put {% endif %}, {% endfor %} or {% endset %}",
    TagRefused "this tag of Jinja2 is not known here: call another G-code macro instead",
    TagMisplaced "this tag does not fit here: each if, for and set needs its own end, in turn",
    Recursive "loops that call themselves are not known: write one loop in another",
    NoTarget "nothing can be stored in this: take another name",
}

impl Words {
    /// The words themselves.
    pub fn text(self) -> &'static str {
        nth(TEXTS, b'\n', self as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::Words;

    #[test]
    fn a_number_has_its_words() {
        assert_eq!(Words::Raised.text(), "raised by the macro");
        assert!(Words::NotUtf8.text().contains("UTF-8") && Words::NoTarget.text().contains("stored"));
    }
}
