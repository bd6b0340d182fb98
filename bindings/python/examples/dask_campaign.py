"""A campaign on two worker processes of Dask, compared with the serial run.

    python dask_campaign.py [RUNS]
"""

import sys
import time
from typing import Any

import numpy as np
from dask.distributed import Client, LocalCluster
from numpy.typing import NDArray

import smart_actuator as sa

WORKERS = 2
CHUNKS = 16


def campaign(parameters: dict[str, NDArray[np.float64]]) -> NDArray[Any]:
    """One share of the campaign. One thread: there is a worker on each core."""
    return sa.monte_carlo(
        parameters, preset="as-measured", input="variable-step", duration=60.0, threads=1
    )


def cpu_s(client: Client) -> float:
    """The processor time that the workers have used, s."""
    return float(sum(client.run(time.process_time).values()))


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 4000
    random = np.random.default_rng(1)
    gain = random.normal(3.0, 0.1, runs)
    delay_s = random.uniform(0.0, 0.03, runs)
    parameters = {"motor_gain_up": gain, "motor_gain_down": gain, "delay_s": delay_s}

    start, start_cpu = time.perf_counter(), time.process_time()
    serial = campaign(parameters)
    serial_s, serial_cpu_s = time.perf_counter() - start, time.process_time() - start_cpu

    with LocalCluster(
        n_workers=WORKERS, threads_per_worker=1, dashboard_address=None
    ) as cluster, Client(cluster) as client:
        client.wait_for_workers(WORKERS)
        client.run(campaign, {"motor_gain_up": gain[:1]})
        start, start_cpu = time.perf_counter(), cpu_s(client)
        names = list(parameters)
        split = zip(*(np.array_split(parameters[name], CHUNKS) for name in names))
        shares = client.map(campaign, [dict(zip(names, share)) for share in split])
        distributed = np.concatenate(client.gather(shares))
        distributed_s, distributed_cpu_s = time.perf_counter() - start, cpu_s(client) - start_cpu

    assert np.array_equal(serial, distributed), "the results differ"
    print(f"{runs} runs: the results are equal")
    print(
        f"serial {serial_s:.2f} s, {WORKERS} workers {distributed_s:.2f} s, "
        f"speed-up {serial_s / distributed_s:.2f}"
    )
    # The cost of the distribution itself, independent of other load.
    print(f"processor time: serial {serial_cpu_s:.2f} s, workers {distributed_cpu_s:.2f} s")


if __name__ == "__main__":
    main()
