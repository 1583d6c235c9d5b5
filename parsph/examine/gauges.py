"""What level gauges say of the waves: heights, reflection, spectra, harmonics along the tank."""

import numpy as np

from .. import analysis, viz
from ..errors import SceneError
from ..io.results import Results
from ..progress import console
from ..scene.load import load_scene
from ..waves import viscosity_of_alpha, wavenumber
from .tables import draw, levels_of, show, show_all, wave_period


def waves(folder, gauges=None, start=0.0, json_file=None):
    """Print mean level, wave height, period and phase at each level gauge.

    Parameters
    ----------
    folder : path
        Of a run.
    gauges : list of str, optional
        Default: all level gauges.
    start : float
        What was before counts not [s].
    json_file : path, optional
        Where the rows go too.
    """
    t, levels, places, names = levels_of(Results(folder), gauges, start)
    rows = []
    for name, x, level in zip(names, places, levels, strict=True):
        found = analysis.wave_summary(t, level)
        rows.append(
            {
                "gauge": name,
                "x [m]": float(x),
                "mean level [m]": found.mean,
                "wave height [m]": found.height,
                "period [s]": found.period,
                "phase [rad]": found.phase,
                "waves": found.waves,
            }
        )
    show(rows, json_file)


def books(folder, json_file=None):
    """Print the energy books of a run: its energies at the beginning and at the end, and what took or gave the difference.

    Parameters
    ----------
    folder : path
        Of a run with a gauge of energy, of everything, and one of power.
    json_file : path, optional
        Where the rows go too.

    Raises
    ------
    SceneError
        When there are no such gauges.
    """
    results = Results(folder)
    whole = [name for name, keys in results.gauges("energy").items() if keys["low"] is None and keys["high"] is None]
    powers = list(results.gauges("power"))
    for names, keys in ((whole, 'kind = "energy" without low and high'), (powers, 'kind = "power"')):
        if not names:
            why, cure = "energy books need one", f"[[gauges]] {keys}, every = ... [s]"
            raise SceneError(f"the run had no gauge with {keys}", where=str(folder), why=why, cure=cure)
    energy, power = (np.stack(list(results.table(names[0]).values()), axis=1) for names in (whole, powers))
    found = analysis.energy_books(energy, power)
    entries = {
        "change of kinetic energy": found.kinetic[-1],
        "change of potential energy": found.potential[-1],
        "change of compressible energy": found.compressible[-1],
        "given by viscosity": found.viscosity[-1],
        "given by diffusion": found.diffusion[-1],
        "given by all else, walls included": found.rest[-1],
        "not accounted for": found.open[-1],
        "not accounted for, largest": np.abs(found.open).max(),
    }
    scale = np.ptp(energy[:, 2]) or 1.0
    rows = [
        {"entry": name, "J": float(value), "over range of kinetic": float(value / scale)} for name, value in entries.items()
    ]
    show(rows, json_file)


def reflection(folder, gauges=None, start=0.0, period=None, periods=4, spectrum=None, json_file=None):
    """Print incident and reflected waves.

    Parameters
    ----------
    folder, gauges, start, json_file
        As `waves`.
    period : float, optional
        [s]; default: the wavemaker's.
    periods : int
        So many at the end of the record count.
    spectrum : tuple of float, optional
        Lowest and highest frequency [Hz] of irregular waves, instead of a period.

    Raises
    ------
    SceneError
        When there is no period, or the gauges do not suit.
    """
    results = Results(folder)
    t, levels, places, _ = levels_of(results, gauges, start)
    depth, gravity = results.depth, results.scene["domain"]["gravity"]
    if spectrum:
        found = analysis.reflection_spectrum(t, levels, places, depth, gravity, *spectrum)
        rows = [
            {"frequency [Hz]": f, "incident [m]": a, "reflected [m]": b}
            for f, a, b in zip(found.frequency, found.incident, found.reflected, strict=True)
        ]
        rows.append({"frequency [Hz]": "all", **_energy_sum(found), "reflection coefficient": found.coefficient})
        show(rows, json_file)
        return
    period = wave_period(results, period, ", or --spectrum")
    method = "goda-suzuki" if len(places) == 2 else "mansard-funke"
    found = analysis.reflection(t, levels, places, period, depth, gravity, method, periods)
    row = {
        "gauges": len(places),
        "period [s]": period,
        "wavelength [m]": 2 * np.pi / found.wavenumber,
        "incident [m]": found.incident,
        "reflected [m]": found.reflected,
        "reflection coefficient": found.coefficient,
        "misfit": found.residual,
    }
    show([row], json_file)


def _energy_sum(found):
    return {f"{name} [m]": float(np.sqrt(np.sum(getattr(found, name) ** 2))) for name in ("incident", "reflected")}


def spectrum(folder, gauges=None, start=0.0, band=None, segments=None, json_file=None):
    """Print statistics of the waves and of their spectrum at each level gauge, and draw the spectra.

    Parameters
    ----------
    folder, gauges, start, json_file
        As `waves`.
    band : tuple of float, optional
        Lowest and highest frequency [Hz] of the spectrum; default: all.
    segments : int, optional
        Of `analysis.spectrum`.

    Raises
    ------
    SceneError
        When a record is too short, or the band none.
    """
    results = Results(folder)
    t, levels, places, names = levels_of(results, gauges, start)
    low, high = band or (None, None)
    rows, curves = [], {}
    for name, x, level in zip(names, places, levels, strict=True):
        try:
            found = analysis.statistics(t, level, low, high, segments)
            density = analysis.spectrum(t, level, low, high, segments)
        except SceneError as error:
            raise SceneError(error.what, f"gauge {name}, {error.where}", error.why, error.cure) from None
        row = {
            "gauge": name,
            "x [m]": float(x),
            "waves": found.waves,
            "H_m0 [m]": found.spectral_height,
            "H_1/3 [m]": found.significant_height,
            "H_1/10 [m]": found.tenth_height,
            "H_max [m]": found.largest_height,
            "H_mean [m]": found.mean_height,
            "T_p [s]": found.peak_period,
            "T_m-1,0 [s]": found.energy_period,
            "T_m01 [s]": found.first_moment_period,
            "T_m02 [s]": found.second_moment_period,
            "T_1/3 [s]": found.significant_period,
            "T_z [s]": found.mean_period,
        }
        rows.append({header: value for header, value in row.items() if value is not None})
        curves[f"{name}, x = {x:.3g} m"] = (density.frequency, density.density)
    show(rows, json_file)
    draw(results.folder / "figures" / "spectrum.png", lambda ax: viz.spectra(ax, curves))


