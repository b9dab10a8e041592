"""Surfels on the screen: colours, glyphs, plots, the window that inspects areas."""
