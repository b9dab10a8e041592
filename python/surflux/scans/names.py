"""Names of columns in files: none takes the place of another."""

import itertools

from surflux._base.check import listed
from surflux._base.warn import warn

_SHOWN = 6  # names in a warning

# What points, normals and colours are called, channel by channel.
OWN = {"points": ("x", "y", "z"), "normals": ("nx", "ny", "nz"), "colors": ("red", "green", "blue")}


def scalars(path, columns, tidy=str, most=None, taken=(), told=()):
    """{name: (n,)} of columns: colours and what has three channels by channel, other rows by number.

    No column takes another's place: a name that is there already, among those of coordinates, normals and colours
    first of all, or those of `taken`, gets a number, and a warning says which, but for those of `told`. tidy: makes a
    name what the format can hold; most: bytes of it.
    """
    owned = {name: names for name, names in OWN.items() if name in columns}
    out, names = {}, Names(path, {*taken, *itertools.chain(*owned.values())}, tidy, most, told)
    for name, values in columns.items():
        if name in owned:
            out |= {one: values[:, k] for k, one in enumerate(owned[name])}
            continue
        wide = 1 if values.ndim == 1 else values.shape[1]
        ends = [""] if values.ndim == 1 else [f"_{c}" for c in ("rgb" if wide == 3 else range(wide))]
        for k, end in enumerate(ends):
            out[names.free(name, end)] = values if values.ndim == 1 else values[:, k]
    names.warn_of_others()
    return out


class Names:
    """Names under which columns stand in a file, each of them once.

    path: of the file; taken: names that it has already; tidy, most, told: as of scalars.
    """

    def __init__(self, path, taken, tidy=str, most=None, told=()):
        self._path, self._taken, self._tidy, self._most = path, set(taken), tidy, most
        self._told, self._others = told, []

    def free(self, name, end=""):
        """The name + end, tidied, cut to so many bytes, with a number where it is taken; it is taken then."""
        one = _free(self._tidy(str(name)), end, self._taken, self._most)
        self._taken.add(one)
        if one != f"{name}{end}" and name not in self._told:
            self._others.append(f"{name}{end} as {one}")
        return one

    def warn_of_others(self):
        """Warns of columns whose names there are not their own."""
        if self._others:
            warn(f"{self._path}: columns have other names there: {listed(self._others, _SHOWN)}")


def _free(name, end, taken, most=None):
    """name + end, cut to so many bytes, with a number where it is taken."""
    for number in itertools.count(1):
        tail = end if number == 1 else f"_{number}{end}"
        room = None if most is None else most - len(tail.encode())
        head = name if room is None else name.encode()[:room].decode("utf-8", "ignore")
        if head + tail not in taken:
            return head + tail
    return None
