"""A tissue from polygons of one's own: four square cells, moved together as plates press on them."""

import numpy as np
import pytest

from ngcell import BodyScene, BodySupport, MooneyRivlin, PolygonTissue, simulate

squares = [[(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)] for y in (0, 1) for x in (0, 1)]
cells = PolygonTissue(squares, wall=0.1).bodies(MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=100.0))
for number, body in enumerate(cells):
    for edge in body.shape.edges:
        if abs(edge.center.y - 2 * (number // 2)) < 1e-9:
            edge.name = "floor" if number < 2 else "roof"
supports = (BodySupport("floor"), BodySupport("roof", translation=(0.0, -0.05)))
*_, last = simulate(BodyScene(cells, supports, size=0.5, order=2, levels=1))
# Balance of a cut between the rows.
across = sum(wall.force for wall in last.walls if wall.cell_b - wall.cell_a == 2)
assert across == pytest.approx(np.hypot(last.record.plate_force_x, last.record.plate_force_y), rel=1e-4)
