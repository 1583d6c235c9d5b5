"""Compilation: NaN stays visible, float32 stays float32, and the disk cache is never stale."""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from helpers import python

import parsph
from parsph.jit import compilations, jit, like


@jit
def _is_nan(x):
    return x != x or math.isnan(x) or not (x < 1e300)


@jit
def _half(x):
    return like(0.5, x) * x


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
