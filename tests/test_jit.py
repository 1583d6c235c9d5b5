"""Compilation: NaN stays visible, float32 stays float32, and the disk cache is never stale."""

import gc
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from helpers import python

import parsph
from parsph.jit import by_code, compilations, jit, like


@jit
def _is_nan(x):
    return x != x or math.isnan(x) or not (x < 1e300)


@jit
def _half(x):
    return like(0.5, x) * x


@jit
def _double(x):
    return 2.0 * x


@jit
def _square(x):
    return x * x


@jit
def _cube(x):
    return x * x * x


@by_code({0: _double, 1: _square, 2: _cube})
def _power(code, x):
    """Twice, or to the power of 2 or 3."""


@jit
def _handed_down(code, x):
    return _power(code, x) + 1.0


def test_only_the_formula_of_the_code_is_compiled():
    code = 1

    @jit
    def direct(x):
        return _power(code, x)

    @jit
    def through(x):
        return _handed_down(code, x)

    assert (direct(3.0), through(3.0)) == (9.0, 10.0)
    assert not _double.signatures
    assert not _cube.signatures
    assert _power(2, 3.0) == 27.0, "without compiled code around it"
    assert _power.__doc__ == "Twice, or to the power of 2 or 3."


@pytest.mark.parametrize("collects", [True, False])
def test_compiling_leaves_the_garbage_collector_as_it_was(collects):
    before = gc.isenabled()
    (gc.enable if collects else gc.disable)()
    try:
        jit(lambda x: x + 2.0 * collects)(1.0)
        assert gc.isenabled() == collects
    finally:
        (gc.enable if before else gc.disable)()


def test_nan_stays_visible_to_compiled_guards():
    assert _is_nan(math.nan)
    assert _is_nan(math.inf)
    assert not _is_nan(1.0)


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_constants_take_the_precision_of_their_reference(real):
    assert _half(real(3)) == 1.5
    signature = next(s for s in _half.signatures if str(s[0]) == np.dtype(real).name)
    assert str(_half.overloads[signature].signature.return_type) == np.dtype(real).name
    assert like(0.5, real(3)).dtype == real


def test_compilations_are_counted():
    before = compilations()

    @jit
    def fresh(x):
        return x + 1

    fresh(1.0)
    assert compilations() - before in (0, 1)  # 0 when an earlier run of this test left it in the cache
    assert fresh.stats.cache_misses or fresh.stats.cache_hits


def test_edited_sources_never_find_the_cache_of_the_old_ones(tmp_path):
    """numba does not notice that a function which a cached one calls has changed; the folder's name must."""
    source = tmp_path / "here"
    shutil.copytree(Path(parsph.__file__).parent, source / "parsph", ignore=shutil.ignore_patterns("__pycache__"))
    script = tmp_path / "folder.py"
    script.write_text("import parsph.jit, numba\nprint(numba.config.CACHE_DIR)\n")
    environment = {"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def folder():
        result = python(script, cwd=tmp_path, environment=environment)
        assert result.returncode == 0, result.stderr
        return result.stdout.strip()

    first = folder()
    assert first == folder()
    assert first.startswith(str(tmp_path / "cache"))
    with open(source / "parsph" / "terms" / "momentum.py", "a") as file:
        file.write("\nEDITED = True\n")
    assert folder() != first
