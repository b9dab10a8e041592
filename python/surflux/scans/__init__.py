"""Files of points, as columns."""
