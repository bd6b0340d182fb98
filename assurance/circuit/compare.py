"""Holds the winding's current of the board plant to a circuit of switches and diodes in ngspice.

The circuit adds what the plant folds into its parameters: the resistance of each switch (the
winding's is less by two of them), the dead time as an interval in which neither switch of a leg
conducts, and the amplifier as a low-pass of 400 kHz, read at the end of the converter's sampling
phase.

    cargo run --example winding_current -p model-core | python3 compare.py
"""

import csv
import pathlib
import subprocess
import sys
import tempfile

SUPPLY_V, WINDING_OHM, WINDING_H = 6.0, 7.7, 1e-3
SWITCH_OHM, DIODE_V = 0.05, 0.7
PERIOD_S, PERIODS, CONTROL_PERIODS = 1e-3, 4, 3
DEAD_S, OPENS_S, SCAN_S = 1e-6, 0.8e-3, 0.975e-3
# From the compare event to the end of the sampling phase: 50 + 448 cycles of 168 MHz.
APERTURE_S = 498 / 168e6
# 2 mA where 2 % of the current are less: half a code of the converter is 0.8 mA, and the edges of
# the circuit take 0.1 us.
ABSOLUTE_A, RELATIVE = 2e-3, 0.02


def gate(level):
    """A piecewise linear source from a function of the period's number and the time in it."""
    edge = 1e-7
    points = [(0.0, level(0, edge))]
    for period in range(PERIODS * CONTROL_PERIODS):
        for at in level.instants:
            now = level(period, at + edge)
            if now != points[-1][1]:
                start = period * PERIOD_S + at
                points += [(start + edge / 2, points[-1][1]), (start + edge, now)]
    return " ".join(f"{at:.9f} {value}" for at, value in points)


class Gate:
    def __init__(self, instants, closed):
        self.instants, self.closed = sorted(set(instants)), closed

    def __call__(self, period, at):
        is_open = period % PERIODS == PERIODS - 1 and at >= OPENS_S
        return 0 if is_open else int(self.closed(at))


def simulate(compare, back_emf_v):
    """Mean, sampled and scanned current in the last control period, A, for a positive compare."""
    on = compare / 56e6
    is_full = compare == 56_000
    instants = [0.0, DEAD_S, on, on + DEAD_S, OPENS_S]
    instants = [at for at in instants if at < PERIOD_S]
    # The dead time shortens the high side at its start; the low side waits as long at its end.
    high = Gate(instants, lambda at: is_full or DEAD_S <= at < on)
    low = Gate(instants, lambda at: not is_full and at >= on + DEAD_S)
    other = Gate(instants, lambda at: True)
    end = PERIODS * CONTROL_PERIODS * PERIOD_S
    last = end - PERIOD_S
    sample = last + max(on / 2, 10e-6) + APERTURE_S
    sample = min(sample, last + OPENS_S - 10e-6 + APERTURE_S)
    netlist = f"""bridge
Vm vm 0 {SUPPLY_V}
Vah ah 0 PWL({gate(high)})
Val al 0 PWL({gate(low)})
Vbl bl 0 PWL({gate(other)})
S1 vm a ah 0 sw
S2 a 0 al 0 sw
S4 b 0 bl 0 sw
D1 a vm d
D2 0 a d
D3 b vm d
D4 0 b d
R1 a m {WINDING_OHM - 2 * SWITCH_OHM}
L1 m x {WINDING_H} ic=0
Ve x y {back_emf_v}
Vi y b 0
H1 sense 0 Vi 1
R2 sense amplifier 1
C2 amplifier 0 0.398u
.model sw SW(Ron={SWITCH_OHM} Roff=100meg Vt=0.5 Vh=0.1)
.model d D(Is=1e-14 Rs=1m)
.tran 0.2u {end} 0 0.5u uic
.control
run
meas tran sampled find v(amplifier) at={sample}
meas tran mean avg i(Vi) from={end - PERIODS * PERIOD_S} to={end}
meas tran scan find i(Vi) at={last + SCAN_S}
.endc
.end
"""
    with tempfile.NamedTemporaryFile("w", suffix=".cir", delete=False) as file:
        file.write(netlist)
    text = subprocess.run(["ngspice", "-b", file.name], capture_output=True, text=True).stdout
    pathlib.Path(file.name).unlink()
    found = {}
    for line in text.splitlines():
        name, separator, rest = line.partition("=")
        if separator and name.strip() in ("sampled", "mean", "scan"):
            found[name.strip()] = float(rest.split()[0])
    if len(found) != 3:
        sys.exit(f"ngspice printed no measurements:\n{text}")
    return found


def main():
    rows = list(csv.DictReader(sys.stdin))
    if not rows:
        sys.exit("standard input has no rows; expected the output of the example winding_current")
    wrong, worst = 0, 0.0
    for row in rows:
        compare, back_emf_v = int(row["compare"]), float(row["back_emf_v"])
        # The circuit switches leg A: a negative compare is the same with all signs reversed.
        sign = 1 if compare > 0 else -1
        circuit = simulate(abs(compare), sign * back_emf_v)
        for name, value in circuit.items():
            plant = sign * float(row[f"{name}_a"])
            error = abs(plant - value)
            bound = max(ABSOLUTE_A, RELATIVE * abs(value))
            worst = max(worst, error / bound)
            if error > bound:
                wrong += 1
                print(f"{compare} counts, {back_emf_v:.3f} V, {name}: plant {1e3 * plant:.1f} mA, circuit {1e3 * value:.1f} mA")
    print(f"{len(rows)} operating points, {wrong} currents off; the largest difference is {100 * worst:.0f} % of its bound")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
