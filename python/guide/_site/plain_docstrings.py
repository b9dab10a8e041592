"""Docstrings as Sphinx reads them: ours are plain text, of which reStructuredText takes some marks amiss."""

import re

import surflux as sf

# Code between backquotes stays; elsewhere these characters would begin emphasis, substitutions and references.
_CODE = re.compile(r"(`+[^`]+`+)")
_MARKS = re.compile(r"(?<!\\)[*|]|(?<=\w)_(?!\w)")


def public_names_stand_in_the_face():
    """Whatever surflux exports calls itself surflux.NAME, as users write it, also in signatures."""
    for name in sf.__all__:
        item = getattr(sf, name)
        if getattr(item, "__module__", None):
            item.__module__ = "surflux"


def escape(app, what, name, item, options, lines):
    """For autodoc-process-docstring, before napoleon: escapes marks outside of code and examples."""
    for number, line in enumerate(lines):
        if line.lstrip().startswith((">>>", "...")):
            continue
        parts = _CODE.split(line)
        parts[::2] = [_MARKS.sub(r"\\\g<0>", part) for part in parts[::2]]
        lines[number] = "".join(parts)
    if what == "property":
        lines.insert(0, "")  # or napoleon takes what stands before a colon for a type
