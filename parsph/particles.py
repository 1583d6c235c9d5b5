"""The table of fields and the arrays that it describes.

A particle is one row of `shared` (what a neighbour needs to know of it, so what a halo carries) and one row of `private`
(what only its owner needs: the values at the beginning of the step). Rows make a halo one contiguous slice, and a sort one
cache line per particle. A new field is one line of the table.
"""

from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .jit import jit


@dataclass(frozen=True)
class Field:
    """One quantity per particle.

    Attributes
    ----------
    name : str
    rank : int
        0 for a scalar, 1 for a vector of `dim` components, 2 for a symmetric tensor: its upper triangle, row by row.
    unit : str
    description : str
    part : str
        "shared" (halo and migration), "private" (migration only), "rate" (an array of its own, which each evaluation fills and
        the next step needs), "derived" (worked out for a snapshot, kept nowhere).
    snapshot : bool
        Whether snapshots hold it.
    lasting : bool
        Whether it lives from one step to the next, so that checkpoints hold it.
    needed_by : str
        The feature of a scene that needs it, an integrator or a term; empty when every scene does.
    found_in : str
        The array of `Particles` that it is carried over from at the end of an evaluation; empty when it is not.
    """

    name: str
    rank: int
    unit: str
    description: str
    part: str = "shared"
    snapshot: bool = False
    lasting: bool = True
    needed_by: str = ""
    found_in: str = ""


# Compiled code relies on the order of the first five, that what is carried from one evaluation to the next comes after, and
# on the orders of that and of what integrators keep.
FIELDS = (
    Field("position", 1, "m", "position"),
    Field("velocity", 1, "m/s", "velocity", snapshot=True),
    Field("density", 0, "kg/m^3", "density", snapshot=True),
    Field("pressure", 0, "Pa", "pressure from the equation of state", snapshot=True, lasting=False),
    Field("mass", 0, "kg", "mass, per metre of width in 2D and per square metre of cross-section in 1D", snapshot=True),
    Field(
        "strain_rate", 2, "1/s", "grad v + (grad v)^T at the evaluation before", needed_by="newtonian", found_in="strain_rate"
    ),
    Field(
        "smoothing",
        1,
        "m/s",
        "smoothed velocity less the own, at the evaluation before",
        needed_by="xsph_continuity",
        found_in="drift",
    ),
    Field(
        "density_gradient",
        1,
        "kg/m^4",
        "renormalised gradient of the density that diffuses, at the evaluation before",
        needed_by="antuono",
        found_in="density_gradient",
    ),
    Field("start_velocity", 1, "m/s", "velocity at the beginning of the step", "private", lasting=False),
    Field("start_density", 0, "kg/m^3", "density at the beginning of the step", "private", lasting=False),
    Field("start_position", 1, "m", "position at the beginning of the step", "private", lasting=False, needed_by="midpoint"),
    Field("last_acceleration", 1, "m/s^2", "acceleration of the step before", "private", needed_by="adams-bashforth"),
    Field("last_density_rate", 0, "kg/m^3/s", "density rate of the step before", "private", needed_by="adams-bashforth"),
    Field("acceleration", 1, "m/s^2", "acceleration at the last evaluation", "rate"),
    Field(
        "density_rate", 0, "kg/m^3/s", "density rate at the last evaluation; where densities are summed, the density", "rate"
    ),
    Field("drift", 1, "m/s", "what particles move with beside their velocity", "rate", needed_by="drift"),
)

# Arrays of their own, which each evaluation fills; compiled code gets them in this order.
FOUND = tuple(field.name for field in FIELDS if field.part == "rate" or field.name == field.found_in)

# A tag is `image << IMAGE_SHIFT | id`: fluid first in every cell, then its images, then fixed ghosts with numbers of their
# own, all in an order of their own.
IMAGE_SHIFT = 48
FIRST_GHOST = 1 << IMAGE_SHIFT
FIRST_FIXED = 1 << 60


