"""
A first solve
=============

The Cornell box: light leaves the lamp, meets walls and blocks, takes their colour along, and goes on until it balances.
"""

import surflux as sf

scene = sf.examples.cornell_box()
solution = sf.solve(scene)
print(solution)  # its error, as the solver estimates it, and where the power goes
picture = solution.render(scene.camera, (480, 480), samples=2)
sf.write_image("cornell_box.png", picture)
