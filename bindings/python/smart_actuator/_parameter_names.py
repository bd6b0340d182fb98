"""Writes ``_parameters.py``, the names of all parameters for type checkers.

Run it as ``python -m smart_actuator._parameter_names > smart_actuator/_parameters.py`` after a
change of a parameter; a test compares the two.
"""

from __future__ import annotations

from . import _native

#: Every model with every plant.
_CHOICES = [
    ("board", None),
    ("board", "bench"),
    ("grey-box", None),
    ("black-box-1", None),
    ("black-box-2", None),
]

_HEAD = '''"""The names of all parameters; written by ``smart_actuator._parameter_names``."""

from typing import TypedDict


class ModelParameters(TypedDict, total=False):
    """Every parameter of every model, by name and by symbol.

    A parameter that the model does not have raises a ``KeyError``.
    """

'''


def source() -> str:
    """The text of the module."""
    names: dict[str, None] = {}
    for model, plant in _CHOICES:
        for row in _native.parameters(model, plant):
            names.update({name: None for name in (row["name"], row["symbol"]) if name})
    return _HEAD + "".join(f"    {name}: float\n" for name in names)


if __name__ == "__main__":
    print(source(), end="")
