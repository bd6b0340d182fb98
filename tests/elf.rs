//! Properties of the boards' programs that need no execution.

use std::{fmt::Write as _, fs, ops::Range, path::Path};

use cross_build::{board_elf, board_h743_elf, bring_up_elf, comm_board_elf};
use object::{File, Object, ObjectSection, ObjectSymbol, SectionFlags, elf};

/// The capture buffer, which the limits exclude: it takes the rest of the memory.
const CAPTURE_BUFFER: &str = "capture_buffer";

/// A program with its limits, bytes: flash, and SRAM without the capture buffer. The stack has a
/// its own memory; a test on the emulated board measures how much of it is used.
struct Program {
    name: &'static str,
    elf: fn() -> &'static Path,
    /// The linker script with the memory map.
    script: &'static str,
    flash: u64,
    ram: u64,
}

/// Memory maps of the chips.
const F427: &str = "../memory.x";
const H743: &str = "../firmware/boards/h743/h743.x";

const PROGRAMS: [Program; 4] = [
    Program {
        name: "actuator-board",
        elf: board_elf,
        script: F427,
        // The slot has 224 KiB, and the buffer of a download 176 KiB.
        flash: 175 * 1024,
        // Beside the buffer of captures; the loop's memory is a region of 4 KiB.
        ram: 16 * 1024,
    },
    Program {
        name: "actuator-board-h743",
        elf: board_h743_elf,
        script: H743,
        flash: 175 * 1024,
        // Beside the buffer of captures; the loop's memory is a region of 4 KiB.
        ram: 28 * 1024,
    },
    Program {
        name: "bring-up",
        elf: bring_up_elf,
        script: F427,
        flash: 16 * 1024,
        ram: 4 * 1024,
    },
    Program {
        name: "comm-board",
        elf: comm_board_elf,
        script: F427,
        flash: 16 * 1024,
        ram: 24 * 1024,
    },
];

fn for_each_elf(mut test: impl FnMut(&Program, &File<'_>)) {
    for program in &PROGRAMS {
        println!("{}", program.name);
        let bytes = fs::read((program.elf)()).expect("the ELF was built");
        test(program, &File::parse(&*bytes).expect("an ELF"));
    }
}

/// Demangled names of everything that was linked.
fn symbols(elf: &File<'_>) -> Vec<String> {
    let names = elf
        .symbols()
        .filter_map(|symbol| symbol.name().ok().map(str::to_owned));
    names
        .map(|name| format!("{:#}", rustc_demangle::demangle(&name)))
        .collect()
}

fn address(elf: &File<'_>, name: &str) -> u64 {
    let symbol = elf.symbols().find(|symbol| symbol.name() == Ok(name));
    symbol
        .unwrap_or_else(|| panic!("{name} is no symbol"))
        .address()
}

/// Name and addresses of each region of a linker script.
fn regions(script: &str) -> Vec<(String, Range<u64>)> {
    let script = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(script));
    let script = script.expect("the script is there");
    let number = |text: &str| {
        let (digits, unit) = text
            .strip_suffix('K')
            .map_or((text, 1), |digits| (digits, 1024));
        let value = digits
            .strip_prefix("0x")
            .map_or_else(|| digits.parse(), |digits| u64::from_str_radix(digits, 16));
        value.unwrap_or_else(|_| panic!("{text} is no number")) * unit
    };
    // What a build script may define comes first: a region's own number is the last word.
    let last = |text: &str| text.split([' ', '\n']).next_back().map(number);
    let regions = script
        .split(": ORIGIN = ")
        .zip(script.split(": ORIGIN = ").skip(1));
    regions
        .map(|(before, region)| {
            let name = before.split_whitespace().next_back().unwrap_or_default();
            let (origin, rest) = region.split_once(',').expect("a length");
            let (_, length) = rest.split_once("LENGTH = ").expect("a length");
            let length = length.split(" /*").next().unwrap_or_default();
            let length = length.lines().next().unwrap_or_default();
            let (origin, length) = (last(origin), last(length));
            let origin = origin.expect("an origin");
            (name.to_owned(), origin..origin + length.expect("a length"))
        })
        .collect()
}

