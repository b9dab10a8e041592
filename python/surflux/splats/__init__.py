"""Gaussians, as 3D Gaussian splatting draws them: baked from solutions, as PLY and glTF."""
