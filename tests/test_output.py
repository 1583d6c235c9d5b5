"""Snapshots and the series as VTK reads them, gauge tables, output folders."""

import csv
import json
import math
import shutil

import h5py
import numpy as np
import pytest
from helpers import Probe, tank
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader

import parsph
from parsph.errors import RunError, SceneError
from parsph.io import polydata, snapshots
from parsph.io.folder import output_folder
from parsph.io.snapshots import POINT_DATA
from parsph.io.tables import Table, read_table
from parsph.moments import MOMENTS
from parsph.particles import FIELDS
from parsph.scene.build import build
from parsph.scene.load import load_scene

EVERY, END = 0.004, 0.02
NAMES = ("position", *POINT_DATA)
GAUGES = [
    {"kind": "level", "x": 0.1, "every": 0.002},
    {"kind": "pressure", "point": [0.1, 0.05], "name": "middle", "every": 0.005},
    {"kind": "energy", "every": 0.003},
]


def look(simulation):
    return {name: simulation.field(name) for name in NAMES}


@pytest.fixture(scope="module", params=["float64", "float32"])
def written(request, tmp_path_factory):
    """(folder, scene, simulation, fields at each snapshot) of a short run."""
    folder = tmp_path_factory.mktemp("run")
    output = {"snapshots": {"every": EVERY, "precision": request.param}}
    scene = load_scene(tank(time={"end": END}, output=output, gauges=GAUGES))
    simulation = build(scene, folder=folder)
    probe = Probe(EVERY, look)
    simulation.observers.append(probe)
    simulation.run()
    return folder, scene, simulation, probe.seen


def read(path, step=None):
    """Read a file with VTK; return (reader, points, {point data})."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    if step is not None:
        reader.SetStep(step)
    reader.Update()
    data = reader.GetOutputDataObject(0)
    arrays = data.GetPointData()
    names = [arrays.GetArrayName(k) for k in range(arrays.GetNumberOfArrays())]
    points = vtk_to_numpy(data.GetPoints().GetData()) if data.GetNumberOfPoints() else np.zeros((0, 3))
    return reader, data, points.copy(), {name: vtk_to_numpy(arrays.GetArray(name)).copy() for name in names}


def assert_holds(points, arrays, fields, precision):
    """Compare what VTK read with the simulation's fields; vectors have a third component 0."""
    assert set(arrays) == set(POINT_DATA)
    arrays = {**arrays, "position": points}
    for name in NAMES:
        expected, found = fields[name], arrays[name]
        if expected.dtype == float:
            expected = expected.astype(precision)
        if expected.ndim == 2:
            assert (found[:, 2:] == 0).all()
            found = found[:, : expected.shape[1]]
        np.testing.assert_array_equal(found, expected, err_msg=name)


def test_vtk_reads_each_snapshot_as_it_was(written):
    folder, scene, _, seen = written
    paths = sorted((folder / "snapshots").iterdir())
    assert [path.name for path in paths] == [f"{k:05d}.vtkhdf" for k in range(6)]
    assert len(seen) == len(paths)
    for path, (_, fields) in zip(paths, seen, strict=True):
        _, data, points, arrays = read(path)
        assert data.GetNumberOfPoints() == 400 == data.GetNumberOfVerts()
        assert_holds(points, arrays, fields, scene.output.snapshots.precision)


def test_last_snapshot_is_the_end_of_the_run(written):
    folder, scene, simulation, _ = written
    _, _, points, arrays = read(sorted((folder / "snapshots").iterdir())[-1])
    assert_holds(points, arrays, look(simulation), scene.output.snapshots.precision)


def test_vtk_reads_the_series_with_true_times(written):
    folder, scene, _, seen = written
    reader, _, _, _ = read(folder / "series.vtkhdf")
    assert reader.GetNumberOfSteps() == len(seen) == 6
    keys = reader.GetOutputInformation(0)
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline

    times = [keys.Get(Pipeline.TIME_STEPS(), k) for k in range(keys.Length(Pipeline.TIME_STEPS()))]
    assert times == [time for time, _ in seen]
    for step, (_, fields) in enumerate(seen):
        _, data, points, arrays = read(folder / "series.vtkhdf", step)
        assert data.GetNumberOfVerts() == 400
        assert_holds(points, arrays, fields, scene.output.snapshots.precision)


