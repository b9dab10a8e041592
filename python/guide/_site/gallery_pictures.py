"""Pictures of the gallery: whatever PNG files an example has written into its folder, in the order of their writing."""

import shutil
from pathlib import Path

from sphinx_gallery.scrapers import figure_rst


def pictures(block, block_vars, gallery_conf):
    """The scraper that Sphinx-Gallery calls after each block of code: the picture's RST."""
    written = sorted(Path(block_vars["src_file"]).parent.glob("*.png"), key=lambda path: path.stat().st_mtime_ns)
    shown = []
    for path, place in zip(written, block_vars["image_path_iterator"], strict=False):
        shutil.move(path, place)
        shown.append(place)
    return figure_rst(shown, gallery_conf["src_dir"])
