"""Compare two runs to the bit, whatever the number of ranks and the writer: snapshots, their times, gauge tables.

python tests/compare_snapshots.py RUN_A RUN_B
"""

import sys
from pathlib import Path

import h5py
import numpy as np


def content(path):
    """Return the time and the point data of a snapshot in the order of particle numbers."""
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        order = np.argsort(root["PointData/id"][:], kind="stable")
        data = {name: values[:][order] for name, values in root["PointData"].items()}
        assert root["NumberOfPoints"][:].sum() == len(order), f"{path}: points per part do not add up"
        return {"time": file["parsph"].attrs["time [s]"], "Points": root["Points"][:][order], **data}


def differences(a, b):
    """Return what differs between the folders of two runs, a list of texts."""
    a, b = Path(a), Path(b)
    found = []
    for pattern in ("snapshots/*.vtkhdf", "gauges/*.csv"):
        names = {str(path.relative_to(folder)) for folder in (a, b) for path in folder.glob(pattern)}
        if not names and "snapshots" in pattern:
            found.append("no snapshots at all")
        for name in sorted(names):
            if not ((a / name).exists() and (b / name).exists()):
                found.append(f"{name}: in one run only")
            elif name.endswith(".csv"):
                if (a / name).read_bytes() != (b / name).read_bytes():
                    found.append(f"{name}: differs")
            else:
                one, other = content(a / name), content(b / name)
                if one.keys() != other.keys():
                    found.append(f"{name}: other fields")
                    continue
                for key in one:
                    if np.asarray(one[key]).tobytes() != np.asarray(other[key]).tobytes():
                        found.append(f"{name}: {key} differs")
    return found


if __name__ == "__main__":
    found = differences(*sys.argv[1:3])
    print("\n".join(found) or f"equal to the bit: {sys.argv[1]} and {sys.argv[2]}")
    sys.exit(bool(found))
