"""The options of solve() that scenes and scene files may carry."""

from collections.abc import Mapping

from surflux._base import check


def _count_or_none(name, value):
    return None if value is None else check.count(name, value)


def _bytes_or_none(name, value):
    return None if value is None else check.number(name, value, 0.0, low_open=True)


def _share(name, value):
    return check.number(name, value, 0.0, 1.0, low_open=True, high_open=True)


def most_surfels(max_surfels, insert, count):
    """max_surfels for a scene of `count` surfels, 0 for None."""
    if max_surfels is None:
        return 0
    if check.count("max_surfels", max_surfels) < count and insert:
        raise ValueError(f"max_surfels: wanted at least the {count} surfels of the scene, got {max_surfels}")
    return max_surfels


def shadow_options(probes, shadow_rays):
    """{"probes", "shadow_rays"}, checked."""
    options = {"probes": check.count("probes", probes), "shadow_rays": check.count("shadow_rays", shadow_rays)}
    if shadow_rays < probes:
        raise ValueError(f"shadow_rays: wanted at least the {probes} probes, got {shadow_rays}")
    return options


TRANSPORTS = ("auto", "pairs", "rays")

# What solve() chooses by itself where an error or a time is asked for.
CHOSEN = ("zeta", "rays", "probes", "shadow_rays")
ASKED = ("error", "seconds")

# Every keyword of solve() but those that belong to a run and not to a scene: cluster, checkpoint, threads, progress.
_CHECKS = {
    "error": _share,
    "seconds": lambda name, value: check.number(name, value, 0.0, low_open=True),
    "transport": lambda name, value: check.choice(name, value, TRANSPORTS),
    "zeta": lambda name, value: check.number(name, value, 0.0, low_open=True),
    "insert": check.flag,
    "tolerance": _share,
    "max_surfels": _count_or_none,
    "rays": lambda name, value: check.count(name, value, 16, 65535),
    "probes": check.count,
    "shadow_rays": check.count,
    "epsilon": _share,
    "max_memory": _bytes_or_none,
    "seed": check.seed,
}
OPTIONS = tuple(_CHECKS)


def check_options(options):
    """Refuses, by a ValueError that begins with the name, what solve() would refuse."""
    for name, value in options.items():
        if name not in _CHECKS:
            raise ValueError(f"{name}: is not an option of solve; there is {', '.join(OPTIONS)}")
        _CHECKS[name](name, value)
    shadow_options(options.get("probes", 16), options.get("shadow_rays", 64))
    for asked in ASKED:
        for name in CHOSEN:
            if asked in options and name in options:
                raise ValueError(f"{name}: is chosen where {asked} is given; wanted one of the two")


def checked_solve_options(options):
    """A dict of the options for solve() by name; None for none. Errors name solve_options."""
    options = {} if options is None else options
    if not (isinstance(options, Mapping) and all(isinstance(key, str) for key in options)):
        raise ValueError(f"solve_options: wanted a dict with names as keys, got {options!r}")
    try:
        check_options(options)
    except ValueError as error:
        raise ValueError(f"solve_options: {error}") from None
    return dict(options)
