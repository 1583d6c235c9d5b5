"""The only place where numba is told how to compile.

Compiled code is cached on disk in a folder named by a hash of this package's sources: numba does not notice when a
function that a cached one calls was edited, so another state of the sources must never find the old folder.

A function may close over plain constants and may call other module-level functions decorated here; it must not close over
a compiled function, or it would be compiled again in every process.
"""

import hashlib
import os
import shutil
import time
from pathlib import Path

import numba
import numpy as np
from numba.core import types
from numba.extending import overload

# No `nnan` and no `ninf`: NaN must stay visible to the guards. The others let sums run in vector lanes.
FAST_MATH = {"nsz": True, "arcp": True, "contract": True, "afn": True, "reassoc": True}
KEPT_CACHES = 6


def _source_hash():
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _cache_folder():
    """Return the cache folder of this state of the sources, with long unused ones of other states removed."""
    home = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    parent = Path(home) / "parsph"
    folder = parent / _source_hash()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        by_age = sorted(parent.iterdir(), key=lambda path: path.stat().st_mtime, reverse=True)
        for old in by_age[KEPT_CACHES:]:
            if time.time() - old.stat().st_mtime > 86400:
                shutil.rmtree(old, ignore_errors=True)
    except OSError:
        pass  # numba falls back on its own folders when this one cannot be written
    return folder


numba.config.CACHE_DIR = str(_cache_folder())

_compiled = []


def jit(function):
    """Compile `function` on its first call, or load it from the disk cache."""
    dispatcher = numba.njit(cache=True, fastmath=FAST_MATH, error_model="numpy")(function)
    _compiled.append(dispatcher)
    return dispatcher


def compilations():
    """Return how many versions of the package's functions were compiled (not loaded) in this process."""
    return sum(sum(dispatcher.stats.cache_misses.values()) for dispatcher in _compiled)


def like(value, reference):
    """Return the constant `value` in the precision of `reference`.

    A float64 constant would lift float32 pair arithmetic to float64.
    """
    return np.asarray(value, np.asarray(reference).dtype)[()]


@overload(like)
def _like(value, reference):
    if reference == types.float32:
        return lambda value, reference: np.float32(value)
    return lambda value, reference: value
