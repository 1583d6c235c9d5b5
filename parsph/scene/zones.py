"""From a scene's keys to its relaxation zones, and what can be wrong with these keys."""

from ..errors import SceneError
from ..relaxation import RelaxationZone
from .check_waves import broken, no_waves
from .movers import bed_of, place_of, ramp_of, speed_of_waves, wave_of

RATE = 40.0  # per period, at the end of the domain: enough for zones of half a wavelength


def rate_of(scene, zone):
    """Return the strength of a zone at the end of the domain [1/s]."""
    return zone.rate or RATE / _period(scene, zone)


def speed_of(scene, zone):
    """Return the speed of the waves [m/s] that a zone has to do with: its own, or the scene's, or long ones."""
    wave = zone.target(scene.depth, scene.domain.gravity)
    return wave.celerity if wave is not None else speed_of_waves(scene, _period(scene, zone))


def relaxation_of(scene, zone, state):
    """Return the `RelaxationZone` of a section; `state` is the equation of state."""
    left, wave = zone.side == "left", zone.target(scene.depth, scene.domain.gravity)
    return RelaxationZone(
        start=zone.length if left else scene.domain.size[0] - zone.length,
        direction=-1 if left else 1,
        length=zone.length,
        rate=rate_of(scene, zone),
        state=state.constants,
        wave=wave,
        ramp=ramp_of(zone, wave.period) if wave else 0.0,
        level=scene.level,
        bed=bed_of(scene),
        weight=scene.fluid.rho0 * scene.domain.gravity,
        margin=scene.reach,
        density_factor=(scene.c0 / speed_of(scene, zone)) ** 2 if zone.density == "matched" else 0.0,
    )


def relaxed_height(scene):
    """Return the height [m] of the waves that a zone at the left makes, None where there is none."""
    return next((zone.height for zone in scene.relaxation if zone.side == "left" and zone.height > 0), None)


def describe_zone(scene, zone):
    """Return what a zone does, and the source of it."""
    wave, parts = zone.target(scene.depth, scene.domain.gravity), [f"{zone.length:g} m"]
    if wave:
        parts[0] += f" ({zone.length / wave.wavelength:.2g} wavelengths)"
        parts.append(f"{zone.theory} waves of {wave.height:g} m, {wave.period:.4g} s, {wave.wavelength:.4g} m")
    else:
        parts.append("still water")
    what = "velocity" if zone.density == "none" else "velocity and density"
    parts.append(f"relaxes {what} by up to {rate_of(scene, zone):.3g} per s")
    return ", ".join(parts), "Mayer et al. (1998)"


def _period(scene, zone):
    """Return the period [s] of a zone's wave, or of the scene's waves where its target is still water; None without."""
    own = zone.own_period(scene.depth, scene.domain.gravity)
    return scene.wave_period if own is None else own


# --- what can be wrong -----------------------------------------------------------------------------------------------


def relaxation_faults(scene):
    """Return what is wrong with the relaxation zones, a list of SceneError."""
    if not scene.relaxation:
        return []
    lacking = no_waves(scene, "relaxation", "a relaxation zone", "there is no surface for its wave", "has no water to act on")
    if lacking:
        return lacking
    parts = [(number, zone, f"relaxation.{number}") for number, zone in enumerate(scene.relaxation)]
    faults = [fault for _, zone, where in parts for fault in _wave(scene, zone, where)]
    faults = faults or [fault for _, zone, where in parts for fault in _strength(scene, zone, where)]
    faults = faults or [fault for part in parts for fault in _place(scene, *part)]
    length = scene.domain.size[0]
    if not faults and sum(zone.length for zone in [*scene.relaxation, *scene.damping]) > length:
        cure = f"together with absorbing layers at most {length:g} m"
        faults.append(SceneError("the zones overlap", where="relaxation", cure=cure))
    return faults


def _wave(scene, zone, where):
    """Faults of the wave that a zone relaxes to."""
    named = [key for key in ("period", "frequency", "wavelength") if getattr(zone, key) is not None]
    if zone.height == 0 and not named:
        return []
    try:
        faults = broken(zone.height, wave_of(scene, zone), scene.depth, f"{where}.height")
        if not faults:
            zone.target(scene.depth, scene.domain.gravity)
    except SceneError as error:
        at = where if error.where == "wave" else f"{where}.{error.where}"
        return [SceneError(error.what, where=at, why=error.why, cure=error.cure)]
    return faults


def _strength(scene, zone, where):
    """Faults of what a zone does to the flow."""
    faults = []
    if zone.rate is None and _period(scene, zone) is None:
        why = "without waves there is no period that a default could go by"
        faults.append(SceneError("is missing", where=f"{where}.rate", why=why, cure="strength [1/s], or a period"))
    if zone.density == "matched" and scene.numerics.density == "summation":
        why = "densities are summed"
        faults.append(SceneError("has nothing to act on", where=f"{where}.density", why=why, cure='"none"'))
    return faults


def _place(scene, number, zone, where):
    """Faults of where a zone is."""
    faults, length, left = [], scene.domain.size[0], zone.side == "left"
    edge = zone.length if left else length - zone.length
    water = min(block.low[0] for block in scene.fluid.blocks), max(block.high[0] for block in scene.fluid.blocks)
    if zone.length >= length:
        cure = f"less than the domain's {length:g} m"
        faults.append(SceneError(f"{zone.length:g} m is too long", where=f"{where}.length", cure=cure))
    elif not (water[0] < edge if left else edge < water[1]):
        why = f"it ends at x = {edge:g} m, the water reaches from {water[0]:g} to {water[1]:g} m"
        faults.append(SceneError("the zone lies outside the fluid", where=where, why=why, cure="a longer one, or none"))
    if any(zone.side == other.side for other in scene.relaxation[:number]):
        faults.append(SceneError(f"a second zone at the {zone.side}", where=f"{where}.side", cure="one per side"))
    if any(zone.side == layer.side for layer in scene.damping):
        why = "a zone takes up what comes to it"
        cure = "one of the two"
        faults.append(SceneError(f"an absorbing layer at the {zone.side} too", where=f"{where}.side", why=why, cure=cure))
    plate = place_of(scene) if scene.wavemaker else None
    if zone.side in scene.moved_sides or (plate is not None and (plate < edge if left else plate > edge)):
        why = "the zone would take up what that makes"
        cure = "one of the two, or another side"
        faults.append(SceneError(f"a moving wall stands at the {zone.side}", where=f"{where}.side", why=why, cure=cure))
    return faults
