"""Functions of arrays that know no class: areas, normals and radii, orientation, groups."""
