"""Adds a run to the history of fuzzing and prints the sums of all runs.

history.py COMMIT RESULT [RESULT ...], where each result is one of measured.py. Fails if a violation
ended a process of this run.
"""

import csv
import datetime
import json
import sys
from pathlib import Path

HISTORY = Path(__file__).with_name("history.csv")
COLUMNS = ["date", "commit", "sequences", "seconds", "violations"]


def extent(runs):
    """Sequences and processor time of these runs."""
    sequences = sum(int(run["sequences"]) for run in runs)
    hours = sum(int(run["seconds"]) for run in runs) / 3600
    return f"{sequences:,} sequences in {hours:.1f} hours of processor time"


def main():
    commit, *results = sys.argv[1:]
    results = [json.loads(Path(result).read_text()) for result in results]
    sums = {key: sum(result[key] for result in results) for key in COLUMNS[2:]}
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    with HISTORY.open("a", newline="") as file:
        csv.writer(file, lineterminator="\n").writerow([today, commit, *sums.values()])
    with HISTORY.open(newline="") as file:
        runs = list(csv.DictReader(file))
    since = max((n + 1 for n, run in enumerate(runs) if int(run["violations"])), default=0)
    ended = sum(int(run["violations"]) for run in runs)
    print(f"{extent(runs)}; a violation ended {ended} processes; since then {extent(runs[since:])}")
    return 1 if sums["violations"] else 0


sys.exit(main())
