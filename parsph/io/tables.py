"""Gauge tables: CSV with units in the header, flushed as they grow."""

import csv
import io
import math

from .folder import failure, write_whole


class Table:
    """A growing CSV file whose first column is the time.

    Parameters
    ----------
    path : Path
    columns : list of str
        Headers with units, as "time [s]".
    until : float
        Of a table that is there already the rows up to this time [s] are kept; the run writes what came after again.

    Raises
    ------
    RunError
        When it cannot be written.
    """

    def __init__(self, path, columns, until=-math.inf):
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path = path
        rows = [line for line in _lines(path)[1:] if float(line[0]) <= until] if path.exists() else []
        write_whole(path, _text([columns, *rows]))
        self._file = open(path, "ab", buffering=0)  # noqa: SIM115 - open as long as the run

    def add(self, values):
        """Append a row of numbers, to full precision."""
        row = _text([[repr(float(value)) for value in values]]).encode()
        try:
            while row:  # a disk that fills up takes a part of it
                row = row[self._file.write(row) :]
        except OSError as error:
            raise failure(self.path, error) from error

    def close(self):
        """Close the file."""
        self._file.close()


def table_name(name, kind, number):
    """Return the name of a gauge's table: the gauge's own `name`, or its kind and its `number` in the scene."""
    return name or f"{kind}-{number:02d}"


def read_table(path):
    """Return {header: ndarray} of a gauge table."""
    import numpy as np

    header, *rows = _lines(path)
    data = np.array(rows, float).reshape(-1, len(header))
    return dict(zip(header, data.T, strict=True))


def _lines(path):
    """Return the lines of a table, as lists of texts, without the last one if a run has broken off in it."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.reader(line for line in file if line.endswith("\n")))


def _text(rows):
    text = io.StringIO(newline="")
    csv.writer(text).writerows(rows)
    return text.getvalue()
