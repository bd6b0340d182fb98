"""Executes functions of LLVM's intermediate code on every path, with numbers that may be unknown.

A number is an integer of Python where it is known and a bit-vector of z3 where it is not. At a
branch that depends on an unknown number each direction that the conditions so far allow is a path
of its own. Reached panics and overflows are violations; z3 gives the numbers that lead there.
"""

import re

import z3

from ir import demangled
from operations import Frame
from values import Memory, Pointer, Violation, known, signed, term

__all__ = ["Machine", "Memory", "Pointer", "Violation", "explore", "known", "signed", "term"]


class Machine:
    """One path; `decisions` are those of its branches, which `explore` extends."""

    def __init__(self, program, contracts, watched=None, intended=(), decisions=()):
        self.program, self.contracts, self.watched = program, contracts, watched or {}
        self.intended, self.decisions, self.made = intended, list(decisions), 0
        self.conditions = []
        self.counter, self.pending, self.sites, self.instruction = 0, [], set(), ("", "")
        self.globals = {}

    # What is unknown, what is assumed and what has to hold.

    def unknown(self, name, bits):
        self.counter += 1
        return z3.BitVec(f"{name}.{self.counter}", bits)

    def assume(self, condition):
        self.conditions.append(condition)

    def check(self, *more):
        """Whether the conditions of this path and these can be true, and numbers for which so.

        A solver of its own for each question: preprocessing makes it several times faster than one
        that is kept.
        """
        solver = z3.Tactic("qfbv").solver()
        solver.set("timeout", 600_000)
        solver.add(*self.conditions, *more)
        outcome = solver.check()
        return outcome, solver.model() if outcome == z3.sat else "no result in time"

    def require(self, condition, what):
        """Adds an obligation; a violation unless it holds on this path."""
        self.sites.add((*self.instruction, what))
        if self.made < len(self.decisions):
            # Shown by the path whose decisions these are.
            return
        if condition is True or (
            not isinstance(condition, bool) and z3.is_true(z3.simplify(condition))
        ):
            return
        if condition is False:
            raise Violation(self.told(what))
        outcome, values = self.check(z3.Not(condition))
        if outcome != z3.unsat:
            raise Violation(self.told(f"{what}: {values}"))

    def told(self, what):
        function, line = self.instruction
        return f"{function}:{line}: {what}"

    def is_possible(self, condition):
        outcome, _ = self.check(condition)
        assert outcome != z3.unknown, self.told("no result in time")
        return outcome == z3.sat

    def decide(self, condition):
        """The direction of a branch on this path."""
        condition = z3.simplify(condition)
        if z3.is_true(condition) or z3.is_false(condition):
            return z3.is_true(condition)
        if self.made < len(self.decisions):
            way = self.decisions[self.made]
        else:
            way = self.is_possible(condition)
            if way and self.is_possible(z3.Not(condition)):
                self.pending.append(self.decisions + [False])
            self.decisions.append(way)
        self.made += 1
        self.assume(condition if way else z3.Not(condition))
        return way

    def concrete(self, value, bits):
        """A number that the path fixes, for example of an index."""
        while not isinstance(value, int):
            if self.made < len(self.decisions):
                # A guess is stored as the number.
                guess = self.decisions[self.made]
                self.made += 1
                if guess[1]:
                    self.assume(value == guess[0])
                    return guess[0]
                self.assume(value != guess[0])
                continue
            outcome, values = self.check()
            assert outcome == z3.sat
            guess = values.eval(value, model_completion=True).as_long()
            if self.is_possible(value != guess):
                self.pending.append(self.decisions + [(guess, False)])
            self.decisions.append((guess, True))
        return value

    # Functions.

    def call(self, function, arguments):
        registers = {name: value for (_, name), value in zip(function.parameters, arguments)}
        path = demangled(function.name)
        block, previous = next(iter(function.blocks)), None
        while True:
            for text in function.blocks[block]:
                outcome = self.execute(function, path, registers, text, previous)
                if outcome is None:
                    continue
                kind, value = outcome
                if kind == "return":
                    return value
                block, previous = value, block
                break

    def execute(self, function, path, registers, text, previous):
        prepared = self.program.prepared.get((function.name, text))
        if prepared is None:
            prepared = prepare(self.program, function, text)
            self.program.prepared[function.name, text] = prepared
        name, opcode, body, self.instruction = prepared
        frame = Frame(self, function, path, registers, previous)
        value = getattr(frame, "do_" + opcode)(body)
        if name is None:
            return value
        if not isinstance(value, (int, Pointer, tuple, type(None))):
            value = known(z3.simplify(value))
        registers[name] = value
        bound = self.watched.get((path, name))
        if bound is not None:
            registers[name] = bound(self, value)
        return None


def prepare(program, function, text):
    """Register, operation, its operands, and the line of an instruction."""
    line = program.line(function, text)
    name = None
    if re.match(r'^%("[^"]+"|[\w.$-]+) = ', text):
        name, text = text.split(" = ", 1)
    opcode = text.split()[0]
    body = re.sub(r"(, ![\w.]+ !\d+)+$", "", text)
    body = re.sub(r" #\d+$", "", body)
    return name, opcode, body[len(opcode) :].strip(), line


def explore(make, run):
    """Runs every path. `make` gives a machine for the decisions, `run` executes it."""
    paths, sites, work = 0, set(), [[]]
    while work:
        machine = make(work.pop())
        run(machine)
        work += machine.pending
        paths += 1
        sites |= machine.sites
    return paths, sites
