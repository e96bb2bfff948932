"""The motion of a block between plates that keeps its volume: what the lifting is where lumens are filled.

A block between plates that hold it barrels when they approach, and necks when they part. With the share t of the height
in [0, 1], the distance H of the plates at rest and the n lateral axes along which it is free, sections move rigidly
along y and stretch alike in themselves by a parabola, which is 1 on both plates (the motion by which Gent and Lindley
describe bonded blocks):

    x' = x_c + s(t) (x - x_c),    s(t) = 1 + 4 b t (1 - t),    dy'/dy = s(t)^-n

so that the determinant of the deformation gradient is 1 everywhere. The barrelling b > -1 follows from where the
plates go:

    int_0^1 s(t)^-n dt = (H + rise) / H

The left side falls from infinity to 0 as b grows from -1, so that there is one b for all plates that do not pass each
other; for plates that keep their distance it is 0.

References
----------
Gent, Lindley, The compression of bonded rubber blocks, Proc. Inst. Mech. Eng. 173, 1959, 111-122,
doi:10.1243/PIME_PROC_1959_173_022_02.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support

Array = NDArray[np.float64]

#: Logarithms of b + 1 between which the barrelling is looked for: plates nearer together, and farther, than any go.
_RANGE = (-30.0, 30.0)


@dataclass(frozen=True)
class Barrel:
    """A block whose sections stretch by a parabola and keep its volume.

    Attributes
    ----------
    size : float
        The barrelling b, > -1: how much further than at rest the section midway between the plates reaches, as a share.
    axes : int
        Along how many lateral axes sections stretch, 1 or 2.
    """

    size: float
    axes: int

    @classmethod
    def of_plates(cls, stretch: float, axes: int) -> Barrel:
        """Return the barrelling of a block whose plates are this many times their distance at rest apart, > 0."""
        if stretch == 1.0:
            return cls(0.0, axes)
        from scipy.optimize import brentq  # few runs need it, and it loads much of scipy

        def missed(log: float) -> float:
            return float(np.log(cls(float(np.expm1(log)), axes).height(np.ones(1))[0] / stretch))

        return cls(float(np.expm1(brentq(missed, *_RANGE, xtol=1e-14))), axes)

    def stretch(self, share: Array) -> Array:
        """Return the lateral stretch of sections at these shares of the height in [0, 1], shape (n,)."""
        return np.asarray(1 + 4 * self.size * share * (1 - share))

    def height(self, share: Array) -> Array:
        """Return where sections go along y, in heights at rest above the lower plate, shape (n,)."""
        if self.size == 0:
            return share
        middle = 1 + self.size
        # With z = 2 t - 1 the stretch is middle - size z^2.
        below, here = (self._antiderivative(z, middle) for z in (np.full_like(share, -1.0), 2 * share - 1))
        return np.asarray((here - below) / 2)

    def _antiderivative(self, z: Array, middle: float) -> Array:
        """Return an antiderivative in z of ``(middle - size z**2)**-axes``, shape (n,)."""
        ratio = np.sqrt(abs(self.size) / middle)
        inverse = np.arctanh(ratio * z) if self.size > 0 else np.arctan(ratio * z)
        simple = inverse / (ratio * middle)
        if self.axes == 1:
            return np.asarray(simple)
        return np.asarray((z / (middle - self.size * z**2) + simple) / (2 * middle))


class BarrellingMotion(PrescribedMotion):
    """Plates move rigidly; in between, the lifting barrels or necks so that it keeps the volume.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    supports : sequence of Support
        The supports; where two meet, the later one counts.
    plates : tuple of float
        Heights of the lower and the upper plate at rest [length].
    moved : array of float, shape (dimension,)
        Displacement of the upper plate at load factor 1 [length].
    centre : mapping of int to float
        The lateral axes along which the block is free, and what stays in place along each [length]; one or two.
    """

    def __init__(
        self,
        space: DisplacementSpace,
        supports: Sequence[Support],
        *,
        plates: tuple[float, float],
        moved: Array,
        centre: Mapping[int, float],
    ) -> None:
        self._plates, self._moved, self._centre = plates, moved, dict(centre)
        super().__init__(space, supports, lambda at: self.followed(at, 1.0))

    def lifting(self, load_factor: float) -> Array:
        """Return the lifting at this load factor, shape (unknowns,)."""
        return self.imposed(self.followed(self._space.rest, load_factor) * self._space.one, load_factor)

    def followed(self, at: Array, load_factor: float) -> Array:
        """Return the displacement of reference positions, both of shape (dimension, n)."""
        (lower, upper), moved = self._plates, load_factor * self._moved
        height = upper - lower
        share = np.clip((at[1] - lower) / height, 0, 1)
        barrel = Barrel.of_plates(1 + moved[1] / height, len(self._centre))
        displacement = moved[:, None] * share
        displacement[1] = height * (barrel.height(share) - share)
        for axis, middle in self._centre.items():
            displacement[axis] += (barrel.stretch(share) - 1) * (at[axis] - middle)
        return np.asarray(displacement)
