"""A campaign on two worker processes of Dask, compared with the serial run.

    python dask_campaign.py [RUNS]
"""

import sys
import time

import numpy as np
from dask.distributed import Client, LocalCluster

import smart_actuator as sa

WORKERS = 2
CHUNKS = 16


def campaign(parameters):
    """One share of the campaign. One thread: there is a worker on each core."""
    return sa.monte_carlo(
        parameters, preset="as-measured", input="variable-step", duration=60.0, threads=1
    )


def main():
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 4000
    random = np.random.default_rng(1)
    gain = random.normal(3.0, 0.1, runs)
    delay_s = random.uniform(0.0, 0.03, runs)
    parameters = {"motor_gain_up": gain, "motor_gain_down": gain, "delay_s": delay_s}

    start = time.perf_counter()
    serial = campaign(parameters)
    serial_s = time.perf_counter() - start

    with LocalCluster(
        n_workers=WORKERS, threads_per_worker=1, dashboard_address=None
    ) as cluster, Client(cluster) as client:
        client.wait_for_workers(WORKERS)
        client.run(campaign, {"motor_gain_up": gain[:1]})
        start = time.perf_counter()
        names = list(parameters)
        split = zip(*(np.array_split(parameters[name], CHUNKS) for name in names))
        shares = client.map(campaign, [dict(zip(names, share)) for share in split])
        distributed = np.concatenate(client.gather(shares))
        distributed_s = time.perf_counter() - start

    assert np.array_equal(serial, distributed), "the results differ"
    print(f"{runs} runs: the results are equal")
    print(
        f"serial {serial_s:.2f} s, {WORKERS} workers {distributed_s:.2f} s, "
        f"speed-up {serial_s / distributed_s:.2f}"
    )


if __name__ == "__main__":
    main()
