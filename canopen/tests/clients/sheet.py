"""Reads the entries of an EDS, independently of the importers under test."""
import configparser
import re
import struct
from dataclasses import dataclass

FORMATS = {
    0x02: "<b", 0x03: "<h", 0x04: "<i", 0x15: "<q", 0x05: "<B", 0x06: "<H", 0x07: "<I", 0x1B: "<Q", 0x08: "<f", 0x11: "<d",
}
DOMAIN, ARRAY, RECORD = 0x2, 0x8, 0x9


@dataclass(frozen=True)
class Entry:
    index: int
    sub: int
    # Member of an ARRAY or a RECORD.
    member: bool
    name: str
    access: str
    # Format for struct; None for strings and domains.
    format: str | None
    mappable: bool
    default: str | None
    low: int | None
    high: int | None

    def __str__(self):
        return f"{self.index:04X}h:{self.sub:02X}h {self.name}"

    @property
    def size(self):
        return struct.calcsize(self.format) if self.format else None

    @property
    def writable(self):
        return self.access not in ("ro", "const")

    def pack(self, value):
        return struct.pack(self.format, value)

    def packed_default(self, node_id):
        """Default as transmitted by SDO; None if the EDS has none."""
        if self.default is None:
            return None
        return self.pack(number(self.default, node_id)) if self.format else self.default.encode()


def number(text, node_id=0):
    """A number of the EDS, which may begin with `$NODEID+`."""
    plus, _, rest = text.rpartition("$NODEID+")
    assert not plus, text
    return int(rest, 0) + (node_id if "$NODEID" in text else 0)


def read(path):
    """All addressable entries."""
    file = configparser.ConfigParser(interpolation=None, comment_prefixes=(";",))
    file.read(path, encoding="ascii")
    entries = []
    for section in file.sections():
        address = re.fullmatch(r"([0-9A-F]{4})(?:sub([0-9A-F]+))?", section)
        keys = file[section]
        if not address or int(keys["ObjectType"], 0) in (ARRAY, RECORD):
            continue
        limit = lambda key: number(keys[key]) if key in keys else None
        entries.append(Entry(
            int(address[1], 16), int(address[2] or "0", 16), address[2] is not None, keys["ParameterName"],
            keys["AccessType"], FORMATS.get(int(keys["DataType"], 0)), keys.get("PDOMapping") == "1",
            keys.get("DefaultValue") or None, limit("LowLimit"), limit("HighLimit")))
    return entries
