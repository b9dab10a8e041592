"""Surfels, read and written."""
