"""Two runs compared to the bit, whatever the number of ranks and the writer: snapshots, their times and steps, gauge tables."""

from pathlib import Path

import h5py
import numpy as np


def content(path):
    """Return time, step and data of a snapshot, {name: array}, in the order of particle numbers."""
    with h5py.File(path) as file:
        root, meta = file["VTKHDF"], file["parsph"].attrs
        order = np.argsort(root["PointData/id"][:], kind="stable")
        data = {name: values[:][order] for name, values in root["PointData"].items()}
        clock = {"time": np.array(meta["time [s]"]), "step": np.array(meta["step"])}
        return {**clock, "parts": np.array(root["NumberOfPoints"][:].sum()), "Points": root["Points"][:][order], **data}


def contents(folder):
    """Return what a run recorded, {file: {name: array}} of snapshots and {file: bytes} of tables."""
    folder = Path(folder)
    found = {str(path.relative_to(folder)): content(path) for path in sorted(folder.glob("snapshots/*.vtkhdf"))}
    return found | {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.glob("gauges/*.csv"))}


def differences(one, other):
    """Return what differs between the folders of two runs, a list of texts."""
    one, other, found = contents(one), contents(other), []
    if not any(name.startswith("snapshots") for name in one | other):
        found.append("no snapshots at all")
    for name in sorted(one.keys() | other.keys()):
        if name not in one or name not in other:
            found.append(f"{name}: in one run only")
        elif isinstance(one[name], bytes):
            found += [f"{name}: differs"] * (one[name] != other[name])
        elif one[name].keys() != other[name].keys():
            found.append(f"{name}: other fields")
        else:
            for field, values in one[name].items():
                if values.dtype != other[name][field].dtype or values.tobytes() != other[name][field].tobytes():
                    found.append(f"{name}: {field} differs")
    return found
