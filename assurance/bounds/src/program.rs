//! The functions of a program with their instructions.

use std::collections::{BTreeMap, BTreeSet};

use capstone::arch::arm::{ArchExtraMode, ArchMode};
use capstone::prelude::*;
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SectionKind, SymbolKind};

use crate::Error;
use crate::instruction::{Flow, Instruction};

/// A function.
#[derive(Debug, Clone)]
pub struct Function {
    /// Its name without the hash.
    pub name: String,
    /// Its first address.
    pub address: u64,
    /// Reachable instructions with the addresses behind them within the function.
    pub(crate) instructions: BTreeMap<u64, (Instruction, Vec<u64>)>,
    /// Functions that it calls, tail calls included: the call's address and the function's.
    pub(crate) calls: Vec<(u64, u64)>,
}

impl Function {
    /// Whether its path ends with this name.
    pub fn is_named(&self, name: &str) -> bool {
        let path = self.name.strip_suffix(name);
        path.is_some_and(|path| path.is_empty() || path.ends_with("::"))
    }

    /// The greatest constant in a register before an instruction; `None` if the register is not
    /// constant on one of the paths to it.
    pub(crate) fn greatest_before(&self, at: u64, register: u8) -> Option<u64> {
        let mut greatest = 0;
        let (mut reached, mut todo) = (BTreeSet::new(), vec![at]);
        while let Some(at) = todo.pop() {
            if at == self.address {
                return None;
            }
            let leads_here = |(_, following): &&(Instruction, Vec<u64>)| following.contains(&at);
            for (instruction, _) in self.instructions.values().filter(leads_here) {
                if let Some(constant) = instruction.assigned(register) {
                    greatest = greatest.max(constant?);
                } else if reached.insert(instruction.address) {
                    todo.push(instruction.address);
                }
            }
        }
        Some(greatest)
    }
}

/// A program.
#[derive(Debug)]
pub struct Program {
    functions: BTreeMap<u64, Function>,
}

impl Program {
    /// Reads all functions of an ELF file.
    ///
    /// # Errors
    /// If the file is no ELF, or an instruction is not covered.
    pub fn read(bytes: &[u8]) -> Result<Self, Error> {
        let elf = object::File::parse(bytes)?;
        let reader = Reader::new(&elf)?;
        let mut functions = BTreeMap::new();
        for (address, (size, name)) in symbols(&elf) {
            functions.insert(address, reader.function(name, address, size)?);
        }
        Ok(Self { functions })
    }

    /// The function at an address.
    ///
    /// # Errors
    /// If there is no function.
    pub fn at(&self, address: u64) -> Result<&Function, Error> {
        self.functions
            .get(&address)
            .ok_or_else(|| Error::NoFunction(format!("{address:#x}")))
    }

    /// The function of a name.
    ///
    /// # Errors
    /// If there is no function.
    pub fn named(&self, name: &str) -> Result<&Function, Error> {
        self.functions
            .values()
            .find(|function| function.name == name)
            .ok_or_else(|| Error::NoFunction(name.into()))
    }

    /// The greatest constant in register r`register` at the calls of a routine by these functions;
    /// `None` if a call has no constant there.
    pub fn greatest_argument<'a>(
        &self,
        callers: impl IntoIterator<Item = &'a Function>,
        routine: u64,
        register: u8,
    ) -> Option<u64> {
        let mut greatest = 0;
        for caller in callers {
            for (at, _) in caller.calls.iter().filter(|(_, callee)| *callee == routine) {
                greatest = greatest.max(caller.greatest_before(*at, register)?);
            }
        }
        Some(greatest)
    }

    /// All functions in the order of their addresses.
    pub fn functions(&self) -> impl Iterator<Item = &Function> {
        self.functions.values()
    }
}

/// Sizes and names of the functions by address.
fn symbols(elf: &object::File<'_>) -> BTreeMap<u64, (u64, String)> {
    elf.symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
        .filter_map(|symbol| {
            let name = format!("{:#}", rustc_demangle::demangle(symbol.name().ok()?));
            Some((symbol.address() & !1, (symbol.size(), name)))
        })
        .collect()
}

fn engine() -> Result<Capstone, Error> {
    let builder = Capstone::new().arm().mode(ArchMode::Thumb);
    let builder = builder.extra_mode([ArchExtraMode::MClass].into_iter());
    Ok(builder.detail(true).build()?)
}

struct Reader<'a> {
    engine: Capstone,
    code: Vec<(u64, &'a [u8])>,
    /// Where data begins (`true`) and instructions begin within the code: the mapping symbols of
    /// the ELF for the Arm architecture.
    mapping: BTreeMap<u64, bool>,
}

impl<'a> Reader<'a> {
    fn new(elf: &object::File<'a>) -> Result<Self, Error> {
        let mut code = Vec::new();
        for section in elf.sections() {
            if section.kind() == SectionKind::Text {
                code.push((section.address(), section.data()?));
            }
        }
        let mapping = elf
            .symbols()
            .filter_map(|symbol| match symbol.name().ok()?.as_bytes() {
                [b'$', kind @ (b'd' | b't'), ..] => Some((symbol.address(), *kind == b'd')),
                _ => None,
            })
            .collect();
        Ok(Self {
            engine: engine()?,
            code,
            mapping,
        })
    }

