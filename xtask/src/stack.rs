//! Computes the greatest stack depth of the firmware over all call paths of the linked image.
//! Nothing is run and no inputs are assumed, so the bound also covers what no test reaches.
//!
//! - A function counts with all that it takes at once, and a jump to another function as a call.
//! - A call by register may reach every function whose address is in the image outside the vector
//!   table, as the linker's relocations say: an overestimate, never an underestimate. A number that
//!   happens to equal an address is none.
//! - Recursion in any form, and a stack adjustment by an amount that the instruction does not give,
//!   are errors.
//! - On top of the program comes the deepest interrupt, which only a fault can interrupt, and then
//!   that fault.

use std::collections::{BTreeMap, BTreeSet};

use crate::elf::{Elf, VECTOR_TABLE};
use crate::thumb::{self, Effect};

/// Bytes that the processor pushes on an exception, including four for alignment.
const EXCEPTION: u32 = 36;
const RESET: usize = 1;
const HARD_FAULT: usize = 3;

/// A bound of the stack depth.
pub struct Bound {
    /// Functions of the deepest path, with the bytes each takes.
    pub path: Vec<(String, u32)>,
    /// Bytes that interrupt and fault add.
    pub exceptions: u32,
    /// Functions that call by register.
    pub by_register: Vec<String>,
    /// Possible targets of such a call.
    pub held: Vec<String>,
}

impl Bound {
    /// Bytes of the deepest path, without exceptions.
    pub fn program(&self) -> u32 {
        self.path.iter().map(|(_, bytes)| bytes).sum()
    }

    /// Bytes in total.
    pub fn all(&self) -> u32 {
        self.program() + self.exceptions
    }
}

/// The bound of a linked program.
pub fn bound(elf: &Elf) -> Result<Bound, String> {
    let graph = Graph::of(elf)?;
    let vectors = elf.words(VECTOR_TABLE).ok_or("the image has no vector table")?;
    let vector = |index: usize| vectors.get(index).copied().unwrap_or_default() & !1;
    let mut depths = BTreeMap::new();
    let mut deepest = |from: u32| graph.deepest(from, &mut Vec::new(), &mut depths);
    let path = deepest(vector(RESET))?.path;
    let fault = deepest(vector(HARD_FAULT))?.bytes;
    let mut interrupt = 0;
    let others = vectors.iter().enumerate().skip(2).filter(|(index, _)| *index != HARD_FAULT);
    for (_, entry) in others.filter(|(_, entry)| **entry != 0) {
        interrupt = interrupt.max(deepest(entry & !1)?.bytes);
    }
    let names = |places: &mut dyn Iterator<Item = &u32>| {
        places.filter_map(|place| Some(graph.functions.get(place)?.name.clone())).collect()
    };
    let calling = graph.functions.iter().filter(|(_, it)| it.by_register);
    Ok(Bound {
        path: path
            .iter()
            .filter_map(|place| graph.functions.get(place))
            .map(|function| (function.name.clone(), function.takes))
            .collect(),
        exceptions: 2 * EXCEPTION + interrupt + fault,
        by_register: names(&mut calling.map(|(place, _)| place)),
        held: names(&mut graph.held.iter()),
    })
}

/// Functions by address.
struct Graph {
    functions: BTreeMap<u32, Function>,
    /// Functions whose address is stored somewhere.
    held: BTreeSet<u32>,
}

struct Function {
    name: String,
    /// Bytes of the stack that the function itself takes.
    takes: u32,
    goes_to: BTreeSet<u32>,
    by_register: bool,
}

#[derive(Clone, Default)]
struct Depth {
    bytes: u32,
    path: Vec<u32>,
}

impl Graph {
    fn of(elf: &Elf) -> Result<Self, String> {
        let symbols = elf.functions();
        let starts: BTreeSet<u32> = symbols.keys().copied().collect();
        let mut functions = BTreeMap::new();
        for (start, (end, name)) in &symbols {
            // Symbols of assembly have no size.
            let next = starts.range(start + 1..).next().copied().unwrap_or(u32::MAX);
            let end = if end == start { next } else { *end };
            functions.insert(*start, function(elf, name, *start, end, &starts)?);
        }
        let held: BTreeSet<u32> =
            elf.held().iter().filter_map(|it| held_by(*it, &starts)).collect();
        if elf.held().is_empty() {
            return Err("the image has no relocations: link it with --emit-relocs".to_owned());
        }
        Ok(Self { functions, held })
    }

    /// The deepest path from a function; `above` are its callers.
    fn deepest(
        &self,
        from: u32,
        above: &mut Vec<u32>,
        known: &mut BTreeMap<u32, Depth>,
    ) -> Result<Depth, String> {
        if let Some(depth) = known.get(&from) {
            return Ok(depth.clone());
        }
        let missing = || format!("no function at {from:#x}");
        let function = self.functions.get(&from).ok_or_else(missing)?;
        if above.contains(&from) {
            let names = above.iter().skip_while(|it| **it != from).chain([&from]);
            let names: Vec<_> =
                names.filter_map(|it| self.functions.get(it)).map(|it| it.name.as_str()).collect();
            return Err(format!("recursion: {}", names.join(" calls ")));
        }
        above.push(from);
        let mut below = Depth::default();
        let by_register = self.held.iter().filter(|_| function.by_register);
        for to in function.goes_to.iter().chain(by_register) {
            let depth = self.deepest(*to, above, known)?;
            if depth.bytes > below.bytes {
                below = depth;
            }
        }
        above.pop();
        let path = [&[from], below.path.as_slice()].concat();
        let depth = Depth { bytes: function.takes + below.bytes, path };
        known.insert(from, depth.clone());
        Ok(depth)
    }
}

/// Decodes the instructions of a function, up to the next one.
fn function(
    elf: &Elf,
    name: &str,
    start: u32,
    end: u32,
    starts: &BTreeSet<u32>,
) -> Result<Function, String> {
    let mut function =
        Function { name: name.into(), takes: 0, goes_to: BTreeSet::new(), by_register: false };
    let mut at = start;
    while at < end {
        let Some(first) = elf.half(at) else { break };
        if elf.is_data(at) {
            at += 2;
            continue;
        }
        let (effect, len) = match thumb::is_wide(first) {
            true => (thumb::wide(at, first, elf.half(at + 2).unwrap_or_default()), 4),
            false => (thumb::narrow(at, first), 2),
        };
        match effect {
            Effect::None => {}
            Effect::Takes(bytes) => function.takes += bytes,
            // A jump within the function is a loop; one to the start of another is a call.
            Effect::Goes(to) if (start..end).contains(&to) => {}
            Effect::Goes(to) | Effect::Calls(to) if starts.contains(&to) => {
                function.goes_to.insert(to);
            }
            Effect::Goes(to) | Effect::Calls(to) => {
                return Err(format!("{name} jumps into a function, to {to:#x}"));
            }
            Effect::GoesByRegister => function.by_register = true,
            Effect::Unbounded => return Err(format!("{name} moves the stack, at {at:#x}")),
        }
        at += len;
    }
    Ok(function)
}

/// The function whose address a word is; its lowest bit marks code.
fn held_by(word: u32, starts: &BTreeSet<u32>) -> Option<u32> {
    (word & 1 != 0 && starts.contains(&(word & !1))).then_some(word & !1)
}