@dataclass(frozen=True)
class Layout:
    """Where each field of a scene stands in its row.

    Parameters
    ----------
    dim : int
        Number of space dimensions.
    features : tuple of str
        What the scene names that needs fields of its own: its integrator, which decides what of the beginning of a step is
        kept, and terms.
    """

    dim: int
    features: tuple

    @property
    def fields(self):
        """The fields that this scene needs."""
        return [field for field in FIELDS if field.needed_by in ("", *self.features)]

    @property
    def axes(self):
        """The axes: a tuple, whose length is known to compiled code, so that it has no loops over them."""
        return tuple(range(self.dim))

    def width(self, part):
        """Return the number of numbers in a row of `part`."""
        return sum(self.components(field) for field in self.fields if field.part == part)

    def components(self, field):
        """Return the number of components of `field`."""
        return (1, self.dim, self.dim * (self.dim + 1) // 2)[field.rank]

    @cached_property
    def _columns(self):
        """{name: (part, slice)} of the fields; evaluations ask, so it is worked out once."""
        found, first = {}, {"shared": 0, "private": 0}
        for field in self.fields:
            begin = first.get(field.part, 0)  # rates have arrays of their own
            end = begin + self.components(field)
            found[field.name] = field.part, slice(begin, end)
            if field.part in first:
                first[field.part] = end
        return found

    def columns(self, name):
        """Return (part, slice) of the field `name`."""
        return self._columns[name]

    def rank(self, name):
        """Return the rank of the field `name`."""
        return next(field.rank for field in self.fields if field.name == name)

    def place(self, name):
        """Return the first column of the field `name` in its row, -1 where this scene does not need it."""
        return self._columns[name][1].start if name in self._columns else -1

    @cached_property
    def carried(self):
        """The first columns of what rows carry from one evaluation to the next: strain rate, smoothing, density gradient."""
        return tuple(self.place(field.name) for field in FIELDS if field.found_in)

    def bytes_per_particle(self):
        """Return the bytes of one particle in all arrays that grow with the particles: rows twice (a sort needs
        both), tags twice, cell, order and rates.
        """
        rows = 8 * (self.width("shared") + self.width("private"))
        found = sum(self.components(field) for field in self.fields if field.name in FOUND)
        return 2 * rows + 2 * 8 + 4 + 4 + 8 * found


class Particles:
    """The particles of one rank, in the order of (cell, tag), with room for halos on both sides.

    Attributes
    ----------
    shared, private : ndarray, shape (capacity, width)
    tags : ndarray of int64, shape (capacity,)
    cells : ndarray of int32, shape (capacity,)
        Cell of each particle that is to be sorted.
    first, last : int
        The owned particles (ghosts included) are the rows ``first:last``.
    correction : ndarray, shape (capacity, width), or (0, 0) in scenes with the plain kernel
        Coefficients of the corrected kernel, see `parsph.moments.Correction`.
    drift : ndarray, shape (capacity, dim), or (0, dim) in scenes without smoothing and shifting
        What particles move with beside their velocity [m/s].
    strain_rate, density_gradient : ndarray, shape (capacity, dim (dim + 1) / 2 or dim), or (0, ...) in scenes that need none
        What the sweep finds [1/s, kg/m^4], while pairs still use that of the evaluation before, in the rows; see `carry`.
    summed : bool
        Whether `density_rate` holds densities: those of a scene that sums them instead of integrating.
    """

    def __init__(self, layout, capacity=64):
        self.layout = layout
        self.first = self.last = 0
        self.summed = False
        self.shared = np.zeros((0, layout.width("shared")))
        self.private = np.zeros((0, layout.width("private")))
        self.tags = np.zeros(0, np.int64)
        self._spare = {name: getattr(self, name) for name in ("shared", "private", "tags")}
        self.cells = np.zeros(0, np.int32)
        self.order = np.zeros(0, np.int32)
        for field in (field for field in FIELDS if field.name in FOUND):  # a row where it is needed: `reserve` adds the others
            row = (layout.components(field),) if field.rank else ()
            setattr(self, field.name, np.zeros((int(field in layout.fields), *row)))
        self._carried = [field for field in layout.fields if field.found_in]
        self.correction = np.zeros((0, 0))
        self.reserve(capacity)

    def reserve(self, capacity):
        """Make room for `capacity` rows, keeping what is there."""
        if capacity <= len(self.tags):
            return
        capacity = room_for(capacity)
        for name in ("shared", "private", "tags", "cells"):
            setattr(self, name, _enlarged(getattr(self, name), capacity))
        for name in ("correction", *FOUND):
            if len(getattr(self, name)):
                setattr(self, name, _enlarged(getattr(self, name), capacity))
        self._spare = {name: np.zeros_like(array) for name, array in self._spare_like().items()}
        self.order = np.zeros(capacity, np.int32)

    @contextmanager
    def preserved(self):
        """Whatever happens to the particles inside the ``with`` block, they are as before after it, to the bit.

        Sorts and halos write rows and tags, growth replaces all arrays: the old ones come back.
        """
        kept = {**vars(self), **{name: array.copy() for name, array in self._spare_like().items()}}
        try:
            yield
        finally:
            vars(self).update(kept)

    def _spare_like(self):
        return {"shared": self.shared, "private": self.private, "tags": self.tags}

    @property
    def spare(self):
        """The arrays that a sort writes into: (shared, private, tags)."""
        return self._spare["shared"], self._spare["private"], self._spare["tags"]

    def swap(self, first, last):
        """Make the sorted arrays the current ones; the owned rows are then ``first:last``."""
        sorted_arrays, self._spare = self._spare, self._spare_like()
        self.shared, self.private, self.tags = (sorted_arrays[name] for name in ("shared", "private", "tags"))
        self.first, self.last = first, last

    def add(self, tags, **fields):
        """Append owned particles with the given `tags` (int64, shape (n,)) and fields, shapes (n,) or (n, dim)."""
        count = len(tags)
        self.reserve(self.last + count)
        rows = slice(self.last, self.last + count)
        self.tags[rows] = tags
        for name, values in fields.items():
            view = self.view(name)
            view[rows] = np.reshape(values, (count, view.shape[1]))
        self.last += count

    def carry(self):
        """Put what the evaluation that ends found into the owned rows, where the next one looks for it."""
        for field in self._carried:
            put_columns(getattr(self, field.found_in), self.shared, self.first, self.last, self.layout.place(field.name))

    def view(self, name):
        """Return all rows of the field `name`, shape (capacity, components), to be read or written."""
        part, columns = self.layout.columns(name)
        if part == "rate":
            return getattr(self, name).reshape(len(self.tags), -1)
        return getattr(self, part)[:, columns]

    @property
    def nbytes(self):
        """Bytes of all arrays."""
        arrays = [value for value in vars(self).values() if isinstance(value, np.ndarray)]
        return sum(array.nbytes for array in (*arrays, *self._spare.values()))

    @property
    def fluid(self):
        """Row numbers of the owned fluid particles, in sorted order, shape (n,)."""
        return self.first + np.flatnonzero(self.tags[self.first : self.last] < FIRST_GHOST)

    def field(self, name, rows):
        """Return the field `name` of the given `rows`, shape (n,) or (n, dim)."""
        values = self.view(name)[rows]
        return values if values.shape[1] > 1 or self.layout.rank(name) else values[:, 0]


@jit
def put_columns(found, rows, first, last, column):
    """Write the rows ``first:last`` of `found` to those of `rows`, from `column` on."""
    for i in range(first, last):
        for d in range(found.shape[1]):
            rows[i, column + d] = found[i, d]


def room_for(rows):
    """Return the capacity of arrays that have to be enlarged for so many rows: some more, since the next ones come soon."""
    return int(1.15 * rows) + 64


def _enlarged(array, capacity):
    larger = np.zeros((capacity, *array.shape[1:]), array.dtype)
    larger[: len(array)] = array
    return larger


def identities(tags):
    """Return the particle numbers in `tags`."""
    return tags & (FIRST_GHOST - 1)


def kinds(tags):
    """Return the kinds in `tags`: 0 for fluid, else the bits of the walls that mirror it."""
    return tags >> IMAGE_SHIFT
