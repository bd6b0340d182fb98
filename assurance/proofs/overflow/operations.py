"""The operations of LLVM's intermediate code, on known and unknown numbers."""

import re
import struct

import z3

from ir import constant, demangled, size, split, type_of, width
from values import Memory, Pointer, known, part, signed, term

PANIC = re.compile(r"panicking|unwrap_failed|expect_failed|llvm\.trap")
SATURATING = re.compile(r"@llvm\.([su])(add|sub)\.sat\.i(\d+)")
CHECKED = re.compile(r"@llvm\.([su])(add|sub|mul)\.with\.overflow\.i(\d+)")


class Frame:
    """The operations of one function's execution."""

    def __init__(self, machine, function, path, registers, previous):
        self.machine, self.function, self.path = machine, function, path
        self.registers, self.previous = registers, previous

    def value(self, kind, text):
        text = text.strip()
        if text.startswith("%"):
            return self.registers[text]
        if text.startswith("@"):
            return self.address(text[1:])
        if text in ("true", "false"):
            return int(text == "true")
        if text in ("poison", "undef"):
            if kind.startswith("{"):
                return tuple(0 for _ in split(kind[1:-1]))
            return self.machine.unknown("undefined", width(kind))
        if text == "null":
            return 0
        if text.startswith("{"):
            return tuple(self.value(*type_of(field)) for field in split(text[1:-1]))
        if kind == "float":
            # A constant is printed in double precision.
            number = (
                struct.unpack(">d", bytes.fromhex(text[2:]))[0]
                if text.startswith("0x")
                else float(text)
            )
            return int.from_bytes(struct.pack(">f", number), "big")
        inner = re.match(r"^inttoptr \(i32 (-?\d+) to ptr\)$", text)
        if inner:
            return int(inner.group(1))
        return int(text) % (1 << width(kind))

    def address(self, name):
        machine = self.machine
        key = (self.function.file, name.strip('"'))
        if key not in machine.globals:
            memory = Memory()
            for i, byte in enumerate(constant(machine.program.constants[key])):
                if byte is not None:
                    memory.put(i, 1, byte)
            machine.globals[key] = memory
        return Pointer(machine.globals[key])

    def operands(self, body):
        """The two operands of `op [flags] TYPE A, B`."""
        body = re.sub(r"^((nuw|nsw|exact|disjoint|samesign|fast) ?)+", "", body)
        kind, rest = type_of(body)
        a, b = split(rest)
        return kind, self.value(kind, a), self.value(kind, b)

    # Memory.

    def do_alloca(self, body):
        return Pointer(Memory())

    def do_load(self, body):
        kind, rest = split(body)[:2]
        at = self.value("ptr", type_of(rest)[1])
        value = at.target.take(at.offset, size(kind), self.machine)
        if kind == "i1" and not isinstance(value, int):
            value = z3.Extract(0, 0, value)
        return value

    def do_store(self, body):
        what, rest = split(body)[:2]
        kind, text = type_of(what)
        at = self.value("ptr", type_of(rest)[1])
        at.target.put(at.offset, size(kind), self.value(kind, text))

    def do_getelementptr(self, body):
        body = re.sub(r"^((inbounds|nuw|nusw) ?)+", "", body)
        kind, base, *indices = split(body)
        at = self.value("ptr", type_of(base)[1])
        offset = at.offset
        for i, index in enumerate(indices):
            index_kind, text = type_of(index)
            number = self.value(index_kind, text)
            number = signed(self.machine.concrete(number, width(index_kind)), width(index_kind))
            array = re.match(r"^\[(\d+) x (.*)\]$", kind)
            if i > 0:
                assert array, f"a member of {kind}"
                kind = array.group(2)
            offset += number * size(kind)
        return Pointer(at.target, offset)

    def copy(self, arguments):
        to, source, count = arguments[:3]
        count = self.machine.concrete(count, 32)
        cells = []
        for at, (n, value) in list(source.target.items()):
            low, high = max(at, source.offset), min(at + n, source.offset + count)
            if low < high:
                whole = low == at and high == at + n
                if whole:
                    cells.append((at - source.offset, n, value))
                else:
                    for i in range(low - at, high - at):
                        cells.append((at + i - source.offset, 1, part(value, i, n)))
        to.target.clear_range(to.offset, count)
        for at, n, value in cells:
            to.target.put(to.offset + at, n, value)

    # Control flow.

    def do_br(self, body):
        parts = split(body)
        if len(parts) == 1:
            return "jump", parts[0].split("%", 1)[1]
        condition = self.value("i1", type_of(parts[0])[1])
        yes, no = (p.split("%", 1)[1] for p in parts[1:])
        if not isinstance(condition, int):
            if self.panics(yes) != self.panics(no):
                # What would panic is an obligation in place of a path.
                self.machine.require(
                    condition == int(bool(self.panics(no))),
                    "no " + (self.panics(yes) or self.panics(no)),
                )
                condition = int(bool(self.panics(no)))
            else:
                condition = int(self.machine.decide(condition == 1))
        return "jump", yes if condition else no

    def panics(self, block):
        """The panic that a block is, or nothing."""
        for text in self.function.blocks[block]:
            match = re.search(r'call void @("[^"]+"|[\w.$]+)\(', text)
            if match and PANIC.search(match.group(1)):
                return re.sub(
                    r".*panic_const_|.*panicking\d*", "", demangled(match.group(1).strip('"'))
                )
        return ""

    def do_switch(self, body):
        head, table = body.split("[", 1)
        subject, default = split(head)[:2]
        kind, text = type_of(subject)
        value, bits = self.value(kind, text), width(kind)
        for number, target in re.findall(r"i\d+ (-?\d+), label %([\w.$-]+)", table):
            number = int(number) % (1 << bits)
            if isinstance(value, int):
                if value == number:
                    return "jump", target
            elif self.machine.decide(value == number):
                return "jump", target
        return "jump", default.split("%", 1)[1]

    def do_ret(self, body):
        if body == "void":
            return "return", None
        kind, text = type_of(body)
        return "return", self.value(kind, text)

    def do_unreachable(self, body):
        self.machine.require(False, "unreachable code is reached")
        return "return", None

    def do_phi(self, body):
        kind, rest = type_of(body)
        for value, block in re.findall(r"\[ (\S+), %([\w.$-]+) \]", rest):
            if block == self.previous:
                return self.value(kind, value)
        raise AssertionError(self.machine.told("no such predecessor"))

    def do_tail(self, body):
        return self.do_call(body[len("call") :].strip())

    def do_call(self, body):
        start = body.index("@")
        name = re.match(r'@("[^"]+"|[\w.$]+)', body[start:]).group(1)
        listed = body[start + len(name) + 1 :].strip()
        depth = 0
        for end, c in enumerate(listed):
            depth += {"(": 1, ")": -1}.get(c, 0)
            if depth == 0:
                break
        name = name.strip('"')
        if PANIC.search(demangled(name)):
            self.machine.require(False, "a panic is reached, " + demangled(name).split("::")[-1])
            raise AssertionError("a decision that is not possible")
        arguments = []
        for argument in split(listed[1:end]):
            kind, rest = type_of(argument)
            arguments.append(
                None if kind == "metadata" else self.value(kind, attributes_removed(rest))
            )
        if name.startswith("llvm."):
            return self.intrinsic(name, arguments)
        path = demangled(name)
        contract = self.machine.contracts.get(path)
        if contract:
            return contract(self.machine, arguments, self.path)
        if name not in self.machine.program.functions:
            if name.endswith("cold_path"):
                return None
            raise AssertionError(self.machine.told(f"{name} is not in the intermediate code"))
        before = self.machine.instruction
        value = self.machine.call(self.machine.program.functions[name], arguments)
        self.machine.instruction = before
        return value

    def intrinsic(self, name, arguments):
        if name.startswith("llvm.memcpy"):
            return self.copy(arguments)
        if name.startswith("llvm.memset"):
            to, value, count = arguments[:3]
            for i in range(self.machine.concrete(count, 32)):
                to.target.put(to.offset + i, 1, value)
            return None
        if name.startswith("llvm.is.constant"):
            return 0
        if name.startswith("llvm.expect"):
            return arguments[0]
        if name.startswith(("llvm.assume", "llvm.lifetime", "llvm.dbg")):
            return None
        a = arguments[0]
        bits = int(name.rsplit(".i", 1)[1])
        if name.startswith(("llvm.scmp", "llvm.ucmp")):
            return compared(name[5] == "s", a, arguments[1], bits, int(name.split(".i")[1]))
        checked = CHECKED.match("@" + name)
        if checked:
            return checked_operation(self.machine, *checked.groups()[:2], a, arguments[1], bits)
        saturating = SATURATING.match("@" + name)
        if saturating:
            kind, operation = saturating.groups()[:2]
            value, overflows = checked_operation(
                self.machine, kind, operation, a, arguments[1], bits
            )
            low, high = (
                (1 << bits - 1, (1 << bits - 1) - 1) if kind == "s" else (0, (1 << bits) - 1)
            )
            b = arguments[1]
            if isinstance(a, int) and isinstance(b, int):
                down = (
                    (signed(b, bits) < 0) == (operation == "add")
                    if kind == "s"
                    else operation == "sub"
                )
                return (low if down else high) if overflows else value
            if kind == "u":
                end = term(high if operation == "add" else low, bits)
            else:
                down = (term(b, bits) < 0) if operation == "add" else (term(b, bits) >= 0)
                end = z3.If(down, term(low, bits), term(high, bits))
            return z3.If(term(overflows, 1) == 1, end, term(value, bits))
        if name.startswith("llvm.ctlz"):
            if isinstance(a, int):
                return bits - a.bit_length()
            count = z3.BitVecVal(bits, bits)
            for i in range(bits):
                count = z3.If(z3.Extract(i, i, a) == 1, z3.BitVecVal(bits - 1 - i, bits), count)
            return count
        if name.startswith("llvm.cttz") and isinstance(a, int):
            return (a & -a).bit_length() - 1 if a else bits
        if name.startswith("llvm.ctpop"):
            if isinstance(a, int):
                return bin(a).count("1")
            return sum(
                (z3.ZeroExt(bits - 1, z3.Extract(i, i, a)) for i in range(bits)),
                z3.BitVecVal(0, bits),
            )
        raise AssertionError(self.machine.told(f"{name} is not known"))

    # Numbers.

    def arithmetic(self, body, exact, symbolic):
        kind, a, b = self.operands(body)
        bits = width(kind)
        if isinstance(a, int) and isinstance(b, int):
            return exact(a, b, bits) % (1 << bits)
        return symbolic(term(a, bits), term(b, bits))

    def do_add(self, body):
        return self.arithmetic(body, lambda a, b, n: a + b, lambda a, b: a + b)

    def do_sub(self, body):
        return self.arithmetic(body, lambda a, b, n: a - b, lambda a, b: a - b)

    def do_mul(self, body):
        return self.arithmetic(body, lambda a, b, n: a * b, lambda a, b: a * b)

    def do_and(self, body):
        return self.arithmetic(body, lambda a, b, n: a & b, lambda a, b: a & b)

    def do_or(self, body):
        return self.arithmetic(body, lambda a, b, n: a | b, lambda a, b: a | b)

    def do_xor(self, body):
        return self.arithmetic(body, lambda a, b, n: a ^ b, lambda a, b: a ^ b)

    def do_lshr(self, body):
        return self.arithmetic(body, lambda a, b, n: a >> b, z3.LShR)

    def do_ashr(self, body):
        return self.arithmetic(body, lambda a, b, n: signed(a, n) >> b, lambda a, b: a >> b)

    def do_shl(self, body):
        kind, a, b = self.operands(body)
        bits = width(kind)
        if isinstance(a, int) and isinstance(b, int):
            return (a << b) % (1 << bits)
        a, b = term(a, bits), term(b, bits)
        shifted = a << b
        self.keeps(z3.Or(shifted >> b == a, z3.LShR(shifted, b) == a), "a shift loses no bit")
        return shifted

    def do_sdiv(self, body):
        kind, a, b = self.operands(body)
        bits = width(kind)
        if isinstance(a, int) and isinstance(b, int):
            a, b = signed(a, bits), signed(b, bits)
            return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1) % (1 << bits)
        a, b = term(a, bits), term(b, bits)
        self.machine.require(b > 0, "a divisor is positive")
        # Towards zero by a positive divisor: between zero and the dividend.
        quotient = self.machine.unknown("quotient", bits)
        self.machine.assume(
            z3.If(
                a < 0, z3.And(quotient <= 0, quotient >= a), z3.And(quotient >= 0, quotient <= a)
            )
        )
        self.machine.assume(z3.Implies(b == 1, quotient == a))
        return quotient

    def do_udiv(self, body):
        return self.arithmetic(body, lambda a, b, n: a // b, z3.UDiv)

    def do_urem(self, body):
        return self.arithmetic(body, lambda a, b, n: a % b, z3.URem)

    def keeps(self, condition, what):
        if self.path not in self.machine.intended:
            self.machine.require(condition, what)

    def converted(self, body):
        match = re.match(r"^((?:nuw |nsw |nneg )*)(\w+) (\S+) to (\w+)$", body)
        flags, source, text, target = match.groups()
        return flags, self.value(source, text), width(source), width(target)

    def do_trunc(self, body):
        flags, value, bits, narrow = self.converted(body)
        if isinstance(value, int):
            return value % (1 << narrow)
        result = z3.Extract(narrow - 1, 0, value)
        if not flags:
            # A cast keeps the number, with a sign or without one.
            machine = self.machine
            of_signed = z3.SignExt(bits - narrow, result) == value
            of_unsigned = z3.ZeroExt(bits - narrow, result) == value
            if machine.made >= len(machine.decisions) and not machine.is_possible(
                z3.Not(of_unsigned)
            ):
                of_signed = of_unsigned
            self.keeps(of_signed, "a cast keeps the number")
        return result

    def do_zext(self, body):
        _, value, bits, wide = self.converted(body)
        return value if isinstance(value, int) else z3.ZeroExt(wide - bits, value)

    def do_sext(self, body):
        _, value, bits, wide = self.converted(body)
        return (
            signed(value, bits) % (1 << wide)
            if isinstance(value, int)
            else z3.SignExt(wide - bits, value)
        )

    def do_bitcast(self, body):
        return self.converted(body)[1]

    def do_ptrtoint(self, body):
        return self.converted(body)[1]

    def do_icmp(self, body):
        body = re.sub(r"^samesign ", "", body)
        predicate, rest = body.split(" ", 1)
        kind, a, b = self.operands(rest)
        if isinstance(a, Pointer) or isinstance(b, Pointer):
            same = isinstance(a, Pointer) and isinstance(b, Pointer)
            same = same and a.target is b.target and a.offset == b.offset
            return int(same == (predicate == "eq"))
        bits = width(kind)
        if isinstance(a, int) and isinstance(b, int):
            if predicate[0] == "s":
                a, b = signed(a, bits), signed(b, bits)
            order = {
                "eq": a == b,
                "ne": a != b,
                "gt": a > b,
                "ge": a >= b,
                "lt": a < b,
                "le": a <= b,
            }
            return int(order[predicate[-2:]])
        a, b = term(a, bits), term(b, bits)
        condition = {
            "eq": lambda: a == b,
            "ne": lambda: a != b,
            "sgt": lambda: a > b,
            "sge": lambda: a >= b,
            "slt": lambda: a < b,
            "sle": lambda: a <= b,
            "ugt": lambda: z3.UGT(a, b),
            "uge": lambda: z3.UGE(a, b),
            "ult": lambda: z3.ULT(a, b),
            "ule": lambda: z3.ULE(a, b),
        }[predicate]()
        return z3.If(condition, z3.BitVecVal(1, 1), z3.BitVecVal(0, 1))

    def do_fcmp(self, body):
        predicate, rest = body.split(" ", 1)
        kind, a, b = self.operands(rest)
        assert kind == "float"
        a, b = (z3.fpBVToFP(term(x, 32), z3.Float32()) for x in (a, b))
        condition = {
            "oeq": z3.fpEQ,
            "ole": z3.fpLEQ,
            "oge": z3.fpGEQ,
            "olt": z3.fpLT,
            "ogt": z3.fpGT,
        }[predicate](a, b)
        return z3.If(condition, z3.BitVecVal(1, 1), z3.BitVecVal(0, 1))

    def do_select(self, body):
        condition, yes, no = split(body)
        condition = self.value("i1", type_of(condition)[1])
        kind = type_of(yes)[0]
        yes, no = (self.value(kind, type_of(x)[1]) for x in (yes, no))
        if not isinstance(condition, int) and (
            isinstance(yes, Pointer) or isinstance(no, Pointer)
        ):
            condition = int(self.machine.decide(condition == 1))
        if isinstance(condition, int):
            return yes if condition else no
        bits = width(kind)
        return z3.If(condition == 1, term(yes, bits), term(no, bits))

    def do_extractvalue(self, body):
        kind, rest = type_of(body)
        text, index = split(rest)
        return self.value(kind, text)[int(index)]

    def do_insertvalue(self, body):
        aggregate, what, index = split(body)
        kind, text = type_of(aggregate)
        fields = list(self.value(kind, text))
        kind, text = type_of(what)
        fields[int(index)] = self.value(kind, text)
        return tuple(fields)


def attributes_removed(text):
    """The operand behind a parameter's attributes."""
    while True:
        shorter = re.sub(
            r"^(noundef|nonnull|zeroext|signext|noalias|readonly|captures\([^)]*\)|align \d+|"
            r"dereferenceable\(\d+\)|sret\([^)]*\)|range\([^)]*\)|inreg|writable|dead_on_unwind) ?",
            "",
            text,
        )
        if shorter == text:
            return text
        text = shorter


def compared(has_sign, a, b, bits, wide):
    """-1, 0 or 1."""
    if isinstance(a, int) and isinstance(b, int):
        a, b = (signed(v, bits) for v in (a, b)) if has_sign else (a, b)
        return ((a > b) - (a < b)) % (1 << wide)
    a, b = term(a, bits), term(b, bits)
    less = a < b if has_sign else z3.ULT(a, b)
    ends = [z3.BitVecVal(v % (1 << wide), wide) for v in (-1, 0, 1)]
    return z3.If(less, ends[0], z3.If(a == b, ends[1], ends[2]))


def checked_operation(machine, kind, operation, a, b, bits):
    """Result and overflow bit of an operation that is checked."""
    if isinstance(a, int) and isinstance(b, int):
        x, y = (signed(v, bits) for v in (a, b)) if kind == "s" else (a, b)
        exact = {"add": x + y, "sub": x - y, "mul": x * y}[operation]
        low, high = (
            (-(1 << bits - 1), (1 << bits - 1) - 1) if kind == "s" else (0, (1 << bits) - 1)
        )
        return exact % (1 << bits), int(not low <= exact <= high)
    x, y = term(a, bits), term(b, bits)
    widen = (lambda v, n: z3.SignExt(n, v)) if kind == "s" else (lambda v, n: z3.ZeroExt(n, v))
    if operation == "mul":
        if isinstance(a, int) or isinstance(b, int):
            # The least and the greatest number whose product fits: easier than a wide product.
            value, factor = (y, a) if isinstance(a, int) else (x, b)
            factor = signed(factor, bits) if kind == "s" else factor
            assert factor > 0, machine.told("a factor that is not positive")
            result = value * factor
            if kind == "s":
                low, high = -((1 << bits - 1) // factor), ((1 << bits - 1) - 1) // factor
                overflows = z3.Or(value > high, value < low)
            else:
                overflows = z3.UGT(value, ((1 << bits) - 1) // factor)
        else:
            # No control path multiplies two unknown numbers but in `product`, which has a contract.
            raise AssertionError(machine.told("a product of unknown numbers"))
    else:
        exact = widen(x, 1) + widen(y, 1) if operation == "add" else widen(x, 1) - widen(y, 1)
        result = z3.Extract(bits - 1, 0, exact)
        overflows = widen(result, 1) != exact
    overflow = known(z3.simplify(z3.If(overflows, z3.BitVecVal(1, 1), z3.BitVecVal(0, 1))))
    return known(z3.simplify(result)), overflow
