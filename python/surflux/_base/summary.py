"""What a notebook shows of an object: a small table."""

import html

_CELL = ' style="text-align: left"'  # Jupyter sets cells of tables to the right


def html_table(title, rows):
    """A table of (name, text) under a title, all of it escaped: names come from users and files."""
    lines = [f'<tr><th{_CELL} colspan="2">{html.escape(title)}</th></tr>']
    lines += [f"<tr><td{_CELL}>{html.escape(name)}</td><td{_CELL}>{html.escape(text)}</td></tr>" for name, text in rows]
    return "<table>\n" + "\n".join(lines) + "\n</table>"


def box_text(bounds):
    """Bounds (2, 3) as text: each axis from least to largest."""
    return ", ".join(f"{axis} {low:.9g} to {high:.9g}" for axis, low, high in zip("xyz", *bounds, strict=True))


def range_text(values):
    """Least and largest of some numbers, as text."""
    low, high = values.min(), values.max()
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