    /// Up to `size` bytes at an address.
    fn bytes(&self, address: u64, size: u64) -> &'a [u8] {
        let found = self.code.iter().find_map(|(start, data)| {
            let from = usize::try_from(address.checked_sub(*start)?).ok()?;
            let rest = data.get(from..)?;
            Some(&rest[..rest.len().min(size as usize)])
        });
        found.unwrap_or(&[])
    }

    fn function(&self, name: String, address: u64, size: u64) -> Result<Function, Error> {
        let end = address + size;
        let within = |target: &u64| (address..end).contains(target);
        let mut function = Function {
            name,
            address,
            instructions: BTreeMap::new(),
            calls: Vec::new(),
        };
        // How many instructions of an IT block begin at an address.
        let mut conditional = BTreeMap::new();
        let mut todo = vec![address];
        while let Some(at) = todo.pop() {
            if function.instructions.contains_key(&at) {
                continue;
            }
            let problem = |what: String| Error::Instruction {
                function: function.name.clone(),
                address: at,
                what,
            };
            let in_block: u64 = conditional.get(&at).copied().unwrap_or_default();
            let instruction = self.instruction(at, in_block > 0).map_err(problem)?;
            let next = at + instruction.size;
            conditional.insert(
                next,
                instruction.begins_block.max(in_block.saturating_sub(1)),
            );
            // Behind the call of a function that does not return there may be another function.
            let next: Vec<_> = Some(next).filter(within).into_iter().collect();
            let targets = match &instruction.flow {
                Flow::Jump(target) | Flow::Branch(target) => vec![*target],
                // Constants behind the table are no targets; those of a table are in its function.
                Flow::Table { entry } => {
                    let mut targets = self.table(at + instruction.size, *entry);
                    targets.retain(within);
                    targets
                }
                Flow::Call(target) => {
                    function.calls.push((at, *target));
                    Vec::new()
                }
                Flow::Next | Flow::Return { .. } | Flow::Never => Vec::new(),
            };
            let (inside, tail_calls): (Vec<_>, Vec<_>) = targets.into_iter().partition(within);
            function
                .calls
                .extend(tail_calls.into_iter().map(|target| (at, target)));
            let mut following = inside;
            if instruction.flow.continues() {
                following.extend(next);
            }
            todo.extend(&following);
            function.instructions.insert(at, (instruction, following));
        }
        Ok(function)
    }

    fn instruction(&self, at: u64, is_conditional: bool) -> Result<Instruction, String> {
        /// Of the longest instruction.
        const BYTES: u64 = 4;
        let decoded = self
            .engine
            .disasm_count(self.bytes(at, BYTES), at, 1)
            .map_err(|error| error.to_string())?;
        let insn = decoded.first().ok_or("no valid instruction")?;
        Instruction::decode(&self.engine, insn, is_conditional)
    }

    /// Targets of a table at an address: half their distance from it is in each entry.
    fn table(&self, start: u64, entry: u64) -> Vec<u64> {
        let instructions = self.mapping.range(start..).find(|(_, is_data)| !**is_data);
        let end = instructions.map_or(start, |(address, _)| *address);
        let entries = self.bytes(start, end - start);
        let mut targets: Vec<_> = entries
            .chunks_exact(entry as usize)
            .map(|entry| {
                let low = u64::from(entry[0]);
                let high = entry.get(1).map_or(0, |high| u64::from(*high));
                start + 2 * (low | high << 8)
            })
            // The byte that aligns the end of a table of bytes.
            .filter(|target| *target >= end)
            .collect();
        targets.sort_unstable();
        targets.dedup();
        targets
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The function of this code at address 0.
    fn function(code: &[u16]) -> Function {
        let bytes: Vec<u8> = code.iter().flat_map(|it| it.to_le_bytes()).collect();
        let reader = Reader {
            engine: engine().unwrap(),
            code: vec![(0, &bytes)],
            mapping: BTreeMap::new(),
        };
        let size = bytes.len() as u64;
        reader.function("f".into(), 0, size).unwrap()
    }

    #[test]
    fn code_behind_a_conditional_return_is_a_part_of_the_function() {
        // cmp r1, #4; it cc; popcc {r7, pc}; movs r1, #8; pop {r7, pc}
        let with_return = function(&[0x2904, 0xbf38, 0xbd80, 0x2108, 0xbd80]);
        assert_eq!(with_return.instructions.len(), 5);
        // ite cc: the condition of both instructions, not of the third.
        let both = function(&[0x2904, 0xbf34, 0x2108, 0x2109, 0xbd80, 0x2108]);
        assert_eq!(both.instructions.len(), 5);
    }

    #[test]
    fn an_argument_is_the_greatest_constant_of_all_paths_to_the_call() {
        // movs r1, #8; beq 6; movs r1, #32; 6: bl; pop {r7, pc}
        let call = function(&[0x2108, 0xd000, 0x2120, 0xf000, 0xf800, 0xbd80]);
        assert_eq!(call.greatest_before(6, 1), Some(32));
        assert_eq!(call.greatest_before(6, 2), None);
        // After the call its register has any value.
        assert_eq!(call.greatest_before(10, 1), None);
        // ldr r1, [r2]; beq 6
        let unknown = function(&[0x6811, 0xd000, 0x2120, 0xf000, 0xf800, 0xbd80]);
        assert_eq!(unknown.greatest_before(6, 1), None);
    }
}
