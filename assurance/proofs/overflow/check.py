"""Runs all proofs of the control step, and those of planted defects, which have to fail.

Usage: check.py WORKSPACE TRACE FILES... ; TRACE is the output of the program `trace`, the
files are those that build.sh lists. With ALL=1 in the environment all proofs run; otherwise those
that take seconds, and of the parameters one of each kind is read, as the others execute the same
code with the same widths.
"""

import concurrent.futures
import os
import re
import sys
import time

from control import Control
from ir import Program
from machine import Violation
from prove import Proof, comments_stand, functions, ranges_of
from replay import replay

RATE_HZ = 250

# Planted defects: what is planted, how, and the proof that has to fail.
PLANTED = [
    (
        "an integrator that is said to stay within 2^27",
        {"integrator_end": 2**27 << 32},
        None,
        "angle",
    ),
    (
        "a rate that is said to stay within 44,000 deg/s",
        {"rate_end": 44_000 << 32},
        None,
        "observe",
    ),
    ("a proportional gain of up to 10^6", {"range": ("proportional_gain", 1e6)}, None, "angle"),
    (
        "the integrator's limit is 2^31",
        {},
        (
            "rate_loop::RateLoopState::regulate",
            r"(limit_whole\S+\(ptr align 8 %self, i32) 268435456",
            r"\1 2147483647",
        ),
        "angle",
    ),
    (
        "the modulator takes half of what it sends off its remainder",
        {},
        ("pwm_timer::Modulator::next", r"(shl i64 %\S+), 32", r"\1, 31"),
        "compare",
    ),
]

_loaded = None


def setup(files, ranges):
    global _loaded
    _loaded = Program(files), ranges


def one(name, changes=None, edit=None):
    """Executes one proof; its obligations and seconds, or the violation."""
    program, ranges = _loaded
    start = time.monotonic()
    changes = dict(changes or {})
    if "range" in changes:
        parameter, greatest = changes.pop("range")
        ranges = {**ranges, parameter: (ranges[parameter][0], greatest)}
    undo = []
    if edit:
        path, pattern, replacement = edit
        function = next(f[0] for p, f in program.of_path.items() if p.endswith(path))
        undo.append((function, function.body))
        body = re.sub(pattern, replacement, function.body)
        assert body != function.body, f"{path} has nothing of what the defect changes"
        function.body, function._blocks = body, None
        program.prepared.clear()
    control = Control(program, ranges, RATE_HZ)
    for attribute, value in changes.items():
        setattr(control, attribute, value)
    try:
        proof = Proof(program, control)
        proof.function(*functions(proof)[name])
        return name, proof.paths, proof.sites, time.monotonic() - start, None
    except Violation as violation:
        return name, 0, set(), time.monotonic() - start, str(violation)
    finally:
        for function, body in undo:
            function.body, function._blocks = body, None
            program.prepared.clear()


# Proofs that take minutes: only with ALL=1.
LONG = {"angle", "decelerate", "rate"}

# Parameters of whose kind others are: reading them is proved with ALL=1.
ALIKE = {
    "proportional_gain",
    "anti_windup_gain",
    "feed_forward_gain",
    "rate_filter",
    "position_max_deg",
    "rate_command_limit_down_deg_s",
    "duty_limit_pct",
}


def main(workspace, trace, *files):
    comments_stand(workspace)
    lines = open(trace).read().splitlines()
    ranges = ranges_of(lines)
    program = Program(files)
    operations = [line for line in lines if "->" in line]
    print(f"{replay(program, operations)} results of {len(operations)} operations are native")
    names = list(functions(Proof(program, Control(program, ranges, RATE_HZ))))
    if not os.environ.get("ALL"):
        alike = {f"get {parameter}" for parameter in ALIKE}
        names = [name for name in names if name not in LONG | alike]
    # The longest first.
    names.sort(key=lambda name: not name.startswith(("set", "get", "retune")))
    failed, sites, paths = [], set(), 0
    with concurrent.futures.ProcessPoolExecutor(
        2, initializer=setup, initargs=(files, ranges)
    ) as pool:
        proofs = [pool.submit(one, name) for name in names]
        defects = [
            (what, pool.submit(one, name, changes, edit)) for what, changes, edit, name in PLANTED
        ]
        for future in proofs:
            name, count, found, seconds, violation = future.result()
            print(
                f"{name:32} {count:4} paths {len(found):3} obligations {seconds:6.1f} s",
                flush=True,
            )
            sites |= found
            paths += count
            if violation:
                failed.append(f"{name}: {violation}")
        for what, future in defects:
            violation = future.result()[4]
            print(f"planted: {what}: {'found' if violation else 'NOT FOUND'}", flush=True)
            if not violation:
                failed.append(f"planted and not found: {what}")
    print(f"{len(sites)} obligations on {paths} paths")
    if failed:
        sys.exit("\n".join(failed))


if __name__ == "__main__":
    main(*sys.argv[1:])
