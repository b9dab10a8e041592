"""Figures that pages quote from data/figures, what `surflux bench --site data/figures` measured.

python tests/support/quoted_figures.py    writes the tables in README.md and python/guide/*.md anew

A table stands between `<!-- figures: NAME -->` and `<!-- end of figures -->`. A number in a sentence has its place in
NAME.json behind it: `1.2 s<!-- = cases / statues / seconds -->`, a row by its first columns, as many as tell it from
others (`three spheres, rays, error, 0.02`), a column or a part of one (`stages.NAME`, `errors.0`). Numbers before a %
are hundredths, unless the column is in per cent; signs are left to the sentence.
"""

import json
import re
import sys
from itertools import accumulate
from pathlib import Path

from surflux.bench import site

ROOT = Path(__file__).parents[2]
FIGURES = ROOT / "data" / "figures"
PAGES = [ROOT / "README.md", *sorted((ROOT / "python" / "guide").glob("*.md"))]
BLOCK = re.compile(r"(<!-- figures: (\w+) -->\n).*?(\n<!-- end of figures -->)", re.DOTALL)
NUMBER = r"(?:\d[\d ]*)?(?:(?<=\d)|(?=\.\d))(?:\.\d+)?(?:e-?\d+)?"
UNIT = r"%|[mnu]?s|[kMG]B|bytes|points/s|dB|times|spacings|kWh/m²"
# What reads as measured: a number with a unit of these, or an exponent below 0.
FIGURE = re.compile(rf"(?<![\w.])({NUMBER} ?(?:{UNIT})|\d[\d.]*e-\d+)(?![\w/])(<!-- = )?")
CODE = re.compile(r"```.*?\n```|`[^`]*`", re.DOTALL)
QUOTE = re.compile(rf"(?<![\w.])({NUMBER})( ?%| ?[\w/]+)?<!-- = (.+?) / (.+?) / (.+?) -->")


def found(name):
    return json.loads((FIGURES / f"{name}.json").read_text())


def with_tables(page):
    """The text of a page with every table as it is in data/figures."""
    return BLOCK.sub(lambda block: block[1] + site.text(block[2], found(block[2])) + block[3], page)


def value(name, row, column):
    """A figure by its place."""
    rows = [r for r in found(name)["rows"] if row in accumulate(map(str, r.values()), "{}, {}".format)]
    if len(rows) != 1:
        raise ValueError(f"data/figures/{name}.json: wanted one row {row!r}, found {len(rows)}")
    value = rows[0]
    for part in [column] if column in value else column.split("."):
        value = value[int(part) if isinstance(value, list) else part]
    return value


def wrong_quotes(page):
    """Of the quotes in a page's text those that are not the figure rounded to as many digits, in words."""
    wrong = []
    for number, unit, name, row, column in QUOTE.findall(page):
        measured = abs(value(name, row, column)) * (100.0 if unit.strip() == "%" and "%" not in column else 1.0)
        shown = float(number.replace(" ", ""))
        digits = re.search(r"\.(\d+)", number)
        step = 10.0 ** -(len(digits[1]) if digits else 0)
        if "e" in number:
            step *= 10.0 ** int(number.split("e")[1])
        elif shown >= 1000:  # 25 000 is rounded to thousands
            step = 10.0 ** (len(str(int(shown))) - len(str(int(shown)).rstrip("0")))
        if abs(measured - shown) > 0.5000001 * step:
            wrong.append(f"{number.strip()}{unit}: {name} / {row} / {column} is {measured:.4g}")
    return wrong


def untied(page):
    """Numbers of a page's text that read as measured, and have no place in data/figures behind them; not those of code
    and of tables from there."""
    text = CODE.sub("``", BLOCK.sub("", page))
    return {figure for figure, tied in FIGURE.findall(text) if not tied}


def main():
    for page in PAGES:
        text = page.read_text()
        if with_tables(text) != text:
            page.write_text(with_tables(text))
            print(f"tables written: {page.relative_to(ROOT)}")
    for page in PAGES:
        for line in wrong_quotes(page.read_text()):
            print(f"{page.relative_to(ROOT)}: {line}", file=sys.stderr)


if __name__ == "__main__":
    main()
