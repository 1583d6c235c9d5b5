"""The registry of validation cases."""

CASES = {}


def case(function):
    """Register `function` as the case of its name; it takes `quick` and yields (metric, value, unit, bar)."""
    CASES[function.__name__.replace("_", "-")] = function
    return function
