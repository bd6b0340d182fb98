"""Identification of many recordings."""

import json

import numpy as np
import pyarrow
import pyarrow.parquet
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


def test_each_joint_in_each_episode_of_a_data_set_is_a_recording(tmp_path):
    (tmp_path / "meta").mkdir()
    (tmp_path / "data" / "chunk-000").mkdir(parents=True)
    names = ["pan.pos", "elbow_flex.pos"]
    info = {"features": {"observation.state": {"names": names}}}
    (tmp_path / "meta" / "info.json").write_text(json.dumps(info))
    tables = []
    for episode in range(2):
        of = lambda pole: sa.simulate("black-box-1", input="3-2-1-1", every=400, pole_rad_s=pole)
        joints = [of(20.0 + episode), of(30.0 + episode)]
        pair = lambda name: [[float(a), float(b)] for a, b in zip(*(joint[name] for joint in joints))]
        count = len(joints[0].time_s)
        columns = {
            "timestamp": np.asarray(joints[0].time_s),
            "action": pair("command_deg"),
            "observation.state": pair("angle_deg"),
            "episode_index": np.full(count, episode),
        }
        tables.append(pyarrow.table(columns))
    file = tmp_path / "data" / "chunk-000" / "file-000.parquet"
    pyarrow.parquet.write_table(pyarrow.concat_tables(tables), file)
    table = fleet.identify(tmp_path, out=tmp_path / "fits", processes=1, starts=2, hold="zero")
    found = {row["path"]: row["pole_rad_s"] for row in table.to_pylist()}
    expected = {
        f"{tmp_path}: episode {episode}, {name}": pole + episode
        for episode in range(2)
        for name, pole in zip(names, (20.0, 30.0))
    }
    # The traces have no noise; the command is held from tick to tick and not from sample to sample.
    assert found == {name: pytest.approx(pole, rel=0.02) for name, pole in expected.items()}
