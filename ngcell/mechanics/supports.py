"""What is prescribed: supports, and the displacement they have at each load factor.

A support moves a boundary region by an affine map of the reference position, which grows in proportion to the load
factor. The *lifting* is where the load would take all bodies if they followed it like a sheet: it starts
minimisations, and centres those cells that nothing holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.resultants import weights_of_resultant
from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Support:
    """A boundary region with prescribed displacement ``load_factor * (gradient @ X + translation)``.

    Attributes
    ----------
    region : str
        Name of the boundary region, or a regular expression.
    gradient : array of float, shape (dimension, dimension)
        Displacement gradient at load factor 1, without unit.
    translation : array of float, shape (dimension,)
        Displacement of the origin at load factor 1 [length].
    components : tuple of bool
        Which components are prescribed; the others are free.
    """

    region: str
    gradient: Array
    translation: Array
    components: tuple[bool, ...] = (True, True)


class PrescribedMotion:
    """All supports of a scene.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    supports : sequence of Support
        The supports; where two meet, the later one counts.
    lifting : callable, optional
        Displacement at load factor 1 of reference positions, both of shape (dimension, n): the lifting inside the
        tissue. By default there is none, and bodies start where they were.
    """

    def __init__(
        self,
        space: DisplacementSpace,
        supports: Sequence[Support],
        lifting: Callable[[Array], Array] | None = None,
    ) -> None:
        self._space, self._weights = space, dict[str, Array]()
        self.supports = tuple(supports)
        self.fixed = np.zeros((space.dimension, space.size), dtype=bool)
        self._final = np.zeros((space.dimension, space.size))
        self._lifting = None if lifting is None else lifting(space.rest) * space.one
        for support in supports:
            unknowns = space.region_unknowns(support.region)
            motion = space.affine(np.asarray(support.gradient, float), np.asarray(support.translation, float))
            for axis in np.flatnonzero(support.components):
                self.fixed[axis, unknowns] = True
                self._final[axis, unknowns] = motion[axis, unknowns]

    @property
    def has_lifting(self) -> bool:
        """Whether the load determines a lifting."""
        return self._lifting is not None

    def imposed(self, displacement: Array, load_factor: float) -> Array:
        """Return a displacement with the prescribed values of this load factor in place."""
        moved = displacement.reshape(self.fixed.shape).copy()
        moved[self.fixed] = load_factor * self._final[self.fixed]
        return moved.ravel()

    def lifting(self, load_factor: float) -> Array:
        """Return the lifting at this load factor, shape (unknowns,)."""
        field = np.zeros(self.fixed.shape) if self._lifting is None else load_factor * self._lifting
        return self.imposed(field, load_factor)

    def rate(self, load_factor: float) -> Array:
        """Return the prescribed values' derivative by the load factor, shape (unknowns,); zero where nothing is."""
        return np.where(self.fixed, self._final, 0.0).ravel()

    def resultant(self, force: Array, region: str) -> Array:
        """Return the sum of nodal forces over a region, without those of supports beside it, shape (dimension,)."""
        if region not in self._weights:
            beside = [[one.region for one in self.supports if one.components[axis]] for axis in range(len(self.fixed))]
            self._weights[region] = np.array(
                [weights_of_resultant(self._space, region, "|".join(names)) for names in beside]
            )
        return np.asarray((force.reshape(self.fixed.shape) * self._weights[region]).sum(1))
