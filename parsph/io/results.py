"""What a run left behind, read again: scene, summary, gauge records, snapshots."""

import json
import re
from pathlib import Path

import h5py
import numpy as np

from ..errors import SceneError
from .tables import read_table, table_name

SCENE_FILE, SUMMARY_FILE = "scene.json", "summary.json"


class Results:
    """The output folder of a run.

    Parameters
    ----------
    folder : path

    Attributes
    ----------
    scene : dict
        The scene with defaults filled in.
    folder : Path

    Raises
    ------
    SceneError
        When the folder is not that of a run.
    """

    def __init__(self, folder):
        self.folder = Path(folder)
        try:
            self.scene = json.loads((self.folder / SCENE_FILE).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            why = "there is no scene.json that can be read"
            cure = "a folder that parsph run has written, as runs/pool-001"
            raise SceneError("is not the folder of a run", where=str(folder), why=why, cure=cure) from None

    @property
    def name(self):
        """The name of the folder, without the number that a run gave it."""
        return re.sub(r"-\d{3,}$", "", self.folder.resolve().name)

    @property
    def summary(self):
        """The summary of the finished run, a dict; None when it has not finished."""
        path = self.folder / SUMMARY_FILE
        return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None

    @property
    def level(self):
        """Still-water level [m]; in shallow water the largest depth, unless the scene says otherwise."""
        fluid = self.scene["fluid"]
        if fluid["level"] is not None:
            return fluid["level"]
        shallow = self.scene["numerics"]["state"] == "shallow"
        return max(block["depth"] if shallow else block["high"][-1] for block in fluid["blocks"])

    @property
    def depth(self):
        """Still-water depth [m] over the lowest point of the fluid."""
        shallow = self.scene["numerics"]["state"] == "shallow"
        return self.level - (0.0 if shallow else min(block["low"][-1] for block in self.scene["fluid"]["blocks"]))

    @property
    def units(self):
        """Unit of each field of the snapshots, a dict."""
        with h5py.File(self.snapshots[0]) as file:
            return json.loads(file["parsph"].attrs["units"])

    def layer(self, zone):
        """Return the (low, high) x [m] of an absorbing layer, one of ``scene["damping"]``."""
        length, end = zone["length"], self.scene["domain"]["size"][0]
        return (0.0, length) if zone["side"] == "left" else (end - length, end)

    def gauges(self, kind):
        """Return {name: keys of the scene} of all gauges of a `kind`, in the scene's order."""
        gauges = enumerate(self.scene["gauges"])
        return {table_name(gauge["name"], kind, number): gauge for number, gauge in gauges if gauge["kind"] == kind}

    def table(self, name):
        """Return {header: ndarray} of the gauge `name`.

        Raises
        ------
        SceneError
            When there is no such table.
        """
        path = self.folder / "gauges" / f"{name}.csv"
        if not path.exists():
            names = ", ".join(sorted(entry.stem for entry in path.parent.glob("*.csv"))) or "none"
            raise SceneError(f"no gauge {name!r}", where=str(self.folder), cure=f"one of: {names}")
        return read_table(path)

    def levels(self, names=None):
        """Return the records of level gauges.

        Parameters
        ----------
        names : list of str, optional
            Default: all level gauges of the scene.

        Returns
        -------
        tuple
            Times [s], shape (samples,); levels [m], shape (gauges, samples); positions [m], shape (gauges,); names.

        Raises
        ------
        SceneError
            When there is no level gauge, or they have different times.
        """
        known = self.gauges("level")
        for name in names or []:
            if name not in known:
                cure = f"one of: {', '.join(known) or 'none in this scene'}"
                raise SceneError(f"no level gauge {name!r}", where=str(self.folder), cure=cure)
        names = list(names or known)
        if not names:
            raise SceneError("no level gauges", where=str(self.folder), cure='gauges of kind "level" in the scene')
        tables = [self.table(name) for name in names]
        t = tables[0]["time [s]"]
        if any(not np.array_equal(table["time [s]"], t) for table in tables):
            raise SceneError(
                "level gauges with different times", where=str(self.folder), cure="the same `every` for all of them"
            )
        places = np.array([known[name]["x"] for name in names])
        return t, np.array([table["level [m]"] for table in tables]), places, names

    @property
    def snapshots(self):
        """Paths of all snapshots, in the order of time."""
        return sorted((self.folder / "snapshots").glob("*.vtkhdf"))

    def snapshot(self, number=-1):
        """Return a snapshot as {"time": [s], "position": (n, 3), field: (n,) or (n, 3)}, sorted by "id".

        Raises
        ------
        SceneError
            When there is no snapshot of that number.
        """
        paths = self.snapshots
        if not -len(paths) <= number < len(paths):
            raise SceneError(f"no snapshot {number}", where=str(self.folder), cure=f"{len(paths)} are there")
        with h5py.File(paths[number]) as file:
            root = file["VTKHDF"]
            found = {name: dataset[:] for name, dataset in root["PointData"].items()}
            found["position"] = root["Points"][:]
            time = float(file["parsph"].attrs["time [s]"])
        order = np.argsort(found["id"])
        return {"time": time, **{name: values[order] for name, values in found.items()}}

    def profile(self):
        """Return id, position, velocity, density (the depth) and mass of the last snapshot of a 1D run, each of shape (n,)."""
        last = self.snapshot()
        line = {name: last[name][:, 0] for name in ("position", "velocity")}
        return {**line, **{name: last[name] for name in ("id", "density", "mass")}}
