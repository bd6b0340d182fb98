"""Proves that the control step has no overflow, for all states within its invariants, all inputs
and all parameters, and that the invariants are inductive (docs/proofs.md).

Each proof executes one function and requires its obligations; `check.py` runs all of them.
"""

import pathlib

import z3

from control import COMMENTS, CORE, SIGNALS, UNIT, watched
from machine import Machine, Memory, Pointer, Violation, explore, term

# Where a digit of a number is taken, a cast is to drop the rest.
INTENDED = {CORE + "arithmetic::digits", CORE + "arithmetic::Coefficient::times_digits"}


PRECISION = CORE + (
    "cascade::single_precision::_$LT$impl$u20$model_core..control..cascade..Coefficients$GT$::"
)
POSITION = CORE + "position_loop::PositionLoop::"


class Proof:
    def __init__(self, program, control):
        self.program, self.control = program, control
        self.sites, self.paths = set(), 0

    def machine(self, contracts=None):
        def make(decisions):
            machine = Machine(
                self.program,
                self.control.contracts() if contracts is None else contracts,
                watched(COMMENTS),
                INTENDED,
                decisions,
            )
            machine.gains, machine.products, machine.kept = {}, {}, []
            return machine

        return make

    def function(self, name, run, contracts=None):
        paths, sites = explore(self.machine(contracts), run)
        self.sites |= sites
        self.paths += paths

    def call(self, machine, name, *arguments):
        return machine.call(self.program.function(f"control_proofs::{name}"), arguments)

    # The functions of the control step.

    def start(self, machine):
        state = Pointer(Memory())
        self.call(machine, "start", state)
        self.control.require_state(machine, state)

    def defaults(self, machine):
        gains = Pointer(Memory())
        self.call(machine, "defaults", gains)
        self.control.require_coefficients(machine, gains)

    def observe(self, machine):
        state, gains = self.control.state(machine), self.control.coefficients(machine)
        is_some, count = machine.unknown("is_some", 16), machine.unknown("count", 16)
        machine.assume(z3.And(z3.ULE(is_some, 1), z3.ULE(count, 4095)))
        self.call(machine, "observe", state, gains, is_some, count)
        self.control.require_state(machine, state)

    def measured(self, machine):
        machine.contracts = {}
        state = self.control.state(machine)
        angle = term(self.call(machine, "measured_angle", state), 64)
        end = 2**15 * UNIT
        machine.require(z3.And(angle <= end, angle >= -end), "the angle lies within 2^15 deg")

    def closed(self, machine, name, *setpoint):
        state, gains, step = (
            self.control.state(machine),
            self.control.coefficients(machine),
            Pointer(Memory()),
        )
        self.call(machine, name, step, state, gains, *setpoint)
        self.control.require_state(machine, state)
        rate, duty = (term(step.target.take(at, 8, machine), 64) for at in (0, 8))
        end = self.control.commanded_end
        machine.require(
            z3.And(rate <= end, rate >= -end), "the commanded rate lies within 2^17 deg/s"
        )
        at = self.control.fields["Coefficients"]["rate.duty_limit.__0.bits"][0]
        limit = term(gains.target.take(at, 8, machine), 64)
        machine.require(z3.And(duty <= limit, duty >= -limit), "the duty lies within its limit")

    def angle(self, machine):
        self.closed(machine, "regulate", 0, machine.unknown("angle", 64))

    def rate(self, machine):
        machine.contracts = {
            **machine.contracts,
            POSITION + "follow_rate": self.control.follow_rate,
        }
        self.closed(machine, "regulate", 1, machine.unknown("rate", 64))

    def approach(self, machine):
        angle, end, bound = (
            machine.unknown("angle", 64),
            machine.unknown("end", 64),
            self.control.approach_end,
        )
        for value in (angle, end):
            machine.assume(z3.And(value <= UNIT << 15, value >= -(UNIT << 15)))
        position = self.position(machine)
        rate = machine.call(self.program.function(POSITION + "approach"), [position, end, angle])
        machine.require(
            z3.And(term(rate, 64) <= bound, term(rate, 64) >= -bound), "the rate lies within 2^25"
        )

    def follow_rate(self, machine):
        machine.contracts = {**machine.contracts, POSITION + "approach": self.control.approach}
        place, angle = Pointer(Memory()), machine.unknown("angle", 64)
        machine.assume(z3.And(angle <= UNIT << 15, angle >= -(UNIT << 15)))
        position = self.position(machine)
        command = machine.unknown("command", 64)
        machine.call(
            self.program.function(POSITION + "follow_rate"), [place, position, command, angle]
        )
        at = self.control.fields["Coefficients"]
        up, down = (
            term(position.target.take(at[f"position.rate_{w}.__0.bits"][0], 8, machine), 64)
            for w in ("up", "down")
        )
        rate = term(place.target.take(0, 8, machine), 64)
        machine.require(
            z3.And(rate <= up, rate >= -down), "the commanded rate lies within its limits"
        )

    def position(self, machine):
        """The position loop of unknown coefficients."""
        gains = self.control.coefficients(machine)
        return Pointer(gains.target, self.control.fields["Coefficients"]["position"][0])

    def decelerate(self, machine):
        self.closed(machine, "decelerate", machine.unknown("rate", 64))

    def retune(self, machine):
        machine.contracts = {CORE + "cascade::CascadeState::close": self.control.close}
        state = self.control.state(machine)
        old, new = (self.control.coefficients(machine, label) for label in ("old", "new"))
        self.call(machine, "retune", state, old, new)
        self.control.require_state(machine, state)

    def miss(self, machine):
        state = self.control.state(machine)
        self.call(machine, "miss", state, machine.unknown("periods", 16))
        self.control.require_state(machine, state)

    def release(self, machine):
        state = self.control.state(machine)
        self.call(machine, "release", state)
        self.control.require_state(machine, state)

    def reset_position(self, machine):
        state = self.control.state(machine)
        self.call(machine, "reset_position", state)
        self.control.require_state(machine, state)

    def read(self, machine):
        self.call(machine, "read", machine.unknown("word", 32))

    def compare(self, machine):
        half, memory = 1 << 31, Memory()
        self.control.bounded(machine, memory, 0, 64, "remainder", -half, half - 1)
        duty = machine.unknown("duty", 64)
        machine.assume(z3.And(duty <= self.control.duty_end, duty >= -self.control.duty_end))
        counts = term(self.call(machine, "compare", Pointer(memory), duty), 32)
        machine.require(
            z3.And(counts <= 56_000, counts >= -56_000), "the compare value fits the period"
        )
        self.control.require_range(machine, Pointer(memory), 0, 64, "remainder", -half, half - 1)

    def set(self, row):
        def run(machine):
            gains = self.control.coefficients(machine)
            bits = machine.unknown("bits", 32)
            # What is read decides only whether anything is written; `get` has a proof of its own.
            machine.contracts = {PRECISION + "get": lambda m, a, c: (1, m.unknown("read", 32))}
            self.call(machine, "set", gains, row, bits)
            self.control.require_coefficients(machine, gains)

        return run

    def get(self, row):
        def run(machine):
            self.call(machine, "get", self.control.coefficients(machine), row)

        return run

    def times(self, machine):
        """Digits and their products give the step nearest to the whole product."""
        digits = [machine.unknown(name, 32) for name in ("whole", "upper", "lower")]
        whole, upper, lower = digits
        machine.assume(z3.Or(lower == 0, z3.And(whole == 0, upper <= 2**30, upper >= -(2**30))))
        memory = Memory()
        for i, digit in enumerate(digits):
            memory.put(4 * i, 4, digit)
        signal = machine.unknown("signal", 64)
        machine.assume(z3.And(signal <= 1 << 62, signal >= -(1 << 62)))
        products = {}

        def product(machine, arguments, caller):
            # Two numbers of 32 bits: a product of 62 bits and a sign at the most, zero with a zero,
            # and half of that with a factor within 2^30.
            a, b = (term(x, 32) for x in arguments)
            value = machine.unknown("product", 64)
            machine.assume(z3.And(value <= 1 << 62, value >= -(1 << 62)))
            machine.assume(z3.Implies(z3.Or(a == 0, b == 0), value == 0))
            small = z3.And(b <= 2**30, b >= -(2**30))
            machine.assume(z3.Implies(small, z3.And(value <= 1 << 61, value >= -(1 << 61))))
            products[len(products)] = (a, b, value)
            return value

        def wrapping_mul(machine, arguments, caller):
            # The low digit of the product of the upper digits.
            value = machine.unknown("wrapped", 32)
            products["wrapped"] = (*arguments, value)
            return value

        multiply = next(
            n for n in self.program.of_path if "num" in n and n.endswith("l12wrapping_mul")
        )
        self.contracts_of_times = {CORE + "arithmetic::product": product, multiply: wrapping_mul}
        machine.contracts = self.contracts_of_times
        result = term(
            machine.call(
                self.program.function(CORE + "arithmetic::Coefficient::times_digits"),
                [Pointer(memory), signal],
            ),
            64,
        )
        low_lower, low_upper, high_lower, high_upper, low_whole = (
            products[i][2] for i in range(5)
        )
        for index, pair in enumerate([(0, lower), (0, upper), (1, lower), (1, upper), (0, whole)]):
            machine.require(
                term(products[index][1], 32) == pair[1], "a product is of these digits"
            )
        low, high = products[0][0], products[2][0]
        signed = z3.SignExt(32, low) + (z3.SignExt(32, high) << 32)
        machine.require(signed == signal, "digits make the signal")
        machine.require(
            z3.And(products["wrapped"][0] == high, products["wrapped"][1] == whole),
            "the last product is of these digits",
        )
        # The sum in the order of the code.
        lowest = (low_lower >> 32) + (1 << 31)
        nearest = ((lowest + low_upper + high_lower) >> 32) + high_upper
        # Modulo 2^64: the caller shows that the product itself lies within 2^62.
        exact = nearest + low_whole + (z3.SignExt(32, products["wrapped"][2]) << 32)
        machine.require(exact == result, "the result is the sum of the products")
        ll, lu, hl, hu = (z3.Int(name) for name in ("ll", "lu", "hl", "hu"))
        nested = (ll / 2**32 + 2**31 + lu + hl) / 2**32 + hu
        whole = (ll + (lu + hl) * 2**32 + hu * 2**64 + 2**63) / 2**64
        solver = z3.Solver()
        solver.add(nested != whole)
        if solver.check() != z3.unsat:
            raise Violation("the sum of the products is not the nearest step to the whole product")

    def limiter(self, name, contract, function):
        """A limiter keeps its contract."""

        def run(machine):
            machine.contracts = {}
            value, low, high = (machine.unknown(n, 64) for n in ("value", "low", "high"))
            places = [Pointer(Memory()) for _ in range(2)]
            for place in places:
                place.target.put(0, 8, value)
            ends = (
                [low, high]
                if not name.endswith("limit_whole")
                else [self.control.integrator_end >> 32]
            )
            machine.assume(self.control.limiter_requires(name, low, high))
            acted = contract(machine, [places[0], *ends], "")
            found = machine.call(function, [places[1], *ends])
            if acted is not None:
                machine.require(term(acted, 1) == term(found, 1), "the contract's result")
            kept = [term(place.target.take(0, 8, machine), 64) for place in places]
            machine.require(kept[0] == kept[1], "the contract's value")

        return run