def harmonics(folder, gauges=None, start=0.0, period=None, count=3, periods=4, json_file=None):
    """Print and draw the harmonics of regular waves along the tank, their free second harmonic, and their decay.

    Gauges in absorbing layers count neither for the second harmonic nor for the decay. Neither has a meaning for shallow water
    without dispersion.

    Parameters
    ----------
    folder, gauges, start, period, json_file
        As `reflection`.
    count : int
        Number of harmonics.
    periods : int
        So many at the end of the record count.

    Raises
    ------
    SceneError
        When there is no period, or the record is too short.
    """
    results = Results(folder)
    t, levels, x, names = levels_of(results, gauges, start)
    order = np.argsort(x, kind="stable")
    levels, x, names = levels[order], x[order], [names[k] for k in order]
    period = wave_period(results, period)
    amplitudes = analysis.harmonics_along(t, levels, x, period, count, periods)
    heights = np.abs(amplitudes)
    layers = [results.layer(zone) for zone in results.scene["damping"]]
    absorbed = np.any([(low < x) & (x < high) for low, high in layers], axis=0) if layers else np.zeros(x.size, bool)
    rows = []
    for name, place, row, inside in zip(names, x, heights, absorbed, strict=True):
        told = {f"a_{n} [m]": float(a) for n, a in enumerate(row, start=1)}
        rows.append({"gauge": name, "x [m]": float(place), **told, **({"where": "absorbing layer"} if inside else {})})
    tables, curves, notes = {"harmonics": rows}, {}, []
    if results.scene["numerics"]["state"] != "shallow":
        free = x[~absorbed]
        for title, measured in (("second harmonic", _second_harmonic), ("decay of the first harmonic", _decay)):
            try:
                row, drawn = measured(results, free, amplitudes[~absorbed], period)
            except SceneError as error:
                notes.append(f"no {title}: {error}")
                continue
            tables[title] = [row]
            curves |= drawn
    show_all(tables, json_file)
    for note in notes:
        console().print(note)

    def artist(axes):  # a decay of some per cent can be seen on an axis of its own only
        viz.decay(axes[0], x[~absorbed], heights[~absorbed, 0], curves)
        viz.harmonics(axes[1], x, heights, layers)

    draw(results.folder / "figures" / "harmonics.png", artist, rows=2)


def _second_harmonic(results, x, amplitudes, period):
    """Return (row, nothing to draw) of the second harmonic's parts."""
    if amplitudes.shape[1] < 2 or x.size < 4:
        why = "bound, free and reflected free wave take three gauges, and one more shows how well they fit"
        cure = "four level gauges or more outside of absorbing layers, and --count 2 or more"
        raise SceneError(f"of {x.size} gauge(s) and {amplitudes.shape[1]} harmonic(s)", where="gauges", why=why, cure=cure)
    depth, gravity = results.depth, results.scene["domain"]["gravity"]
    k, k_free = (wavenumber(2 * n * np.pi / period, depth, gravity) for n in (1, 2))
    found = analysis.second_harmonic(x, amplitudes[:, 1], 2 * k, k_free, reflected=True)
    row = {
        "gauges": int(x.size),
        "bound [m]": abs(found.bound),
        "free [m]": abs(found.free),
        "reflected free [m]": abs(found.reflected),
        "misfit [m]": found.residual,
        "beat length [m]": found.beat_length,
    }
    return row, {}


def _decay(results, x, amplitudes, period):
    """Return (row, {name: (x, amplitude)}) of the first harmonic's decay, fitted and expected."""
    scene = load_scene(results.scene)
    gravity, nu = scene.domain.gravity, _viscosity(scene)
    found = analysis.decay_along(x, amplitudes[:, 0])
    expected = analysis.expected_decay(period, results.depth, gravity, nu)
    wavelength = 2 * np.pi / wavenumber(2 * np.pi / period, results.depth, gravity)
    row = {
        "gauges": int(x.size),
        "wavelength [m]": wavelength,
        "decay [1/m]": found.rate,
        "standard error [1/m]": found.error,
        "expected [1/m]": expected,
        "viscosity [m^2/s]": nu,
        "decay [% a wavelength]": 100 * float(-np.expm1(-found.rate * wavelength)),
        "expected [% a wavelength]": 100 * float(-np.expm1(-expected * wavelength)),
    }
    line = np.linspace(x[0], x[-1], 50)
    theory = found.at(x[0]) * np.exp(-expected * (line - x[0]))
    return row, {"fitted decay": (line, found.at(line)), "expected by viscosity": (line, theory)}


def _viscosity(scene):
    """Return the kinematic viscosity [m^2/s] that a scene's momentum equation has, 0.0 for none."""
    numerics = scene.numerics
    if numerics.viscosity == "monaghan":
        return viscosity_of_alpha(numerics.alpha, scene.h, scene.c0, scene.dim)
    return numerics.nu if numerics.viscosity == "newtonian" else 0.0
