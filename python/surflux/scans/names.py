"""Names of columns in files: none takes the place of another."""

import itertools

# What points, normals and colours are called, channel by channel.
OWN = {"points": ("x", "y", "z"), "normals": ("nx", "ny", "nz"), "colors": ("red", "green", "blue")}


def scalars(columns, tidy=str, most=None, taken=()):
    """{name: (n,)} of columns: colours and what has three channels by channel, other rows by number.

    No column takes another's place: a name that is there already, among those of coordinates, normals and colours
    first of all, or those of `taken`, gets a number. tidy: makes a name what the format can hold; most: bytes of it.
    """
    owned = {name: names for name, names in OWN.items() if name in columns}
    out, taken = {}, {*taken, *itertools.chain(*owned.values())}
    for name, values in columns.items():
        if name in owned:
            out |= {one: values[:, k] for k, one in enumerate(owned[name])}
            continue
        wide = 1 if values.ndim == 1 else values.shape[1]
        ends = [""] if values.ndim == 1 else [f"_{c}" for c in ("rgb" if wide == 3 else range(wide))]
        for k, end in enumerate(ends):
            one = _free(tidy(str(name)), end, taken, most)
            taken.add(one)
            out[one] = values if values.ndim == 1 else values[:, k]
    return out


def _free(name, end, taken, most=None):
    """name + end, cut to so many bytes, with a number where it is taken."""
    for number in itertools.count(1):
        tail = end if number == 1 else f"_{number}{end}"
        room = None if most is None else most - len(tail.encode())
        head = name if room is None else name.encode()[:room].decode("utf-8", "ignore")
        if head + tail not in taken:
            return head + tail
    return None