/// The flash of a program: that of its script, or what its build script has defined.
fn flash_region(script: &str, elf: &File<'_>) -> Range<u64> {
    let defined = |name| {
        let symbol = elf.symbols().find(|symbol| symbol.name() == Ok(name));
        symbol.map(|symbol| symbol.address())
    };
    match (defined("_flash_start"), defined("_flash_size")) {
        (Some(start), Some(size)) => start..start + size,
        _ => region(script, "FLASH"),
    }
}

fn region(script: &str, name: &str) -> Range<u64> {
    let regions = regions(script);
    let found = regions.into_iter().find(|(other, _)| other == name);
    found.unwrap_or_else(|| panic!("{script} has no {name}")).1
}

/// Name and addresses of each section in the processor's memory.
fn allocated(elf: &File<'_>) -> Vec<(String, Range<u64>)> {
    let in_memory = |flags| matches!(flags, SectionFlags::Elf { sh_flags } if sh_flags & u64::from(elf::SHF_ALLOC) != 0);
    let sections = elf
        .sections()
        .filter(|section| in_memory(section.flags()) && section.size() > 0);
    sections
        .map(|s| {
            (
                s.name().unwrap_or_default().to_owned(),
                s.address()..s.address() + s.size(),
            )
        })
        .collect()
}

fn is_within(inner: &Range<u64>, outer: &Range<u64>) -> bool {
    outer.start <= inner.start && inner.end <= outer.end
}

#[test]
fn nothing_can_panic_allocate_or_compute_in_emulated_floating_point() {
    // Floating-point functions of the C runtime and of Rust: arithmetic, comparison and conversion
    // in single and double precision.
    let emulated = |name: &str| {
        let aeabi = name.strip_prefix("__aeabi_").is_some_and(|operation| {
            let first = operation.chars().next();
            let converts = ["i2f", "i2d", "l2f", "l2d"]
                .iter()
                .any(|c| operation.ends_with(c));
            matches!(first, Some('f' | 'd'))
                || operation.starts_with("cd")
                || operation.starts_with("cf")
                || converts
        });
        aeabi
            || name.contains("compiler_builtins::float")
            || name.ends_with("df3")
            || name.ends_with("sf3")
    };
    let allocates = |name: &str| {
        name.contains("__rust_alloc") || name.contains("__rg_alloc") || name == "malloc"
    };
    let panics =
        |name: &str| name.contains("core::panicking") || name.contains("a_path_to_a_panic");
    for_each_elf(|_, elf| {
        let mut found = symbols(elf);
        found.retain(|name| panics(name) || allocates(name) || emulated(name));
        assert_eq!(found, Vec::<String>::new());
    });
}

#[test]
fn every_section_is_in_its_region_of_memory_x() {
    for_each_elf(|program, elf| {
        let flash = flash_region(program.script, elf);
        let ram = region(program.script, "RAM");
        for (name, addresses) in allocated(elf) {
            let core = (name == CORE_MEMORY).then(|| region(program.script, "CORE"));
            let right = match &core {
                Some(core) => core,
                None if addresses.start < ram.start => &flash,
                None => &ram,
            };
            assert!(
                is_within(&addresses, right),
                "{name} lies at {addresses:x?}"
            );
        }
    });
}

#[test]
fn the_regions_match_the_reference_manuals() {
    let region = |name| self::region(F427, name);
    // RM0090, table 6 and section 2.3.1.
    let bank_1 = 0x0800_0000..0x0810_0000;
    let core_coupled = 0x1000_0000..0x1001_0000;
    let sram = 0x2000_0000..0x2003_0000;
    assert!(
        is_within(&region("FLASH"), &bank_1),
        "parameters are in bank 2"
    );
    assert!(is_within(&region("STACK"), &core_coupled));
    assert_eq!(
        region("STACK").start,
        core_coupled.start,
        "an overflow faults"
    );
    assert!(is_within(&region("CORE"), &core_coupled));
    assert_eq!(region("CORE").start, region("STACK").end);
    assert_eq!(region("RAM"), sram);

    // RM0433, table 15 and section 2.3.2.
    let region = |name| self::region(H743, name);
    let data_tcm = 0x2000_0000..0x2002_0000;
    assert!(is_within(&region("FLASH"), &(0x0800_0000..0x0810_0000)));
    assert!(is_within(&region("STACK"), &data_tcm));
    assert_eq!(region("STACK").start, data_tcm.start, "an overflow faults");
    assert_eq!(region("RAM"), 0x2400_0000..0x2408_0000);
}

