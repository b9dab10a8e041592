"""Windows and pages that show surfels, scenes and solutions."""