@pytest.mark.parametrize("together", [1, 2, 3, 7])
def test_vtk_reads_a_series_in_files_of_its_own(written, tmp_path, monkeypatch, together):
    """What many snapshots need: references to references; the folder may be moved."""
    folder, scene, _, seen = written
    copy = tmp_path / "moved"
    shutil.copytree(folder, tmp_path / "first")
    monkeypatch.setattr(snapshots, "TOGETHER", together)
    found = [snapshots._read(folder, path) for path in sorted((folder / "snapshots").iterdir())]
    assert snapshots.write_series(tmp_path / "first", found[:4]) == 4 // together
    first = {path: path.read_bytes() for path in (tmp_path / "first").glob("series/*")}
    assert snapshots.write_series(tmp_path / "first", found, 4 // together) == 6 // together
    assert all(path.read_bytes() == data for path, data in first.items()), "written once"
    (tmp_path / "first").rename(copy)
    assert len(list(copy.glob("series/*.vtkhdf"))) == 6 // together
    for step, (_, fields) in enumerate(seen):
        reader, data, points, arrays = read(copy / "series.vtkhdf", step)
        assert reader.GetNumberOfSteps() == 6
        assert data.GetNumberOfVerts() == 400
        assert_holds(points, arrays, fields, scene.output.snapshots.precision)


class Clock:
    """A clock that only moves when it is told to."""

    now = 100.0

    def monotonic(self):
        return self.now


def test_the_series_takes_a_bounded_share_of_the_time(written, tmp_path, monkeypatch):
    """Writing it takes a second here, and there is a snapshot every half second; at the end it is complete."""
    _, _, simulation, _ = written
    clock, seen = Clock(), []

    def slow(folder, found, parts):
        clock.now += 1.0
        seen.append(len(found))
        return parts

    monkeypatch.setattr(snapshots, "time", clock)
    monkeypatch.setattr(snapshots, "write_series", slow)
    monkeypatch.setattr(snapshots, "write_snapshot", lambda *_: 400)
    writer = snapshots.SnapshotWriter(tmp_path, 1.0, "{}", "float32")
    begin = clock.now
    for _ in range(1000):
        writer.observe(simulation)
        clock.now += 0.5
    assert seen[0] == 1
    assert 3 <= len(seen) <= 1 + snapshots.LARGEST_SHARE * (clock.now - begin)
    writer.close()
    assert seen[-1] == 1000
    count = len(seen)
    writer.finish(simulation)
    writer.close()
    assert len(seen) == count, "nothing new"


def test_snapshots_differ_from_each_other(written):
    """Otherwise right data at each step would be no finding."""
    _, _, _, seen = written
    assert np.abs(seen[-1][1]["position"] - seen[0][1]["position"]).max() > 0


def test_no_half_written_file_is_left(written):
    folder, *_ = written
    assert not list(folder.rglob("*.partial"))


def test_a_snapshot_that_cannot_be_finished_leaves_the_old_one(written, tmp_path, monkeypatch):
    """Written under another name and renamed: complete or absent."""
    _, _, simulation, _ = written
    path = tmp_path / "00000.vtkhdf"
    snapshots.write_snapshot(path, simulation, "{}", "float64")
    before = path.read_bytes()

    def full(*_args, **_kwargs):
        raise OSError("no space left on device")

    monkeypatch.setattr(polydata, "_fill", full)
    with pytest.raises(RunError, match=r"00000.partial: cannot be written: no space"):
        snapshots.write_snapshot(path, simulation, "{}", "float64")
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_metadata_is_complete(written):
    """Time, step, version, rank layout, units, and the scene with all defaults, in every snapshot."""
    folder, scene, simulation, _ = written
    for k, path in enumerate(sorted((folder / "snapshots").iterdir())):
        with h5py.File(path) as file:
            meta = file["parsph"]
            assert meta.attrs["time [s]"] == pytest.approx(k * EVERY, abs=1e-12)
            assert meta.attrs["version"] == parsph.__version__
            assert meta.attrs["ranks"] == 1
            assert list(meta.attrs["column cuts"]) == [0, simulation.domain.grid.columns]
            assert load_scene(json.loads(meta["scene"][()])) == scene
            units = json.loads(meta.attrs["units"])
            assert {field.name: field.unit for field in FIELDS}.items() <= units.items()
            assert file["VTKHDF/PointData/pressure"].attrs["unit"] == "Pa"
            assert file["VTKHDF/Points"].attrs.get("unit", "m") == "m"
            steps = meta.attrs["step"]
    assert steps == simulation.steps


def test_vtk_reads_moments_as_vectors_and_tensors(tmp_path):
    """In one file and in the series; only where the scene asks for them."""
    output = {"snapshots": {"every": EVERY, "moments": True}}
    simulation = build(load_scene(tank(time={"end": END}, output=output)), folder=tmp_path)
    simulation.run()
    path = sorted((tmp_path / "snapshots").iterdir())[-1]
    names = {moment.name for moment in MOMENTS}
    for file, step in ((path, None), (tmp_path / "series.vtkhdf", 5)):
        _, _, points, arrays = read(file, step)
        assert set(arrays) == {*POINT_DATA, *names}
        shapes = [arrays[moment.name].shape[1:] for moment in MOMENTS]
        assert shapes == [(), (3,), (3,), (9,)]
        tensor = arrays["gradient_moment1"].reshape(-1, 3, 3)
        assert (tensor[:, 2] == 0).all()
        assert (tensor[:, :, 2] == 0).all()
        deep = tensor[points[:, 1] < 0.15]
        assert len(deep) > 100
        np.testing.assert_allclose(deep[:, :2, :2], np.broadcast_to(np.eye(2), (len(deep), 2, 2)), atol=0.02)
    with h5py.File(path) as file:
        assert file["VTKHDF/PointData/gradient_moment0"].attrs["unit"] == "1/m"
        assert json.loads(file["parsph"].attrs["units"])["kernel_moment1"] == "m"


def test_snapshots_hold_what_an_analysis_needs():
    assert set(POINT_DATA) == {"id", "kind", "velocity", "density", "pressure", "mass"}


def test_snapshots_of_water_hold_masses_in_kilograms(written):
    """Per metre of width: rho dx^2, which sums to the water of the tank."""
    folder, scene, *_ = written
    for path in (folder / "snapshots").iterdir():
        with h5py.File(path) as file:
            data = file["VTKHDF/PointData"]
            assert {name: data[name].attrs["unit"] for name in ("mass", "density", "velocity")} == {
                "mass": "kg",
                "density": "kg/m^3",
                "velocity": "m/s",
            }
            assert data["mass"][:].sum() == pytest.approx(1000 * 0.2 * 0.2, rel=1e-2)
            assert data["mass"].dtype == scene.output.snapshots.precision


@pytest.fixture(scope="module")
def shallow(tmp_path_factory):
    """(folder, simulation) of a short run of shallow water of two depths."""
    keys = {
        "domain": {"size": [40.0]},
        "fluid": {"blocks": [{"low": [0], "high": [20], "depth": 1.5}, {"low": [20], "high": [40], "depth": 1.0}]},
        "walls": {"left": {}, "right": {}},
        "numerics": {"state": "shallow", "dx": 0.5, "density": "summation", "viscosity": "monaghan"},
        "time": {"end": 2.0},
        "output": {"snapshots": {"every": 1.0}},
        "gauges": [{"kind": "level", "x": 17.3, "every": 0.5}],
    }
    folder = tmp_path_factory.mktemp("shallow")
    simulation = build(load_scene(keys), folder=folder)
    simulation.run()
    return folder, simulation


def test_snapshots_of_shallow_water_have_the_units_of_a_depth(shallow):
    """The depth stands for the density: m, its pressure m^3/s^2, mass m^2; the metadata and the series say so too."""
    folder, simulation = shallow
    units = {"density": "m", "pressure": "m^3/s^2", "mass": "m^2", "velocity": "m/s"}
    paths = sorted((folder / "snapshots").iterdir())
    assert len(paths) == 3
    for path in (*paths, folder / "series.vtkhdf"):
        with h5py.File(path) as file:
            data = file["VTKHDF/PointData"]
            assert {name: data[name].attrs["unit"] for name in units} == units
            if "parsph" in file:
                assert units.items() <= json.loads(file["parsph"].attrs["units"]).items()
    with h5py.File(paths[0]) as file:
        assert file["VTKHDF/PointData/mass"][:].sum() == pytest.approx(20 * 1.5 + 20 * 1.0, rel=5e-3)
    _, data, points, arrays = read(paths[-1])
    assert data.GetNumberOfPoints() == 80
    assert_holds(points, arrays, look(simulation), "float64")
    assert (points[:, 1:] == 0).all()
    np.testing.assert_allclose(arrays["pressure"], 0.5 * 9.81 * arrays["density"] ** 2, rtol=1e-13)


def test_table_of_a_depth_gauge(shallow):
    """The depths of the particles on both sides of x, in between."""
    folder, simulation = shallow
    table = read_table(folder / "gauges" / "level-00.csv")
    assert list(table) == ["time [s]", "level [m]"]
    np.testing.assert_allclose(table["time [s]"], [0, 0.5, 1, 1.5, 2], rtol=1e-14)
    x, depth = simulation.field("position")[:, 0], simulation.field("density")
    left, right = x[x <= 17.3].max(), x[x > 17.3].min()
    share = (17.3 - left) / (right - left)
    expected = (1 - share) * depth[x == left][0] + share * depth[x == right][0]
    assert table["level [m]"][-1] == pytest.approx(expected, rel=1e-12)
    assert table["level [m]"][0] == 1.5
    assert table["level [m]"][-1] < 1.45


# --- gauge tables --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "every", "columns"),
    [
        ("level-00", 0.002, ["level [m]"]),
        ("middle", 0.005, ["pressure [Pa]"]),
        (
            "energy-02",
            0.003,
            [
                "mass [kg]",
                "kinetic energy [J]",
                "potential energy [J]",
                "compressible energy [J]",
                "momentum x [kg m/s]",
                "momentum up [kg m/s]",
            ],
        ),
    ],
)
def test_gauge_tables_have_units_and_rows_at_multiples(written, name, every, columns):
    folder, _, simulation, _ = written
    with open(folder / "gauges" / f"{name}.csv", newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["time [s]", *columns]
    times = [float(row[0]) for row in rows]
    assert times == pytest.approx([k * every for k in range(len(times))], rel=1e-14, abs=1e-12)
    assert len(times) == int(END / every + 1e-9) + 1
    gauge = next(g for g in simulation.observers if getattr(g, "name", "") == name)
    np.testing.assert_array_equal(np.array(rows, float), gauge.record())


def test_tables_grow_while_the_run_goes_on(tmp_path):
    """Each row is on disk at once, to the last digit."""
    path = tmp_path / "gauges" / "a.csv"
    table = Table(path, ["time [s]", "level [m]"])
    assert read_table(path)["level [m]"].shape == (0,)
    table.add([0.1, 1 / 3])
    assert read_table(path)["level [m]"].tolist() == [1 / 3]
    table.close()


def test_gauges_without_a_folder_keep_their_records():
    simulation = build(load_scene(tank(gauges=GAUGES)))
    simulation.run()
    assert simulation.observers[0].record().shape == (6, 2)


@pytest.mark.parametrize("end", [math.pi / 300, 1 / 90, 0.012, 0.0211])
def test_the_end_of_a_run_is_an_output_and_no_step_before_it_is_a_sliver(end):
    """Intervals are often a share of the run, as the default of snapshots is, and no share of a float is exact."""
    simulation = build(load_scene(tank(time={"end": end})))
    probe = Probe(end / 10, lambda simulation: simulation.last_dt)
    simulation.observers.append(probe)
    simulation.run()
    assert len(probe.seen) == 11
    assert probe.seen[-1][0] == simulation.time == pytest.approx(end, abs=1e-12)
    assert simulation.last_dt > 1e-6
    assert min(dt for _, dt in probe.seen[1:]) > 1e-6


# --- folders -------------------------------------------------------------------------------------------------------


def test_folders_are_numbered_and_the_next_free_number_is_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert output_folder("pool").name == "pool-001"
    assert output_folder("pool").name == "pool-002"
    assert output_folder("poo").name == "poo-001"
    (tmp_path / "runs" / "pool-007").mkdir()
    assert str(output_folder("pool")) == "runs/pool-008"
    (tmp_path / "runs" / "pool-999").mkdir()
    assert output_folder("pool").name == "pool-1000"
    assert output_folder("pool").name == "pool-1001"


def test_names_of_folders_are_plain(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert output_folder("my scene/ä").parent.name == "runs"


def test_folder_with_files_is_left_alone(tmp_path):
    out = tmp_path / "mine"
    out.mkdir()
    assert output_folder("pool", out) == out
    (out / "thesis.txt").write_text("years of work")
    with pytest.raises(SceneError, match="not empty") as caught:
        output_folder("pool", out)
    assert "--overwrite" in caught.value.cure
    assert (out / "thesis.txt").read_text() == "years of work"


def test_overwrite_removes_an_earlier_run_and_nothing_else(tmp_path):
    out = tmp_path / "mine"
    (out / "snapshots").mkdir(parents=True)
    (out / "snapshots" / "00009.vtkhdf").touch()
    (out / "series.vtkhdf").touch()
    (out / "thesis.txt").write_text("years of work")
    assert output_folder("pool", out, overwrite=True) == out
    assert {path.name for path in out.iterdir()} == {"thesis.txt", ".lock"}


@pytest.mark.parametrize("out", ["file", "file/below"])
@pytest.mark.parametrize("overwrite", [False, True])
def test_folder_that_cannot_be_made(tmp_path, out, overwrite):
    (tmp_path / "file").write_text("here is a file")
    with pytest.raises(SceneError, match="--out") as caught:
        output_folder("pool", tmp_path / out, overwrite)
    assert caught.value.cure
    assert (tmp_path / "file").read_text() == "here is a file"
