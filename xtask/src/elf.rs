//! Reads the firmware's ELF file: sections, functions, and the data within the code.

use std::collections::BTreeMap;
use std::path::Path;

const SYMBOLS: u32 = 2;
const ALLOCATED: u32 = 2;
/// Section type of memory that takes no space in the file.
const NO_BITS: u32 = 8;
const RAM: u32 = 0x2000_0000;
const OBJECT: u8 = 1;
const FUNCTION: u8 = 2;

/// A linked program.
pub struct Elf {
    bytes: Vec<u8>,
    sections: Vec<Section>,
    symbols: Vec<Symbol>,
    /// Whether data, or else code, starts at an address, as marked by the compiler.
    is_data: BTreeMap<u32, bool>,
}

#[derive(Clone)]
struct Section {
    name: String,
    kind: u32,
    flags: u32,
    address: u32,
    offset: usize,
    len: usize,
    link: usize,
}

/// A function or a variable.
#[derive(Clone)]
pub struct Symbol {
    /// Name used by the linker.
    pub name: String,
    /// Address in memory.
    pub address: u32,
    /// Size, bytes.
    pub size: u64,
    kind: u8,
}

impl Symbol {
    /// Whether it is in RAM.
    pub fn in_ram(&self) -> bool {
        (RAM..RAM + 0x1000_0000).contains(&self.address)
    }
}

impl Elf {
    /// Reads a file.
    pub fn read(program: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(program).map_err(|e| format!("{}: {e}", program.display()))?;
        Self::parse(bytes)
            .ok_or_else(|| format!("{}: not an ELF file for the Cortex-M3", program.display()))
    }

    fn parse(bytes: Vec<u8>) -> Option<Self> {
        let elf = bytes.as_slice();
        if !elf.starts_with(b"\x7fELF") {
            return None;
        }
        let table = word(elf, 32)? as usize;
        let [size, count, names] = [46, 48, 50].map(|at| half(elf, at));
        let place = |index: usize| table + index * usize::from(size.unwrap_or_default());
        let names = word(elf, place(names?.into()) + 16)? as usize;
        let section = |at: usize| {
            let field = |offset| word(elf, at + offset);
            Some(Section {
                name: text(elf, names + field(0)? as usize)?,
                kind: field(4)?,
                flags: field(8)?,
                address: field(12)?,
                offset: field(16)? as usize,
                len: field(20)? as usize,
                link: field(24)? as usize,
            })
        };
        let sections =
            (0..usize::from(count?)).map(place).map(section).collect::<Option<Vec<_>>>()?;
        let (symbols, is_data) = symbols(elf, &sections)?;
        Some(Self { bytes, sections, symbols, is_data })
    }

    /// Bytes of flash and of RAM that the sections take.
    pub fn memory(&self) -> (u64, u64) {
        let (mut flash, mut ram) = (0, 0);
        for section in self.sections.iter().filter(|it| it.flags & ALLOCATED != 0) {
            let len = section.len as u64;
            if section.address >= RAM {
                ram += len;
            }
            // Initialised data takes both flash and RAM.
            if section.address < RAM || section.kind != NO_BITS {
                flash += len;
            }
        }
        (flash, ram)
    }

    /// Functions and variables that take memory; several names of one address count once.
    pub fn symbols(&self) -> Vec<Symbol> {
        let has_size = |it: &&Symbol| it.size > 0 && matches!(it.kind, OBJECT | FUNCTION);
        let mut found: Vec<_> = self.symbols.iter().filter(has_size).cloned().collect();
        found.sort_by_key(|symbol| symbol.address);
        found.dedup_by_key(|symbol| symbol.address);
        found
    }

    /// The functions by address: their end (padding may follow) and their demangled name.
    pub fn functions(&self) -> BTreeMap<u32, (u32, String)> {
        let functions = self.symbols.iter().filter(|symbol| symbol.kind == FUNCTION);
        let named = functions.map(|symbol| {
            let start = symbol.address & !1;
            let name = format!("{:#}", rustc_demangle::demangle(&symbol.name));
            (start, (start + symbol.size as u32, name))
        });
        named.collect()
    }

    /// Whether the address holds data within the code.
    pub fn is_data(&self, address: u32) -> bool {
        self.is_data.range(..=address).next_back().is_some_and(|(_, is_data)| *is_data)
    }

    /// The words of a section.
    pub fn words(&self, name: &str) -> Option<Vec<u32>> {
        let section = self.sections.iter().find(|section| section.name == name)?;
        let bytes = self.bytes.get(section.offset..section.offset + section.len)?;
        Some(bytes.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect())
    }

    /// Two bytes of the image.
    pub fn half(&self, address: u32) -> Option<u16> {
        half(&self.bytes, self.offset(address)?)
    }

    /// Four bytes of the image.
    pub fn word(&self, address: u32) -> Option<u32> {
        word(&self.bytes, self.offset(address)?)
    }

    fn offset(&self, address: u32) -> Option<usize> {
        self.sections
            .iter()
            .filter(|section| section.flags & ALLOCATED != 0 && section.kind != NO_BITS)
            .find_map(|section| {
                let into = address.checked_sub(section.address)? as usize;
                (into < section.len).then_some(section.offset + into)
            })
    }
}

fn symbols(elf: &[u8], sections: &[Section]) -> Option<(Vec<Symbol>, BTreeMap<u32, bool>)> {
    let table = sections.iter().find(|section| section.kind == SYMBOLS)?;
    let names = sections.get(table.link)?.offset;
    let (mut found, mut is_data) = (Vec::new(), BTreeMap::new());
    for at in (table.offset..table.offset + table.len).step_by(16) {
        let name = text(elf, names + word(elf, at)? as usize)?;
        let (address, size) = (word(elf, at + 4)?, word(elf, at + 8)?.into());
        let kind = elf.get(at + 12)? & 0xF;
        match name.split('.').next() {
            Some("$t") => _ = is_data.insert(address, false),
            Some("$d") if address < RAM => _ = is_data.insert(address, true),
            _ => found.push(Symbol { name, address, size, kind }),
        }
    }
    Some((found, is_data))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn half(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn text(bytes: &[u8], at: usize) -> Option<String> {
    let name = bytes.get(at..)?.split(|byte| *byte == 0).next()?;
    Some(String::from_utf8_lossy(name).into_owned())
}
