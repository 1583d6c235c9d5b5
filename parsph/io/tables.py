"""Gauge tables: CSV with units in the header, flushed as they grow."""

import csv


class Table:
    """A growing CSV file.

    Parameters
    ----------
    path : Path
    columns : list of str
        Headers with units, as "time [s]".
    """

    def __init__(self, path, columns):
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = open(path, "w", newline="", encoding="utf-8")  # noqa: SIM115 - open as long as the run
        self._writer = csv.writer(self._file)
        self._writer.writerow(columns)
        self._file.flush()

    def add(self, values):
        """Append a row of numbers, to full precision."""
        self._writer.writerow([repr(float(value)) for value in values])
        self._file.flush()

    def close(self):
        """Close the file."""
        self._file.close()


def table_name(name, kind, number):
    """Return the name of a gauge's table: the gauge's own `name`, or its kind and its `number` in the scene."""
    return name or f"{kind}-{number:02d}"


def read_table(path):
    """Return {header: ndarray} of a gauge table."""
    import numpy as np

    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    data = np.array(rows, float).reshape(-1, len(header))
    return dict(zip(header, data.T, strict=True))
