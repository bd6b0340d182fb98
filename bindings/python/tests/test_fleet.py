"""Identification of many recordings."""

import numpy as np
import pytest
from distributed import Client

import smart_actuator as sa
from smart_actuator import fleet

POLES = np.linspace(20.0, 30.0, 11)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Recordings of servos with these poles, of one with a far larger pole, and one without samples."""
    folder = tmp_path_factory.mktemp("runs")
    for index, pole in enumerate([*POLES, 200.0]):
        trace = sa.simulate("black-box-1", input="3-2-1-1", every=80, pole_rad_s=pole)
        trace.to_pandas().to_csv(folder / f"{index:02d}.csv", index=False)
    (folder / "none.csv").write_text("time_s,command_deg,angle_deg\n")
    return sorted(folder.glob("*.csv"))


def test_a_row_a_recording_on_processes_and_an_interrupted_campaign_goes_on(runs, tmp_path):
    first = fleet.identify(runs[:3], out=tmp_path / "fits", processes=2, starts=2)
    before = {file: file.stat().st_mtime_ns for file in (tmp_path / "fits").iterdir()}
    table = fleet.identify(runs, out=tmp_path / "fits", processes=2, starts=2)
    assert (len(first), len(table)) == (3, len(runs))
    assert all(file.stat().st_mtime_ns == time for file, time in before.items()), "fitted again"
    rows = {row["path"]: row for row in table.to_pylist()}
    for path, pole in zip(map(str, runs), POLES):
        # The traces have no noise.
        assert rows[path]["pole_rad_s"] == pytest.approx(pole, rel=1e-4)
    assert "expected" in rows[str(runs[-1])]["error"]
    assert fleet.outliers(table)["pole_rad_s"] == [str(runs[-2])]
    fleet.page(table, tmp_path / "fleet.html")
    text = (tmp_path / "fleet.html").read_text()
    assert "13 recordings, 1 without a fit" in text and "11.csv" in text


def test_a_dask_cluster_finds_the_same(runs, tmp_path):
    with Client(n_workers=1, threads_per_worker=1, dashboard_address=None) as client:
        on_cluster = fleet.identify(runs[:3], out=tmp_path / "a", client=client, starts=2)
    here = fleet.identify(runs[:3], out=tmp_path / "b", processes=1, starts=2)
    key = "pole_rad_s"
    assert sorted(on_cluster[key].to_pylist()) == sorted(here[key].to_pylist())
