//! The bounds of the actuator board's program.

use std::fs;
use std::path::Path;

use program_handlers::{Handler, handlers, of_loop};

use crate::routine::{ROUTINES, Routine};
use crate::{
    Cost, Error, Function, LoopBounds, Program, StackBound, TimeBounds, interrupt_levels,
    stack_bound,
};

/// From the reset to the idle loop.
const START: [&str; 2] = ["Reset", "main"];
/// Handlers of faults and of unexpected interrupts.
const FAULTS: [&str; 2] = ["HardFault", "DefaultHandler"];

/// Bounds of a program for all inputs.
#[derive(Debug)]
pub struct Bounds {
    /// Stack use.
    pub stack: StackBound,
    /// Each handler of the control loop.
    pub times: Vec<HandlerBound>,
}

/// The bound of a handler, without those that preempt it.
#[derive(Debug, Clone)]
pub struct HandlerBound {
    /// The handler.
    pub handler: Handler,
    /// What each of its calls takes at most.
    pub cost: Cost,
}

impl Bounds {
    /// The bounds of the actuator board's program, which is built for this.
    ///
    /// # Errors
    /// If the program has something that the analysis does not cover, or loops without a bound.
    pub fn of_the_board() -> Result<Self, Error> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let read = |path: &str| {
            fs::read_to_string(folder.join(path)).map_err(|error| Error::File(path.into(), error))
        };
        let elf = cross_build::board_elf();
        let bytes = fs::read(elf).map_err(|error| Error::File(elf.display().to_string(), error))?;
        Self::new(&bytes, &read("loops.txt")?)
    }

    /// The bounds of an ELF file of the actuator board with this table of its loops.
    ///
    /// # Errors
    /// As [`Bounds::of_the_board`].
    pub fn new(elf: &[u8], loops: &str) -> Result<Self, Error> {
        let program = Program::read(elf)?;
        let table = LoopBounds::parse(loops)?;
        let time = TimeBounds::new(&program, &table);
        let handlers = handlers(elf)?;
        let times = of_loop(&handlers)
            .map(|handler| {
                Ok(HandlerBound {
                    handler: handler.clone(),
                    cost: time.of(&handler.interrupt)?,
                })
            })
            .collect::<Result<Vec<_>, Error>>()?;
        check_sizes(&program, &time, &times)?;
        let levels = interrupt_levels(&handlers);
        Ok(Self {
            stack: stack_bound(&program, &START, &levels, &FAULTS)?,
            times,
        })
    }

    /// The whole control period.
    pub fn period(&self) -> Cost {
        self.times.iter().map(|it| it.cost * it.handler.runs).sum()
    }
}

/// Checks the sizes in the calls of memory routines in the control period.
fn check_sizes(
    program: &Program,
    time: &TimeBounds<'_>,
    period: &[HandlerBound],
) -> Result<(), Error> {
    let mut reached: Vec<&Function> = Vec::new();
    for HandlerBound { handler, .. } in period {
        for address in time.reached(&handler.interrupt)? {
            reached.push(program.at(address)?);
        }
    }
    // Some of these routines end as others, with the same sizes.
    for Routine {
        name,
        register,
        most,
    } in ROUTINES
    {
        let routines = program
            .functions()
            .filter(|function| function.is_named(name));
        for routine in routines {
            let callers = reached
                .iter()
                .copied()
                .filter(|caller| Routine::of(caller).is_none());
            let greatest = program.greatest_argument(callers, routine.address, register);
            if greatest.is_none_or(|greatest| greatest > most) {
                return Err(Error::Size {
                    routine: name,
                    found: greatest,
                    most,
                });
            }
        }
    }
    Ok(())
}