def functions(proof):
    """All proofs by name: what is printed, what is executed."""
    names = [
        "times",
        "observe",
        "angle",
        "retune",
        "decelerate",
        "rate",
        "approach",
        "follow_rate",
        "measured",
        "start",
        "defaults",
        "miss",
        "release",
        "reset_position",
        "read",
        "compare",
    ]
    found = {name: (name, getattr(proof, name)) for name in names}
    for path, contract in proof.control.limiters().items():
        for i, function in enumerate(proof.program.of_path[path]):
            name = f"{path.split('::')[-1]} {i}"
            found[name] = name, proof.limiter(path, contract, function)
    for row, parameter in enumerate(proof.control.ranges):
        for kind in ("set", "get"):
            name = f"{kind} {parameter}"
            found[name] = name, getattr(proof, kind)(row)
    return found


def comments_stand(workspace):
    """Each bound that is proved stands in the comment that states it."""
    for file, words, *_ in COMMENTS + SIGNALS:
        path = pathlib.Path(workspace) / "model-core/src/control" / file
        text = " ".join(line.strip().lstrip("/!").strip() for line in path.read_text().split("\n"))
        assert words in text, f"{path}: no comment says: {words}"


def ranges_of(lines):
    """Least and greatest value of each parameter, of the lines `range NAME MIN MAX`."""
    return {
        p[1]: (float(p[2]), float(p[3])) for p in map(str.split, lines) if p and p[0] == "range"
    }
