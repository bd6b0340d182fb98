"""Numbers of Python or of z3, addresses, and the memory that holds them."""

import z3


class Violation(Exception):
    """Something that must not happen can happen."""


class Pointer:
    """An address: an object and an offset in bytes."""

    def __init__(self, target, offset=0):
        self.target, self.offset = target, offset


class Memory(dict):
    """An object: the numbers at byte offsets, as (bytes, value)."""

    def put(self, at, count, value):
        self.clear_range(at, count)
        self[at] = (count, value)

    def clear_range(self, at, count):
        for other in [o for o, (n, _) in self.items() if o < at + count and at < o + n]:
            n, value = self.pop(other)
            for i in range(n):
                if not at <= other + i < at + count:
                    self[other + i] = (1, part(value, i, n))

    def take(self, at, count, machine):
        if at in self and self[at][0] == count:
            return self[at][1]
        value = None
        for i in range(count):
            holder = next((o for o, (n, _) in self.items() if o <= at + i < o + n), None)
            byte = (
                machine.unknown("unset", 8)
                if holder is None
                else part(self[holder][1], at + i - holder, self[holder][0])
            )
            value = byte if value is None else join(byte, value, 8, 8 * i)
        return value


def part(value, index, count):
    assert not isinstance(value, Pointer), "a part of an address"
    if count == 1:
        return value
    if isinstance(value, int):
        return value >> 8 * index & 0xFF
    return z3.simplify(z3.Extract(8 * index + 7, 8 * index, value))


def join(high, low, high_bits, low_bits):
    if isinstance(high, int) and isinstance(low, int):
        return high << low_bits | low
    return known(z3.simplify(z3.Concat(term(high, high_bits), term(low, low_bits))))


def term(value, bits):
    return z3.BitVecVal(value, bits) if isinstance(value, int) else value


def known(value):
    """An integer in place of a constant."""
    return value.as_long() if z3.is_bv_value(value) else value


def signed(value, bits):
    return value - (1 << bits) if value >> (bits - 1) else value
