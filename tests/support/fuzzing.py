"""Damage to files, the same on every machine: for tests that hold readers to taking or refusing any bytes."""

import copy
import json
import math
import random

WORDS = [b"999999999999", b"-1", b"nan", b"inf", b"1e308", b"1e999", b"1e-320", b"null", b"{}", b"[]", b"true", b'"a"']
WORDS += [b"\xff\xff\xff\xff", b"\0\0\xc0\x7f", b"\0\0\x80\x7f", b"\xff\xff\x7f\x7f", b"Infinity", b"9" * 5000]
WORDS += [
    b"[" * 5000,
    b'comment surflux {"solution":1}\n',
    b"\n",
    b" ",
    b"\0",
    b"property float nx\n",
    b"radius",
    b"red",
]
NUMBERS = [0, -1, 1, 2, 1e308, -1e308, 1e-308, math.nan, math.inf, -math.inf, 10**9, 10**12, 2**63, 2**64, -(2**63)]
NUMBERS += [10**400, 0.5, 1e-12, 1e12, 1e30, [], [1], [1, 2], [0, 0, 0], [1, 2, 3, 4], [math.nan] * 3, [1e200] * 3]
NUMBERS += [[1e-200] * 3, [[1, 2, 3], [1, 2, 3]], [[1, 2, 3], [1, 2]]]
VALUES = [
    "",
    "x",
    "\0",
    "${NO_SUCH_NAME}",
    "..",
    "/dev/zero",
    "cloud.ply",
    "sky.hdr",
    "box",
    "sphere",
    "mesh",
    "surfels",
]
VALUES += [True, False, {}, [{}], ["a", "b", "c"], [True, False, True]]
# TOML that no value in Python writes: dates, deep nesting, numbers of thousands of digits.
RAW = ["1979-05-27", "07:32:00", "[" * 200 + "]" * 200, "[" * 5000 + "]" * 5000, "9" * 5000, "0x" + "f" * 400, "1e400"]


def damaged(data, seed):
    """data with one to four bytes or pieces changed, most of them behind the header of a PLY file."""
    choose = random.Random(seed)
    data = bytearray(data)
    for _ in range(choose.randint(1, 4)):
        begin = data.find(b"end_header") + 11
        described = data.find(b"surflux {")
        if choose.random() < 0.3 or not 11 <= begin < len(data):
            begin = 0
        at = choose.randrange(begin, len(data)) if data else 0
        if described > 0 and choose.random() < 0.3:
            at = choose.randrange(described, min(described + 600, len(data)))
        kind = choose.randrange(8)
        if kind < 2 and data:
            data[at] = choose.randrange(256)
        elif kind == 2 and data:
            data[at] ^= 1 << choose.randrange(8)
        elif kind == 3:
            del data[at : at + choose.randint(1, 8)]
        elif kind == 4 and choose.random() < 0.3:
            del data[at:]
        elif kind == 5:
            data[at:at] = data[at : at + choose.randint(1, 60)]  # twice: a line, a key
        else:
            word = choose.choice(WORDS)
            data[at : at + choose.choice((0, len(word)))] = word
    return bytes(data)


def damaged_scene(tables, seed):
    """Bytes of a TOML file: tables with values of other kinds, keys too many or too few, or bytes changed."""
    choose = random.Random(seed)
    tables = copy.deepcopy(tables)
    for key in ("object", "light"):
        tables[key] = choose.sample(tables[key], 1)
    for _ in range(choose.choice((1, 1, 2))):
        *path, last = choose.choice([path for path in _paths(tables) if path])
        table = tables
        for key in path:
            table = table[key]
        kind = choose.randrange(10)
        if kind < 4:
            table[last] = choose.choice(NUMBERS)
        elif kind < 6:
            table[last] = choose.choice(VALUES)
        elif kind < 7:
            table[last] = _Raw(choose.choice(RAW))
        elif kind < 8:
            del table[last]
        elif isinstance(table, dict):
            names = [
                "points",
                "thin",
                "orient",
                "kind",
                "patch_area",
                "walls",
                "patches",
                "file",
                "shape",
                "image",
                "scale",
                "no",
            ]
            table[choose.choice(names)] = choose.choice(NUMBERS + VALUES)
    text = "".join(f"{json.dumps(key)} = {_toml(value)}\n" for key, value in tables.items()).encode()
    return damaged(text, seed) if choose.random() < 0.2 else text


class _Raw(str):
    pass


def _paths(value, path=()):
    yield path
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from _paths(value[key], (*path, key))


def _toml(value):
    if isinstance(value, _Raw):
        return str(value)
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_toml(entry)}" for key, entry in value.items()) + "}"
    return json.dumps(value) if isinstance(value, (bool, str)) else repr(value)  # inf and nan as TOML has them
