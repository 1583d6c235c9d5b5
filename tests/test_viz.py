"""Plots show the numbers they are given, say their units, and need matplotlib only when one is drawn."""

import subprocess
import sys

import numpy as np
import pytest

from parsph import viz
from parsph.errors import SceneError

pytest.importorskip("matplotlib")
from matplotlib.image import imread

T = np.linspace(0.0, 10.0, 101)
LEVELS = 1.0 + 0.05 * np.sin(np.outer(T, [1.0, 2.0, 3.0]))
NAMES = ["x = 2 m", "x = 5 m", "x = 8 m"]


@pytest.fixture
def ax():
    return viz.figure()[1]


def block(nx=30, nz=10, dx=0.02):
    """Return positions [m] of a block of particles, shape (nx nz, 2)."""
    x, z = np.meshgrid((np.arange(nx) + 0.5) * dx, (np.arange(nz) + 0.5) * dx)
    return np.stack([x.ravel(), z.ravel()], axis=1)


def units(ax):
    return ax.get_xlabel(), ax.get_ylabel()


def legend(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_few_far_off_values_do_not_take_the_colours_from_all_others():
    values = np.linspace(0.0, 10.0, 2000)
    assert viz.limits_of(values) == (0.0, 10.0)
    values[7] = 1000.0
    low, high = viz.limits_of(values)
    assert low == pytest.approx(0.02, rel=0.1)
    assert high == pytest.approx(9.98, rel=0.01)
    assert viz.limits_of(np.r_[np.zeros(999), 5.0]) == (0.0, 5.0)  # all others are equal
    assert viz.limits_of([3.0, 1.0, 50.0]) == (1.0, 50.0)
    assert viz.limits_of([]) == (0.0, 1.0)


def test_particles_are_drawn_where_they_are_and_in_their_colours(ax):
    position = block()
    pressure = 9810 * (0.2 - position[:, 1])
    cloud, bar, arrows = viz.particles(ax, position, pressure, "p [Pa]", still_level=0.2, limits=(0, 1000))
    assert np.array_equal(cloud.get_offsets(), position)
    assert np.array_equal(cloud.get_array(), pressure)
    assert (cloud.norm.vmin, cloud.norm.vmax, bar.extend) == (0, 1000, "max")
    assert (units(ax), bar.ax.get_xlabel() or bar.ax.get_ylabel()) == (("x [m]", "z [m]"), "p [Pa]")
    assert arrows is None
    assert ax.get_aspect() == 1
    (still,) = ax.lines
    assert (list(still.get_ydata()), still.get_linestyle()) == ([0.2, 0.2], "--")


@pytest.mark.parametrize("size", [(3, 3), (7, 2)])
def test_markers_cover_the_water_in_any_figure(tmp_path, size):
    figure, (ax, _) = viz.figure(1, 2, size=size)
    cloud, _, _ = viz.particles(ax, block(), block()[:, 1], "z [m]")
    viz.save(figure, tmp_path / "block.png")
    spacing = np.diff(ax.transData.transform([(0, 0), (0.02, 0)])[:, 0])[0] * 72 / figure.dpi
    assert cloud.get_sizes() == pytest.approx((1.15 * spacing) ** 2, rel=0.02)  # the layout still moves a little
    assert viz.particles(ax, block(), block()[:, 1], "z [m]", size=3)[0].get_sizes() == [3]


def test_the_layer_is_shaded_between_its_ends(ax):
    viz.particles(ax, block(), block()[:, 1], "z [m]", layer=(0.4, 0.6))
    (shade,) = ax.patches
    assert shade.get_extents().transformed(ax.transData.inverted()).intervalx == pytest.approx([0.4, 0.6])


@pytest.mark.parametrize("nx", [10, 300])
def test_arrows_have_the_velocities_of_their_particles(ax, nx):
    position = block(nx)
    velocity = np.stack([position[:, 1], 1 - position[:, 0]], axis=1)
    _, _, arrows = viz.particles(ax, position, position[:, 0], "x [m]", vectors=velocity)
    assert np.array_equal(arrows.U, arrows.XY[:, 1])
    assert np.array_equal(arrows.V, 1 - arrows.XY[:, 0])
    assert len(arrows.U) == len(position) if nx == 10 else 0 < len(arrows.U) <= 2 * viz.ARROWS
    assert any(text.get_text().endswith("m/s") for text in ax.texts)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_particles_and_a_uniform_field_are_no_trouble(ax, count, tmp_path):
    zeros = np.zeros((count, 2))
    cloud, _, _ = viz.particles(ax, zeros, zeros[:, 0], "p [Pa]", vectors=zeros)
    viz.save(ax.figure, tmp_path / "few.png")
    assert len(cloud.get_offsets()) == count


def test_a_logarithmic_scale_floors_what_is_small_and_shows_that_it_does(ax, tmp_path):
    values = np.array([0.0, 1e-9, 1e-3, 1.0])
    cloud, bar, _ = viz.particles(ax, block(2, 2), values, "M [-]", log=True)
    floor = 10.0**-viz.DECADES
    assert cloud.get_clim() == (floor, 1.0)
    np.testing.assert_allclose(cloud.get_array(), [floor, floor, 1e-3, 1.0])
    assert cloud.norm(np.sqrt(floor)) == pytest.approx(0.5)
    assert bar.extend == "min"
    viz.save(ax.figure, tmp_path / "log.png")


def test_a_logarithmic_scale_of_nothing_is_a_plain_one(ax, tmp_path):
    cloud, _, _ = viz.particles(ax, block(2, 2), np.zeros(4), "M [-]", log=True)
    assert (cloud.get_array() == 0).all()
    viz.save(ax.figure, tmp_path / "zero.png")


def test_particles_without_a_number_are_left_out(ax):
    position, values = block(2, 2), np.array([1.0, np.nan, 3.0, np.inf])
    cloud, _, arrows = viz.particles(ax, position, values, "p [Pa]", vectors=position)
    assert np.array_equal(cloud.get_offsets(), position[[0, 2]])
    assert np.array_equal(arrows.U, position[[0, 2], 0])
    assert list(cloud.get_array()) == [1, 3]


def test_levels_are_stacked_by_the_offset(ax):
    lines = viz.levels(ax, T, LEVELS, NAMES, offset=0.2, style={"label": "coarse", "lw": 2})
    for k, line in enumerate(lines):
        assert np.array_equal(line.get_xdata(), T)
        assert np.array_equal(line.get_ydata(), LEVELS[:, k] + k * 0.2)
        assert line.get_linewidth() == 2
    assert [text.get_text() for text in ax.texts] == NAMES
    assert [line.get_ydata()[0] for line in ax.lines if line not in lines] == pytest.approx([1.0, 1.2, 1.4])
    assert (units(ax), legend(ax)) == (("t [s]", "level [m], shifted by 0.2 m a gauge"), ["coarse"])


def test_another_run_lies_over_the_first(ax):
    """Even a run of other range and with one gauge only: gauges keep the places of the first call."""
    viz.levels(ax, T, LEVELS, NAMES, style={"label": "coarse"})
    (line,) = viz.levels(ax, T, 3 * LEVELS[:, 2], NAMES[2:], style={"label": "fine", "linestyle": "--"})
    assert np.allclose(line.get_ydata() - 3 * LEVELS[:, 2], 2 * 0.15)  # the range is 0.1 m, so 0.15 m is the next round shift
    assert len(ax.texts) == 3
    assert legend(ax) == ["coarse", "fine"]
    ax.clear()
    assert np.array_equal(viz.levels(ax, T, LEVELS[:, 0], ["new"])[0].get_ydata(), LEVELS[:, 0])


def test_no_two_gauges_overlap_of_themselves_and_dry_ones_are_gaps(ax):
    falling = np.stack([1 - 0.04 * T, 0.04 * T, np.full_like(T, np.nan)], axis=1)
    falling[:5, 1] = np.nan
    low, high, dry = (line.get_ydata() for line in viz.levels(ax, T, falling, NAMES))
    assert np.nanmax(low) < np.nanmin(high)
    assert np.isnan(high[:5]).all()
    assert np.isnan(dry).all()


def test_curves_take_common_or_own_abscissae(ax):
    lines = viz.energy(ax, T, {"kinetic": T**2, "potential": (T[::2], T[::2])})
    assert np.array_equal(lines["kinetic"].get_xydata(), np.stack([T, T**2], axis=1))
    assert np.array_equal(lines["potential"].get_xydata(), np.stack([T[::2], T[::2]], axis=1))
    assert (units(ax), legend(ax)) == (("t [s]", "energy [J]"), ["kinetic", "potential"])
    other = viz.figure()[1]
    assert list(viz.profile(other, [1, 2], {"pulse": [3, 4]}, "x [m]", "h [m]")["pulse"].get_ydata()) == [3, 4]
    assert units(other) == ("x [m]", "h [m]")


def test_measured_points_stand_against_theory_and_bars(ax):
    x, measured = np.array([0.5, 1.0, 1.5]), np.array([0.3, np.nan, 0.02])
    options = {"theory": {"WKB": (x, np.exp(-x))}, "bars": {"target": 0.01}}
    lines = viz.against(ax, x, {"linear": measured}, "l/L [-]", "C [-]", **options)
    assert np.array_equal(lines["linear"].get_xydata(), [[0.5, 0.3], [1.5, 0.02]])
    assert np.array_equal(lines["WKB"].get_ydata(), np.exp(-x))
    assert (lines["linear"].get_marker(), lines["WKB"].get_linestyle(), lines["target"].get_linestyle()) == ("o", "--", ":")
    assert set(lines["target"].get_ydata()) == {0.01}
    assert (ax.get_yscale(), units(ax), legend(ax)) == ("log", ("l/L [-]", "C [-]"), ["WKB", "linear"])


def test_spectra_stand_beside_their_target_and_end_where_nothing_is_left(ax):
    f = np.linspace(0.1, 10.0, 100)
    S = np.exp(-(((f - 1) / 0.3) ** 2))
    assert viz.spectra(ax, {"a": (f, S), "b": (f[::2], 2 * S[::2])}, target=(f, 1.1 * S)) is ax
    lines = {line.get_label(): line for line in ax.lines}
    assert np.array_equal(lines["a"].get_xydata(), np.stack([f, S], axis=1))
    assert np.array_equal(lines["b"].get_ydata(), 2 * S[::2])
    assert np.array_equal(lines["target"].get_ydata(), 1.1 * S)
    assert lines["target"].get_linestyle() == "--"
    assert units(ax) == ("f [Hz]", "S [m$^2$/Hz]")
    assert 1.5 < ax.get_xlim()[1] < 2.5
    assert ax.get_ylim()[0] == 0


def test_harmonics_stand_along_the_tank_where_they_are_something(ax, tmp_path):
    x, amplitudes = np.array([1.0, 2.0, 3.0]), np.array([[0.1, 0.01], [0.09, 1e-9], [0.08, 0.02]])
    assert viz.harmonics(ax, x, amplitudes, layers=[(2.5, 3.5)]) is ax
    lines = {line.get_label(): line for line in ax.lines}
    assert np.array_equal(lines["harmonic 1"].get_xydata(), np.stack([x, amplitudes[:, 0]], axis=1))
    assert np.array_equal(lines["harmonic 2"].get_xydata(), [[1.0, 0.01], [3.0, 0.02]])
    assert (ax.get_yscale(), units(ax), len(ax.patches)) == ("log", ("x [m]", "amplitude [m]"), 1)
    viz.save(ax.figure, tmp_path / "harmonics.png")


def test_the_decay_stands_beside_what_is_expected(ax):
    x, amplitudes, line = [1.0, 2.0, 3.0], [0.1, 0.09, 0.08], (np.array([1.0, 3.0]), np.array([0.1, 0.08]))
    assert viz.decay(ax, x, amplitudes, {"expected": line}) is ax
    lines = {line.get_label(): line for line in ax.lines}
    assert np.array_equal(lines["harmonic 1"].get_xydata(), np.stack([x, amplitudes], axis=1))
    assert np.array_equal(lines["expected"].get_xydata(), np.stack(line, axis=1))
    assert (ax.get_yscale(), lines["expected"].get_linestyle()) == ("linear", "--")


def test_the_pareto_front_is_what_no_point_beats():
    cost, error = [1, 2, 2, 3, 4, 5, 0.5, 4], [9, 5, 4, 4, 3, 8, np.nan, 3]
    assert viz.pareto(cost, error) == [0, 2, 4]  # 3 is as good as 2 but dearer, 7 equals 4
    assert viz.pareto([], []) == []


def test_error_against_cost_has_every_row_and_the_front(ax):
    rows = [("a", 1, 0.1, "rk4"), ("b", 10, 0.2, "rk4"), ("c", 100, 0.01, "verlet"), ("crashed", 5, np.nan, "verlet")]
    points, front = viz.error_against_cost(ax, rows)
    assert {group: cloud.get_offsets().tolist() for group, cloud in points.items()} == {
        "rk4": [[1, 0.1], [10, 0.2]],
        "verlet": [[100, 0.01]],
    }
    assert np.array_equal(front.get_xydata(), [[1, 0.1], [100, 0.01]])
    assert front.get_drawstyle() == "steps-post"
    assert [text.get_text() for text in ax.texts] == ["a", "b", "c"]
    assert (units(ax), ax.get_xscale(), ax.get_yscale()) == (("cost [CPU s]", "error [-]"), "log", "log")


def test_labels_of_close_points_do_not_cover_each_other(ax):
    viz.error_against_cost(ax, [(f"dx = {k} mm", 1 + 0.03 * k, 0.1, "all") for k in range(3)] + [("far", 100, 1, "all")])
    boxes = [text.get_window_extent() for text in ax.texts]
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])


