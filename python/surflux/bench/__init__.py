"""Measuring: seconds beside errors."""
