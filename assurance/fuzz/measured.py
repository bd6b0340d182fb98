"""Runs a fuzzer and writes what it did: measured.py RESULT PROGRAM [ARGUMENT ...].

An interrupt ends the fuzzer alone, so that its results are kept.
"""

import json
import re
import resource
import signal
import subprocess
import sys


def main():
    result, *command = sys.argv[1:]
    signal.signal(signal.SIGINT, lambda *_: None)
    run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, errors="replace")
    sequences = 0
    has_violated = False
    for line in run.stderr:
        sys.stderr.write(line)
        if match := re.match(r"stat::number_of_executed_units: (\d+)", line):
            sequences = int(match[1])
        has_violated |= "ERROR: libFuzzer" in line
    run.wait()
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = round(usage.ru_utime + usage.ru_stime)
    found = {"sequences": sequences, "seconds": seconds, "violations": int(has_violated)}
    with open(result, "w", encoding="utf-8") as file:
        json.dump(found, file)


main()
