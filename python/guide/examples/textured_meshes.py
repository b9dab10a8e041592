"""
Textured meshes
===============

Light is found on patches of a few centimetres, each with the mean of its texture. Pictures show the texture itself,
under that light. The mesh is one of trimesh here; OBJ and glTF files bring their textures along.
"""

import numpy as np
import trimesh
from PIL import Image

import surflux as sf

draw = np.random.default_rng(3)
bricks = np.full((256, 256, 3), 200, np.uint8)  # joints, and eight rows of four bricks
for row in range(8):
    for x in range(-32 * (row % 2), 256, 64):
        bricks[32 * row + 2 : 32 * row + 30, max(x + 2, 0) : x + 62] = draw.integers(-30, 30) + np.array([170, 90, 65])
look = trimesh.visual.material.SimpleMaterial(image=Image.fromarray(bricks))
corners = np.array([[0, 0, 0], [4, 0, 0], [4, 0, 3], [0, 0, 3], [4, 4, 0], [4, 4, 3]], float)
wall = trimesh.Trimesh(corners, [[1, 0, 3], [1, 3, 2], [4, 1, 2], [4, 2, 5]], process=False)
wall.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [3, 0], [3, 3], [0, 3], [6, 0], [6, 3]], material=look)
floor = sf.Surfels.from_mesh(([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], [[0, 1, 2, 3]]), 0.02, 0.4)
lamp = sf.SpotLight([1.5, 2.2, 2.8], [0.8, -1, -0.6], 20, cone=110, penumbra=50)
solution = sf.solve(sf.Scene([sf.Surfels.from_mesh(wall, 0.02), floor], [lamp, sf.Environment(0.15)]))
sf.write_image("textured_meshes.png", solution.render(sf.Camera([0.6, 5, 1.8], [2.3, 0.6, 1.2]), (640, 480)))
