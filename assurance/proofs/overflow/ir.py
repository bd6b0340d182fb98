"""Functions, constants, structures and source lines of LLVM's intermediate code of rustc."""

import re


class Function:
    """A function: its parameters (type, name) and the instructions of each block."""

    def __init__(self, name, header, body):
        self.name = name
        self.parameters = parameters(header)
        self.body = body
        self._blocks = None

    @property
    def blocks(self):
        if self._blocks is None:
            self._blocks, label, lines = {}, None, iter(self.body.split("\n"))
            for line in lines:
                start = re.match(r'^("?[\w.$-]+"?):', line)
                if start:
                    label = start.group(1)
                    self._blocks[label] = []
                elif line.startswith("  ") and not line.lstrip().startswith(("#dbg", ";")):
                    text = line.strip()
                    if text.startswith("switch") and text.endswith("["):
                        while not text.split(", !dbg")[0].endswith("]"):
                            text += " " + next(lines).strip()
                    self._blocks[label].append(text)
        return self._blocks


def parameters(header):
    """Types and names of the parameters in `define ... @name(...)`."""
    start = header.index("(", header.index("@"))
    depth, end = 0, start
    for end in range(start, len(header)):
        depth += {"(": 1, ")": -1}.get(header[end], 0)
        if depth == 0:
            break
    found = []
    for part in split(header[start + 1 : end]):
        found.append((type_of(part)[0], part.split()[-1]))
    return found


def split(text):
    """Parts between commas outside brackets and quotes."""
    parts, depth, quoted, last = [], 0, False, 0
    for i, c in enumerate(text):
        if c == '"':
            quoted = not quoted
        elif quoted:
            continue
        elif c in "([{<":
            depth += 1
        elif c in ")]}>":
            depth -= 1
        elif c == "," and depth == 0:
            parts.append(text[last:i].strip())
            last = i + 1
    rest = text[last:].strip()
    return parts + [rest] if rest else parts


def type_of(text):
    """The type at the start of a text, and what follows it."""
    text = text.strip()
    if text[0] in "[{<":
        depth = 0
        for i, c in enumerate(text):
            depth += {"[": 1, "{": 1, "<": 1, "]": -1, "}": -1, ">": -1}.get(c, 0)
            if depth == 0:
                return text[: i + 1], text[i + 1 :].strip()
    word = text.split()[0].rstrip(",")
    return word, text[len(word) :].strip()


def width(kind):
    """Bits of a scalar type."""
    if kind == "ptr":
        return 32
    if kind == "float":
        return 32
    if kind == "double":
        return 64
    return int(kind[1:])


def size(kind):
    """Bytes of a type."""
    array = re.match(r"^\[(\d+) x (.*)\]$", kind)
    if array:
        return int(array.group(1)) * size(array.group(2))
    if kind.startswith("{"):
        # Scalars, each aligned to its size.
        end = 0
        for field in split(kind[1:-1]):
            end = -(-end // size(field)) * size(field) + size(field)
        return end
    return (width(kind) + 7) // 8


def demangled(name):
    """The path of a function of the legacy mangling, without its hash and without the parameters of
    its type; others as they are."""
    if not name.startswith("_ZN"):
        return name
    rest, parts = name[3:], []
    while rest and rest[0].isdigit():
        digits = re.match(r"\d+", rest).group()
        parts.append(rest[len(digits) : len(digits) + int(digits)])
        rest = rest[len(digits) + int(digits) :]
    return "::".join(part.removesuffix("$LT$_$GT$") for part in parts[:-1])


class Program:
    """All functions and constants of some files."""

    def __init__(self, files):
        self.functions, self.constants, self.of_path, self.metadata = {}, {}, {}, []
        self.prepared = {}
        for file in files:
            text = open(file).read()
            index = len(self.metadata)
            self.metadata.append(dict(re.findall(r"^(!\d+) = (.*)$", text, re.M)))
            for match in re.finditer(r"^define (.*?) \{\n(.*?)^\}", text, re.M | re.S):
                name = re.search(r'@("[^"]+"|[\w.$]+)\(', match.group(1)).group(1).strip('"')
                function = Function(name, match.group(1), match.group(2))
                function.file = index
                if name not in self.functions:
                    self.functions[name] = function
                    self.of_path.setdefault(demangled(name), []).append(function)
            for match in re.finditer(r"^@([\w.$]+) = .*?constant (.*), align \d+$", text, re.M):
                self.constants[index, match.group(1)] = match.group(2)

    def function(self, path):
        """The only function of a path."""
        found = self.of_path.get(path, [])
        assert len(found) == 1, f"{len(found)} functions are called {path}"
        return found[0]

    def line(self, function, instruction):
        """File and line of an instruction."""
        match = re.search(r"!dbg (!\d+)", instruction)
        data = self.metadata[function.file]
        place = data.get(match.group(1), "") if match else ""
        number = re.search(r"line: (\d+)", place)
        scope = re.search(r"scope: (!\d+)", place)
        while scope:
            entry = data[scope.group(1)]
            file = re.search(r"file: (!\d+)", entry)
            if file:
                name = re.search(r'filename: "([^"]*)"', data[file.group(1)]).group(1)
                name = re.sub(r".*/(?=model-core/)|.*/registry/src/[^/]*/|.*/library/", "", name)
                return name.split("/@/")[0], int(number.group(1)) if number else 0
            scope = re.search(r"scope: (!\d+)", entry)
        return demangled(function.name), 0

    def members(self, structure):
        """Byte offset and size of each field of a structure, nested ones as a path."""
        for data in self.metadata:
            for entry in data.values():
                if f'name: "{structure}"' in entry and "DW_TAG_structure_type" in entry:
                    return dict(walk(data, entry, 0, ""))
        raise KeyError(structure)


def walk(data, entry, base, path):
    elements = re.search(r"elements: (!\d+)", entry)
    listed = data.get(elements.group(1), "") if elements else ""
    for element in re.findall(r"!\d+", listed):
        member = data[element]
        if "DW_TAG_member" not in member:
            continue
        name = re.search(r'name: "([^"]*)"', member).group(1)
        at = base + int((re.search(r"offset: (\d+)", member) or [0, 0])[1]) // 8
        kind = data[re.search(r"baseType: (!\d+)", member).group(1)]
        inner = f"{path}.{name}" if path else name
        bits = int((re.search(r"size: (\d+)", kind) or [0, 0])[1])
        yield inner, (at, bits // 8)
        yield from walk(data, kind, at, inner)


def constant(text):
    """The bytes of a constant; `None` for each that is an address."""
    text = text.strip()
    kind, rest = type_of(text)
    if rest.startswith('c"'):
        raw, out, i = rest[2 : rest.rindex('"')], [], 0
        while i < len(raw):
            if raw[i : i + 2] == "\\\\":
                out.append(0x5C)
                i += 2
            elif raw[i] == "\\":
                out.append(int(raw[i + 1 : i + 3], 16))
                i += 3
            else:
                out.append(ord(raw[i]))
                i += 1
        return out
    if rest.startswith(("<{", "{", "[")):
        inner = rest.strip("<>{}[] ") if not rest.startswith("<{") else rest[2:-2]
        out = []
        for part in split(inner):
            out += constant(part)
        return out
    if rest.startswith("zeroinitializer"):
        return [0] * size(kind)
    if rest.startswith("undef"):
        return [0] * size(kind)
    if kind.startswith("i") and re.match(r"-?\d+", rest):
        value = int(rest.split()[0].rstrip(","))
        return list((value % (1 << width(kind))).to_bytes(size(kind), "little"))
    return [None] * (size(kind) if kind == "ptr" else 4)
