"""The only place where numba is told how to compile.

Compiled code is cached on disk in a folder named by a hash of this package's sources: numba does not notice when a
function that a cached one calls was edited, so another state of the sources must never find the old folder.

A function may close over plain constants and may call other module-level functions decorated here; it must not close over
a compiled function, or it would be compiled again in every process.
"""

import gc
import hashlib
import os
import platform
import shutil
import time
from functools import wraps
from pathlib import Path

import numba
import numpy as np
from llvmlite import binding
from numba.core import event, types
from numba.extending import overload

# No `nnan` and no `ninf`: NaN must stay visible to the guards. The others let sums run in vector lanes.
FAST_MATH = {"nsz": True, "arcp": True, "contract": True, "afn": True, "reassoc": True}
KEPT_CACHES = 6
# Bytes of the widest vectors of this machine: loops over a multiple of them have no remainder, which would be scalar.
VECTOR = 64 if binding.get_host_cpu_features().get("avx512f") else 32


def processor():
    """Return the name of the processor, its kind as LLVM knows it, and how wide its vectors are."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    name = names[0] if names else platform.processor() or platform.machine()
    return f"{name} ({binding.get_host_cpu_name()}, vectors of {VECTOR} bytes)"


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
    # nobody calls it from C, and an entry for that takes an eighth of the time that compiling does
    dispatcher = numba.njit(cache=True, fastmath=FAST_MATH, error_model="numpy", no_cfunc_wrapper=True)(function)
    _compiled.append(dispatcher)
    return dispatcher


class _GarbageLater(event.Listener):
    """Has Python look for garbage between two functions, not while one is compiled: that takes a seventh of the time."""

    def __init__(self):
        self._depth, self._collects = 0, False

    def on_start(self, _):
        if self._depth == 0:
            self._collects = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, _):
        self._depth -= 1
        if self._depth == 0 and self._collects:
            gc.enable()


event.register("numba:compile", _GarbageLater())


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


def by_code(formulas):
    """Decorate a function ``(code, x)`` that stands for ``formulas[code](x)``, `formulas` a dict; its own body is not used.

    In compiled code `code` must be a constant of the function around the call, or be handed down to it from one. So no formula
    is compiled that is not called. (A compiled function that got its code from Python would be compiled at every call.)
    """

    def decorate(described):
        @wraps(described)
        def chosen(code, x):
            return formulas[code](x)

        @overload(chosen, prefer_literal=True)
        def _chosen(code, x):
            if isinstance(code, types.IntegerLiteral):
                formula = formulas[code.literal_value]
                return lambda code, x: formula(x)
            return lambda code, x: chosen(numba.literally(code), x)

        return chosen

    return decorate
