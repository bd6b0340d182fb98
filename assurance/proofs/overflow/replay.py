"""Replays the operations of the native program in the executor of the proofs, bit for bit.

It shows that the executor gives the instructions the meaning that the processor gives them.
"""

from ir import Program
from machine import Machine, Memory, Pointer, signed


def replay(program: Program, lines):
    """The number of results that were compared; the first difference is an error."""
    machine, compared = Machine(program, {}), 0
    state, gains, modulator, step = (Pointer(Memory()) for _ in range(4))

    def run(name, *arguments):
        return machine.call(program.function(f"control_proofs::{name}"), arguments)

    run("start", state)
    run("defaults", gains)
    modulator.target.put(0, 8, run("modulator"))
    for line in lines:
        left, right = line.split("->")
        name, *arguments = left.split()
        arguments = [int(a) for a in arguments]
        expected = [int(a) for a in right.split()]
        if name == "set":
            old = Pointer(Memory(gains.target))
            taken = run("set", gains, *arguments)
            run("retune", state, old, gains)
            found = [taken, run("get", gains, arguments[0])]
        elif name == "observe_count":
            run(name, state, gains, *arguments)
            found = [signed(run(f"measured_{what}", state), 64) for what in ("angle", "rate")]
        elif name in ("angle", "rate", "decelerate"):
            value = arguments[0] % (1 << 64)
            if name == "decelerate":
                run(name, step, state, gains, value)
            else:
                run("regulate", step, state, gains, int(name == "rate"), value)
            rate, duty = (step.target.take(at, 8, machine) for at in (0, 8))
            compare = run("compare", modulator, duty)
            found = [signed(rate, 64), signed(duty, 64), signed(compare, 32)]
        else:
            run(name, state, *arguments)
            found = []
        if found != expected:
            raise AssertionError(f"{line.strip()}: the executor gives {found}")
        compared += len(found)
    return compared
