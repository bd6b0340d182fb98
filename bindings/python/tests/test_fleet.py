"""Identification of many recordings."""

import json
import os
import re
import shutil

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


def test_what_has_changed_is_fitted_again(runs, tmp_path):
    file, missing = tmp_path / "run.csv", tmp_path / "later.csv"
    shutil.copy(runs[0], file)

    def fitted(**options):
        table = fleet.identify([file, missing], out=tmp_path / "fits", processes=1, **options)
        assert table["path"].to_pylist() == [str(file), str(missing)]
        return table

    first = fitted(starts=2)
    assert "No such file" in first["error"][1].as_py()
    assert fitted(starts=2, model="black-box-2")["model"][0].as_py() == "black-box-2"
    assert "pole_rad_s" not in fitted(starts=2, fix={"pole_rad_s": 33.0}).column_names
    shutil.copy(runs[10], file)
    shutil.copy(runs[5], missing)
    expected = [pytest.approx(POLES[index], rel=1e-4) for index in (10, 5)]
    files = set((tmp_path / "fits").iterdir())
    found = fitted(starts=2)
    assert (found["pole_rad_s"].to_pylist(), found["error"].null_count) == (expected, 2)
    assert len(set((tmp_path / "fits").iterdir()) - files) == 1
    assert fitted(starts=2) == found


def test_without_a_folder_the_rows_are_in_memory(runs):
    table = fleet.identify(runs[:1], processes=1, starts=2)
    assert table["pole_rad_s"].to_pylist() == [pytest.approx(POLES[0], rel=1e-4)]


def test_the_time_is_that_of_the_recording_if_it_has_one(tmp_path):
    trace = sa.simulate("black-box-1", input="3-2-1-1", every=80)
    dates = np.datetime64("2026-03-01T10:00:00") + (np.asarray(trace.time_s) * 1e6).astype("m8[us]")
    pandas = pytest.importorskip("pandas")
    columns = {"command_deg": trace.command_deg, "angle_deg": trace.angle_deg}
    dated, plain = tmp_path / "dated.csv", tmp_path / "plain.csv"
    pandas.DataFrame({"time": dates, **columns}).to_csv(dated, index=False)
    pandas.DataFrame({"time_s": trace.time_s, **columns}).to_csv(plain, index=False)
    os.utime(plain, (1e9, 1e9))
    table = fleet.identify([dated, plain], processes=1, starts=2)
    assert table["time"].to_pylist() == [dates[0].astype("M8[s]").astype(float), 1e9]
    fleet.page(table, tmp_path / "fleet.html")
    text = (tmp_path / "fleet.html").read_text()
    assert "over time" in text and "2001-09-09 01:46" in text and "2026-03-01 10:00" in text


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
    fleet.page(table, tmp_path / "fleet.html")
    text = (tmp_path / "fleet.html").read_text()
    # A distribution for each joint, and the numbers of its episodes.
    for name in names:
        assert f"<h2>{name}: pole_rad_s</h2>" in text
    assert re.search(r"<text [^>]*>0\.5</text>.*over the episodes", text)
    # The traces have no noise; the command is held from tick to tick and not from sample to sample.
    assert found == {name: pytest.approx(pole, rel=0.02) for name, pole in expected.items()}
