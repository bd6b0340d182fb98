#!/usr/bin/env python3
"""python-canopen imports the EDS: it contains everything that the source declares, and a round trip changes nothing.

    eds.py firmware/object-dictionary.csv docs/smart-actuator.eds
"""
import csv
import io
import sys
import unittest

import canopen
from canopen import objectdictionary as od

SOURCE, SHEET = sys.argv[1:3]
TYPES = {
    "u8": od.UNSIGNED8, "u16": od.UNSIGNED16, "u32": od.UNSIGNED32, "u64": od.UNSIGNED64,
    "i8": od.INTEGER8, "i16": od.INTEGER16, "i32": od.INTEGER32, "i64": od.INTEGER64,
    "f32": od.REAL32, "str": od.VISIBLE_STRING, "dom": od.DOMAIN,
}
NODE_ID = 5


def variables(objects):
    """All entries by index and sub-index."""
    for index, thing in objects.items():
        if isinstance(thing, od.ODVariable):
            yield (index, 0), thing
        else:
            for sub, variable in thing.items():
                yield (index, sub), variable


def value(text, kind):
    if not text or kind in ("f32", "dom"):
        return None
    if kind == "str":
        return text
    node_id, _, number = text.rpartition("$NODEID+")
    return int(number, 0) + (NODE_ID if "$NODEID" in text else 0)


class Sheet(unittest.TestCase):
    def setUp(self):
        self.objects = canopen.import_od(SHEET, NODE_ID)

    def test_every_source_entry_is_in_the_eds(self):
        # Entries below 1000h are the dummy entries of RPDO mappings.
        found = {key: entry for key, entry in variables(self.objects) if key[0] >= 0x1000}
        with open(SOURCE, newline="", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(found), len(rows))
        declared = {}
        for row in rows:
            # The first line of a value declares it; further addresses leave these columns empty.
            first = declared.setdefault(row["value"] or id(row), row)
            with self.subTest(row["index"] + ":" + row["sub"]):
                entry = found[int(row["index"], 16), int(row["sub"] or 0)]
                self.assertEqual(entry.data_type, TYPES[row["type"]])
                self.assertEqual(entry.access_type, row["access"])
                self.assertEqual(entry.name, row["object"] if row["sub"] == "" else row["entry"])
                self.assertEqual(entry.pdo_mappable, row["pdo"] == "x")
                self.assertEqual(entry.default, value(first["default"], row["type"]))
                if row["type"] != "f32":
                    limits = value(first["min"], row["type"]), value(first["max"], row["type"])
                    self.assertEqual((entry.min, entry.max), limits)

    def test_a_round_trip_changes_nothing(self):
        out = io.StringIO()
        canopen.export_od(self.objects, out, "eds")
        out.seek(0)
        out.name = "again.eds"
        again = dict(variables(canopen.import_od(out, NODE_ID)))
        first = dict(variables(self.objects))
        self.assertEqual(first.keys(), again.keys())
        for key, entry in first.items():
            for name in ("name", "data_type", "access_type", "default", "min", "max", "pdo_mappable"):
                self.assertEqual(getattr(entry, name), getattr(again[key], name), (key, name))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