#[test]
fn no_other_section_is_in_the_memory_of_the_stack() {
    for_each_elf(|program, elf| {
        let stack = region(program.script, "STACK");
        assert_eq!(address(elf, "_stack_start"), stack.end);
        assert_eq!(address(elf, "_stack_end"), stack.start);
        // The initial stack pointer, which the processor loads at reset.
        let vectors = elf
            .section_by_name(".vector_table")
            .expect("a vector table");
        let first = vectors
            .data()
            .expect("its contents")
            .first_chunk::<4>()
            .copied();
        assert_eq!(
            u64::from(u32::from_le_bytes(first.expect("a vector"))),
            stack.end
        );
        for (name, addresses) in allocated(elf) {
            let is_apart = addresses.end <= stack.start || addresses.start >= stack.end;
            assert!(is_apart, "{name} lies at {addresses:x?}");
        }
    });
}

/// Data beside the stack, in the core-coupled memory of the STM32F427.
const CORE_MEMORY: &str = ".core_memory";

/// Bytes of flash; of SRAM without the capture buffer; of the stack.
fn sizes(program: &Program, elf: &File<'_>) -> [u64; 3] {
    let ram = region(program.script, "RAM");
    let (mut flash_bytes, mut ram_bytes) = (0, 0);
    for (name, addresses) in allocated(elf)
        .into_iter()
        .filter(|(name, _)| name != CORE_MEMORY)
    {
        let size = addresses.end - addresses.start;
        if addresses.start < ram.start || name == ".data" {
            flash_bytes += size;
        }
        if addresses.start >= ram.start {
            ram_bytes += size;
        }
    }
    let names = elf
        .symbols()
        .filter(|s| s.name().is_ok_and(|name| name.contains(CAPTURE_BUFFER)));
    let capture: u64 = names.map(|symbol| symbol.size()).sum();
    let stack = region(program.script, "STACK");
    [flash_bytes, ram_bytes - capture, stack.end - stack.start]
}

#[test]
fn flash_and_ram_stay_below_their_limits() {
    for_each_elf(|program, elf| {
        let [flash, ram, stack] = sizes(program, elf);
        println!("flash {flash} bytes, SRAM {ram} bytes, stack {stack} bytes");
        assert!(flash < program.flash);
        assert!(ram < program.ram);
    });
}

#[test]
fn flash_and_ram_match_their_golden_sizes() {
    for_each_elf(|program, elf| {
        let file = format!("golden/{}.size", program.name);
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let now = sizes(program, elf);
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            let mut text = String::new();
            for (name, size) in ["flash", "ram", "stack"].iter().zip(now) {
                writeln!(text, "{name} {size}").expect("a string");
            }
            fs::write(&path, &text).expect("the golden file is written");
        }
        let golden = fs::read_to_string(&path).expect("the golden file");
        for (line, size) in golden.lines().zip(now) {
            let golden: u64 = line
                .split(' ')
                .next_back()
                .and_then(|n| n.parse().ok())
                .expect("a size");
            // Changes below 2 % also result from the compiler's decisions.
            assert!(
                size.abs_diff(golden) * 50 <= golden,
                "{line}, now {size}; if that is intended: UPDATE_GOLDEN=1 cargo test -p system-tests --test elf"
            );
        }
    });
}

#[test]
fn the_log_strings_can_be_decoded() {
    let bytes = fs::read(board_elf()).expect("the ELF was built");
    let table = defmt_decoder::Table::parse(&bytes)
        .expect("a table")
        .expect("a log");
    let started = table
        .raw_symbols()
        .find(|text| text.contains("reset cause"));
    assert!(
        started.is_some(),
        "{:?}",
        table.raw_symbols().collect::<Vec<_>>()
    );
    let places = table.get_locations(&bytes).expect("debug information");
    assert!(
        table
            .indices()
            .all(|index| places.contains_key(&(index as u64)))
    );
}
