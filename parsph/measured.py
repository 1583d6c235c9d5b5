"""Measured records of dam breaks, to compare runs with.

============================  ====================================================================================
`buchner_p1`                  Pressure on the wall at the end of the tank, ``p / (rho g H)`` against ``t sqrt(g/H)``:
                              Buchner (2002), Green water on ship-type offshore structures, PhD thesis, TU Delft.
                              H = 0.6 m, column 2 H long, tank 5.366 H; a plate of 90 mm, its middle 0.16 m above the
                              bed. Before the front arrives there is noise of up to 0.16.
`martin_moyce_n2_2_a2.25in`,  Surge front z/a against ``t sqrt(2g/a)``: Martin & Moyce (1952), An experimental study of
`martin_moyce_n2_2_a1.125in`  the collapse of liquid columns on a rigid horizontal plane, Phil. Trans. R. Soc. A 244,
                              312-324, Fig. 3. Column 2 a high and a = 2.25 or 1.125 inches long.
`koshizuka_oka_exp`           Surge front x/L against ``t sqrt(2g/L)``: Koshizuka & Oka (1996), Moving-particle
                              semi-implicit method for fragmentation of incompressible fluid, Nucl. Sci. Eng. 123,
                              421-434. Column L = 0.146 m long and 2 L high.
============================  ====================================================================================

All are digitised; the head of each file in ``data/`` says from where, and what its columns are.
"""

import csv
from importlib import resources

import numpy as np

from .errors import SceneError, did_you_mean

DATA = resources.files(__package__) / "data"


def measured_names():
    """Return the names of all records."""
    return sorted(entry.name.removesuffix(".csv") for entry in DATA.iterdir() if entry.name.endswith(".csv"))


def measured(name):
    """Return a record as {column: ndarray, shape (n,)}.

    Raises
    ------
    SceneError
        When there is no such record.
    """
    if name not in measured_names():
        cure = f"{did_you_mean(name, measured_names())}one of: {', '.join(measured_names())}"
        raise SceneError(f"no measured record {name!r}", cure=cure)
    lines = (DATA / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    header, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    return dict(zip(header, np.array(rows, float).T, strict=True))
