//! The firmware's ELF file: sections, functions, the data within the code, and what is an address.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use object::elf::{R_ARM_ABS32, R_ARM_TARGET1, R_ARM_THM_MOVW_ABS_NC, SHF_ALLOC};
use object::{
    Object, ObjectSection, ObjectSymbol, Relocation, RelocationFlags, RelocationTarget,
    SectionFlags, SymbolKind,
};

const RAM: u32 = 0x2000_0000;
pub const VECTOR_TABLE: &str = ".vector_table";

/// A linked program.
pub struct Elf {
    /// Those that take memory.
    sections: Vec<Section>,
    symbols: Vec<Symbol>,
    /// Whether data, or else code, starts at an address, as marked by the compiler.
    is_data: BTreeMap<u32, bool>,
    /// Addresses that the program holds, outside the vector table: their lowest bit marks code.
    held: BTreeSet<u32>,
}

struct Section {
    name: String,
    address: u32,
    size: u64,
    /// `None` if it is not in the file.
    bytes: Option<Vec<u8>>,
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
    kind: SymbolKind,
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
        let name = program.display();
        let bytes = std::fs::read(program).map_err(|e| format!("{name}: {e}"))?;
        Self::parse(&bytes).map_err(|e| format!("{name}: not an ELF file for the Cortex-M3: {e}"))
    }

    fn parse(bytes: &[u8]) -> object::Result<Self> {
        let file = object::File::parse(bytes)?;
        let mut elf = Self {
            sections: Vec::new(),
            symbols: Vec::new(),
            is_data: BTreeMap::new(),
            held: BTreeSet::new(),
        };
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else { continue };
            if sh_flags.0 & SHF_ALLOC.0 == 0 {
                continue;
            }
            let in_file = section.file_range().is_some();
            let bytes = if in_file { Some(section.data()?.to_vec()) } else { None };
            elf.sections.push(Section {
                name: section.name()?.into(),
                address: section.address() as u32,
                size: section.size(),
                bytes,
            });
            if section.name()? != VECTOR_TABLE {
                let held = section
                    .relocations()
                    .filter_map(|(at, relocation)| elf.held_at(&file, at as u32, &relocation));
                let held: Vec<_> = held.collect();
                elf.held.extend(held);
            }
        }
        for symbol in file.symbols() {
            let (name, address) = (symbol.name()?, symbol.address() as u32);
            match name.split('.').next() {
                Some("$t") => _ = elf.is_data.insert(address, false),
                Some("$d") => _ = elf.is_data.insert(address, true),
                _ => elf.symbols.push(Symbol {
                    name: name.into(),
                    address,
                    size: symbol.size(),
                    kind: symbol.kind(),
                }),
            }
        }
        Ok(elf)
    }

    /// The address that the linker has written at a place of the section read last.
    fn held_at(&self, file: &object::File<'_>, at: u32, relocation: &Relocation) -> Option<u32> {
        let RelocationFlags::Elf { r_type } = relocation.flags() else { return None };
        match r_type {
            R_ARM_ABS32 | R_ARM_TARGET1 => self.word(at),
            R_ARM_THM_MOVW_ABS_NC => {
                let RelocationTarget::Symbol(symbol) = relocation.target() else { return None };
                Some(file.symbol_by_index(symbol).ok()?.address() as u32)
            }
            _ => None,
        }
    }

    /// The addresses that the program holds, outside the vector table: in tables and in instructions.
    /// The lowest bit of a function's is set.
    pub fn held(&self) -> &BTreeSet<u32> {
        &self.held
    }

    /// Bytes of flash and of RAM that the sections take.
    pub fn memory(&self) -> (u64, u64) {
        let (mut flash, mut ram) = (0, 0);
        for Section { address, size, bytes, .. } in &self.sections {
            if *address >= RAM {
                ram += size;
            }
            // Initialised data takes both flash and RAM.
            if *address < RAM || bytes.is_some() {
                flash += size;
            }
        }
        (flash, ram)
    }

    /// Functions and variables that take memory; several names of one address count once.
    pub fn symbols(&self) -> Vec<Symbol> {
        let has_size =
            |it: &&Symbol| it.size > 0 && matches!(it.kind, SymbolKind::Data | SymbolKind::Text);
        let mut found: Vec<_> = self.symbols.iter().filter(has_size).cloned().collect();
        found.sort_by_key(|symbol| symbol.address);
        found.dedup_by_key(|symbol| symbol.address);
        found
    }

    /// The functions by address: their end (padding may follow) and their demangled name.
    pub fn functions(&self) -> BTreeMap<u32, (u32, String)> {
        let functions = self.symbols.iter().filter(|symbol| symbol.kind == SymbolKind::Text);
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
        let (words, _) = section.bytes.as_ref()?.as_chunks();
        Some(words.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect())
    }

    /// Two bytes of the image.
    pub fn half(&self, address: u32) -> Option<u16> {
        self.at(address).map(u16::from_le_bytes)
    }

    /// Four bytes of the image.
    pub fn word(&self, address: u32) -> Option<u32> {
        self.at(address).map(u32::from_le_bytes)
    }

    fn at<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        self.sections.iter().find_map(|section| {
            let into = address.checked_sub(section.address)? as usize;
            section.bytes.as_ref()?.get(into..)?.first_chunk().copied()
        })
    }
}
