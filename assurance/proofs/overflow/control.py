"""What is proved of the control step: ranges, invariants, contracts of functions and bounds.

All numbers are steps of 2^-32 of their unit, as in `model-core/src/control/units.rs`. The ranges of
parameters come from the table that the program `trace` prints, those of the coefficients
are shown to follow from them by the proof of `set`.
"""

import math

import z3

from machine import Memory, Pointer, known, signed, term

UNIT = 1 << 32
CORE = "model_core::control::"


class Control:
    """The invariants over the layout and the ranges of one build."""

    def __init__(self, program, ranges, rate_hz):
        self.program = program
        self.fields = {
            s: program.members(s) for s in ("CascadeState", "Coefficients", "Modulator")
        }
        self.ranges = ranges
        self.magnitudes = {}
        period = 1.0 / rate_hz
        # The coefficients' greatest values, as powers of two: the bounds that the comments name.
        self.gains = {
            "position.gain": self.power("position_gain"),
            "rate.proportional": self.power("proportional_gain"),
            "rate.integral": self.power("integral_gain", period),
            "rate.anti_windup": self.power("anti_windup_gain", period),
            "rate.feed_forward": self.power("feed_forward_gain"),
            "filter": self.power("rate_filter"),
        }
        self.angle_end = (-32768 * UNIT, 32767 * UNIT)
        # What a count in one period makes, times half a turn.
        self.rate_end = 2048 * 45 * rate_hz * UNIT // 512
        self.integrator_end = 2**28 * UNIT
        self.unlimited_end = 2**29 * UNIT
        # Half of the range of angles on either side, times the gain.
        self.approach_end = UNIT << 16 + self.gains["position.gain"]
        self.duty_end = int(ranges["duty_limit_pct"][1]) * UNIT
        self.commanded_end = 2**17 * UNIT

    def power(self, name, factor=1.0):
        """The least power of two that no value of the parameter exceeds."""
        return max(0, math.ceil(math.log2(self.ranges[name][1] * factor)))

    # Objects with unknown contents.

    def bounded(self, machine, memory, at, bits, name, low, high):
        value = machine.unknown(name, bits)
        machine.assume(z3.And(value >= low, value <= high))
        memory.put(at, bits // 8, value)
        return value

    def coefficients(self, machine, label="gains"):
        memory, fields = Memory(), self.fields["Coefficients"]
        for field, low, high in self.coefficient_ranges():
            at, count = fields[field]
            self.bounded(machine, memory, at, 8 * count, f"{label}.{field}", low, high)
        for gain, power in self.gains.items():
            at = fields[gain + ".coefficient"][0]
            digits = [
                machine.unknown(f"{label}.{gain}.{n}", 32) for n in ("whole", "upper", "lower")
            ]
            for i, digit in enumerate(digits):
                memory.put(at + 4 * i, 4, digit)
            machine.assume(self.is_gain(digits, power))
            machine.gains[digits[0].get_id()] = (gain, power)
            machine.kept.append(digits)
        self.assume_order(machine, memory)
        machine.assume(self.has_mounting(memory))
        return Pointer(memory)

    def coefficient_ranges(self):
        yield "position.min.__0.bits", *self.angle_end
        yield "position.max.__0.bits", *self.angle_end
        yield "position.rate_up.__0.bits", 0, self.commanded_end
        yield "position.rate_down.__0.bits", 0, self.commanded_end
        yield "rate.duty_limit.__0.bits", 0, self.duty_end
        yield "rate.duty_step.__0.bits", 0, 200 * UNIT
        yield "mounting.zero.__0", 0, 4095
        yield "mounting.reversed", 0, 1

    def has_mounting(self, memory):
        return True

    def assume_order(self, machine, memory):
        low, high = (
            memory.take(self.fields["Coefficients"][f"position.{end}.__0.bits"][0], 8, machine)
            for end in ("min", "max")
        )
        machine.assume(low <= high)

    def is_gain(self, digits, power):
        """Digits of `Coefficient::from_parts`: zero to `2^power`, normalised."""
        whole, upper, lower = (term(d, 32) for d in digits)
        value = (
            (z3.SignExt(96, whole) << 64) + (z3.SignExt(96, upper) << 32) + z3.SignExt(96, lower)
        )
        return z3.And(
            value >= 0,
            value <= z3.BitVecVal(1 << (64 + power), 128),
            z3.Or(lower == 0, z3.And(whole == 0, upper <= 2**30, upper >= -(2**30))),
        )

    def state(self, machine):
        memory, fields = Memory(), self.fields["CascadeState"]
        for field, low, high in self.state_ranges():
            at, count = fields[field]
            self.bounded(machine, memory, at, 8 * count, f"state.{field}", low, high)
        last, setpoint = fields["shaft.last"][0], fields["setpoint"][0]
        self.bounded(machine, memory, last, 16, "state.last.is_some", 0, 1)
        self.bounded(machine, memory, last + 2, 16, "state.last", 0, 4095)
        self.bounded(machine, memory, setpoint, 64, "state.setpoint.kind", 0, 2)
        memory.put(setpoint + 8, 8, machine.unknown("state.setpoint", 64))
        return Pointer(memory)

    def state_ranges(self):
        yield "rate.__0.__0.bits", -self.rate_end, self.rate_end
        yield "regulator.integrator.__0.bits", -self.integrator_end, self.integrator_end
        yield "regulator.duty.__0.bits", -self.duty_end, self.duty_end
        yield "regulator.unlimited.__0.bits", -self.unlimited_end, self.unlimited_end
        # Any number: the tracker saturates.
        yield "shaft.counts", -(2**31), 2**31 - 1
        yield "shaft.missed", -(2**15), 2**15 - 1

    # Invariants as obligations.

    def require_state(self, machine, state):
        fields = self.fields["CascadeState"]
        last, setpoint = fields["shaft.last"][0], fields["setpoint"][0]
        is_some = term(state.target.take(last, 2, machine), 16)
        count = term(state.target.take(last + 2, 2, machine), 16)
        ranges = [(*fields[field], low, high) for field, low, high in self.state_ranges()]
        ranges += [(last, 2, 0, 1), (setpoint, 8, 0, 2)]
        conditions = [z3.Or(is_some == 0, z3.ULE(count, 4095))]
        for at, size, low, high in ranges:
            value = term(state.target.take(at, size, machine), 8 * size)
            conditions.append(z3.And(value >= low, value <= high))
        machine.require(z3.And(*conditions), "the state keeps its invariant")

    def require_coefficients(self, machine, gains):
        for field, low, high in self.coefficient_ranges():
            at, count = self.fields["Coefficients"][field]
            self.require_range(machine, gains, at, 8 * count, field, low, high)
        low, high = (
            term(
                gains.target.take(
                    self.fields["Coefficients"][f"position.{e}.__0.bits"][0], 8, machine
                ),
                64,
            )
            for e in ("min", "max")
        )
        machine.require(low <= high, "the limits of position are in order")
        for gain, power in self.gains.items():
            at = self.fields["Coefficients"][gain + ".coefficient"][0]
            digits = [gains.target.take(at + 4 * i, 4, machine) for i in range(3)]
            machine.require(self.is_gain(digits, power), f"{gain} is at most 2^{power}")

    def require_range(self, machine, place, at, bits, name, low, high):
        value = term(place.target.take(place.offset + at, bits // 8, machine), bits)
        machine.require(z3.And(value >= low, value <= high), f"{name} keeps its invariant")

    # Contracts.

    def contracts(self):
        return {
            CORE + "arithmetic::Coefficient::times": self.times,
            CORE + "shaft_tracker::ShaftTracker::angle": self.angle,
            **self.limiters(),
        }

    def limiters(self):
        """The three limiters without branches, shown by the proof of `limits`."""
        return {
            CORE + "units::limit": self.limit,
            CORE + "units::limit_between": self.limit_between,
            CORE + "units::limit_whole": self.limit_whole,
        }

    def limiter_requires(self, name, low, high):
        """What a limiter's ends have to keep."""
        if name.endswith("limit_between"):
            return z3.And(*(z3.And(end >= 0, end < 2**30 * UNIT) for end in (low, high)))
        return z3.BoolVal(True)

    def limit(self, machine, arguments, caller):
        place, low, high = arguments
        return self.limited(machine, place, term(low, 64), term(high, 64))

    def limit_between(self, machine, arguments, caller):
        place, down, up = arguments[0], term(arguments[1], 64), term(arguments[2], 64)
        requires = self.limiter_requires("limit_between", down, up)
        machine.require(requires, "the ends of a limit are below 2^30")
        return self.limited(machine, place, -down, up)

    def limit_whole(self, machine, arguments, caller):
        place, end = arguments[0], signed(arguments[1], 32) * UNIT
        self.limited(machine, place, z3.BitVecVal(-end, 64), z3.BitVecVal(end, 64))

    def limited(self, machine, place, low, high):
        value = term(place.target.take(place.offset, 8, machine), 64)
        limited = z3.If(value > high, high, z3.If(value < low, low, value))
        place.target.put(place.offset, 8, known(z3.simplify(limited)))
        return z3.If(z3.Or(value > high, value < low), z3.BitVecVal(1, 1), z3.BitVecVal(0, 1))

    def times(self, machine, arguments, caller):
        """The nearest step to the product, shown by `product_is_the_nearest_step`."""
        place, signal = arguments
        first = place.target.take(place.offset, 4, machine)
        assert not isinstance(first, int), machine.told("a coefficient that is known")
        gain, power = machine.gains[first.get_id()]
        signal = term(signal, 64)
        # The documentation of `times`: signal and product lie within +-2^30.
        end = 1 << 62 - power
        machine.require(
            z3.And(signal <= end, signal >= -end), f"signal and product of {gain} lie within 2^30"
        )
        for _, words, name, bound in SIGNALS:
            if name == gain:
                machine.require(z3.And(signal <= bound, signal >= -bound), f"comment: {words}")
        key = (first.get_id(), signal.get_id())
        if key not in machine.products:
            product = machine.unknown(f"product.{gain}", 64)
            if power == 0:
                # A share of the signal, towards zero.
                machine.assume(
                    z3.If(
                        signal < 0,
                        z3.And(product <= 0, product >= signal),
                        z3.And(product >= 0, product <= signal),
                    )
                )
            else:
                most = self.magnitude(machine, signal) << power
                machine.assume(z3.And(product <= most, product >= -most))
            machine.products[key] = (product, signal, first)
        return machine.products[key][0]

    def magnitude(self, machine, signal):
        """A power of two, in steps, that the signal does not exceed on this path."""
        key = (repr(machine.decisions[: machine.made]), machine.counter)
        if key not in self.magnitudes:
            powers = (
                p
                for p in (16, 17, 18, 29)
                if not machine.is_possible(z3.Or(signal > UNIT << p, signal < -(UNIT << p)))
            )
            self.magnitudes[key] = UNIT << next(powers, 30)
        return self.magnitudes[key]

    def close(self, machine, arguments, caller):
        """`CascadeState::close`, shown by the proofs of `angle` and `rate`."""
        state = arguments[1]
        for field, low, high in self.state_ranges():
            if field.startswith("regulator"):
                at, size = self.fields["CascadeState"][field]
                self.bounded(machine, state.target, state.offset + at, 8 * size, field, low, high)

    def follow_rate(self, machine, arguments, caller):
        """`PositionLoop::follow_rate`, shown by a proof of its own."""
        place, gains = arguments[:2]
        at = gains.offset - self.fields["Coefficients"]["position"][0]
        up, down = (
            term(
                gains.target.take(
                    at + self.fields["Coefficients"][f"position.rate_{way}.__0.bits"][0],
                    8,
                    machine,
                ),
                64,
            )
            for way in ("up", "down")
        )
        rate = machine.unknown("commanded", 64)
        machine.assume(z3.And(rate <= up, rate >= -down))
        place.target.put(place.offset, 8, rate)
        for i in (8, 9):
            self.bounded(machine, place.target, place.offset + i, 8, "limited", 0, 1)

    def approach(self, machine, arguments, caller):
        """`PositionLoop::approach`, shown by a proof of its own."""
        rate = machine.unknown("approach", 64)
        machine.assume(z3.And(rate <= self.approach_end, rate >= -self.approach_end))
        return rate

    def angle(self, machine, arguments, caller):
        """`ShaftTracker::angle`, shown by the proof of `observe`."""
        angle, end = machine.unknown("angle", 64), 2**15 * UNIT
        machine.assume(z3.And(angle <= end, angle >= -end))
        return angle


# The bounds of a product's signal that comments state: file, words of the comment, gain, bound.
SIGNALS = [
    (
        "position_loop.rs",
        "so the error lies within 2^16 and P times it within 2^25",
        "position.gain",
        2**16 * UNIT,
    ),
    ("rate_estimate.rs", "so the difference lies within 2^17", "filter", 2**17 * UNIT),
    ("rate_loop.rs", "so `|e| < 2^18`", "rate.proportional", 2**18 * UNIT - 1),
    ("rate_loop.rs", "`|r| <= 2^17`", "rate.feed_forward", 2**17 * UNIT),
    ("rate_loop.rs", "hence `|v|, |u - v| < 2^29`", "rate.anti_windup", 2**29 * UNIT - 1),
]

# The bounds that comments state: file, the words of the comment, function, register, bound.
COMMENTS = [
    (
        "rate_estimate.rs",
        "the product fits 31 bits by the choice of FRACTION_BITS",
        "rate_estimate::RateEstimate::update",
        "%travelled",
        2**31 - 1,
    ),
    (
        "rate_estimate.rs",
        "within 45,000 deg/s",
        "rate_estimate::RateEstimate::update",
        "%raw",
        45_000 * UNIT,
    ),
    (
        "rate_loop.rs",
        "so `|e| < 2^18`",
        "rate_loop::RateLoopState::step",
        "%error",
        2**18 * UNIT - 1,
    ),
    (
        "rate_loop.rs",
        "hence `|v|, |u - v| < 2^29`",
        "rate_loop::RateLoopState::step",
        "%unlimited",
        (2**28 + 2**26) * UNIT,
    ),
    (
        "rate_loop.rs",
        "below `2^28 + 2^19 + 2^29 < 2^30`",
        "rate_loop::RateLoopState::step",
        "%correction",
        (2**19 + 2**29) * UNIT,
    ),
]


def watched(bits_of):
    """Checks of the registers that comments bound."""

    def check(what, bound):
        def required(machine, value):
            bits = 64 if isinstance(value, int) else value.size()
            value = term(value, bits)
            machine.require(z3.And(value <= bound, value >= -bound), f"comment: {what}")
            # From here on only the bound is known of it.
            cut = machine.unknown("bounded", bits)
            machine.assume(z3.And(cut <= bound, cut >= -bound))
            return cut

        return required

    return {
        (CORE + function, register): check(words, bound)
        for _, words, function, register, bound in bits_of
    }