def test_legends_and_titles_stand_clear_of_data_and_of_each_other(ax, tmp_path):
    ax.set_title("seiche")
    viz.energy(ax, T, {f"run number {k}": T * k for k in range(9)})
    viz.save(ax.figure, tmp_path / "energy")
    panel, names, title = ax.get_window_extent(), ax.get_legend().get_window_extent(), ax.title.get_window_extent()
    assert panel.y1 <= names.y0 + 1
    assert names.y1 <= title.y0 + 1


def test_save_makes_folders_and_a_picture(tmp_path):
    figure, axes = viz.figure(2, 1, share_x=True)
    viz.energy(axes[0], T, {"total": T})
    viz.levels(axes[1], T, LEVELS, NAMES)
    path = viz.save(figure, tmp_path / "new" / "run-0.5")
    assert path == tmp_path / "new" / "run-0.5.png"
    assert path.read_bytes().startswith(b"\x89PNG")
    assert len(np.unique(imread(path).reshape(-1, 4), axis=0)) > 10
    assert (axes[0].get_xlabel(), axes[1].get_xlabel()) == ("", "t [s]")


def test_without_matplotlib_the_cure_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(SceneError, match="plots: matplotlib is not installed") as caught:
        viz.figure()
    assert caught.value.cure == "pip install 'parsph[plots]'"


def test_the_module_loads_nothing_heavy():
    code = "import sys, parsph.viz; print({'matplotlib', 'numba', 'scipy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "set()"
