"""Cameras, image files and animations."""
