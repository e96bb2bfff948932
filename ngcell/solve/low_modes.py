"""The low modes of each body: how its walls move and bend at the least energy.

They are found for all bodies at once by inverse iteration in a subspace of each body (Bathe and Wilson, Int. J. Numer.
Meth. Eng. 6, 1973, doi:10.1002/nme.1620060207): as bodies have nothing in common but constraints, a solution with the
matrix without these serves one mode of every body.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.linear import SymmetricMatrix

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Share of the largest size of a vector in a subspace below which another one is nothing but round-off.
_NOTHING = 1e-14


class LowModes:
    """Modes of bodies; bodies of few unknowns have none.

    Parameters
    ----------
    free : array of bool, shape (unknowns,)
        Unknowns that may move.
    part : array of int, shape (unknowns,)
        Body of each unknown.
    walls : array of bool, shape (unknowns,)
        Unknowns by which modes are measured: the size of a vector is that of these. Soft fillings have many modes that
        are of no use, since no wall moves in them.
    count : int
        Number of modes of a body.

    Attributes
    ----------
    energies : array of float, shape (bodies, modes)
        Twice the energy of each mode of unit size; 0 where there is none.
    """

    def __init__(self, free: Mask, part: Index, walls: Mask, count: int) -> None:
        self._size, self._count = len(free), count
        bodies = int(part.max(initial=-1)) + 1
        room = np.bincount(part, free, bodies).astype(np.int64)
        self._has_modes = np.bincount(part, free & walls, bodies) >= 4 * count
        mine = np.flatnonzero(free & self._has_modes[part])
        mine = mine[np.argsort(part[mine], kind="stable")]
        owner = part[mine]
        place = np.arange(len(mine)) - np.searchsorted(owner, owner)
        # Rows of bodies with fewer unknowns than others are filled up by one beyond the last.
        self._unknown = np.full((bodies, int(room.max(initial=0))), self._size)
        self._unknown[owner, place] = mine
        self._is_wall = np.append(walls, False)[self._unknown][..., None]
        self.energies = np.zeros((bodies, count))
        self.forget()

    @property
    def is_mode(self) -> Mask:
        """Which of all bodies' modes there are, shape (bodies times modes,)."""
        return np.repeat(self._has_modes, self._count)

    def forget(self) -> None:
        """Begin anew."""
        start = np.random.default_rng(0).standard_normal((self._size + 1, self._count))
        start[-1] = 0.0
        self._modes = start[self._unknown]

    def iterate(self, matrix: SymmetricMatrix, values: Array, steps: int) -> bool:
        """Take so many steps of inverse iteration with a matrix of these values, which couples no two bodies.

        It begins anew, and returns False, where the matrix has no inverse, or next to none.
        """
        matrix.factorise(values)
        for _ in range(steps):
            before, solved = self._modes * self._is_wall, np.zeros((self._size + 1, self._count))
            for number, mode in enumerate(self._vectors(before).T):
                solved[:-1, number] = matrix.solve(mode)
            self._modes = solved[self._unknown]
            if not (np.isfinite(solved).all() and self._separate(before)):
                self.forget()
                return False
        return True

    @np.errstate(all="ignore")  # what is not finite is told
    def _separate(self, before: Array) -> bool:
        """Let modes be the best ones of each body's subspace, of unit size, the lowest one first (Rayleigh-Ritz).

        Where they are not finite, or no wall moves in them, it returns False.
        """
        turned = self._modes.transpose(0, 2, 1)
        size, energy = turned @ (self._modes * self._is_wall), turned @ before
        if not np.isfinite(size).all():
            return False
        share, axes = np.linalg.eigh(size)
        share = np.where(self._has_modes[:, None], np.maximum(share, _NOTHING * share[:, -1:]), 1.0)
        to_unit = axes / np.sqrt(share)[:, None, :]
        among = to_unit.transpose(0, 2, 1) @ energy @ to_unit
        if not np.isfinite(among).all():
            return False
        self.energies, turn = np.linalg.eigh((among + among.transpose(0, 2, 1)) / 2)
        self._modes = self._modes @ (to_unit @ turn)
        return True

    def _vectors(self, modes: Array) -> Array:
        """Return vectors of all unknowns, each with one mode of every body, shape (unknowns, modes)."""
        whole = np.zeros((self._size + 1, self._count))
        whole[self._unknown] = modes
        return whole[:-1]

    @property
    def basis(self) -> sparse.csr_array:
        """The modes of all bodies, shape (unknowns, bodies times modes), those of a body side by side."""
        bodies, count = self.energies.shape
        body = np.zeros(self._size + 1, dtype=np.int64)
        body[self._unknown] = np.arange(bodies)[:, None]
        column = (body[:-1, None] * count + np.arange(count)).astype(np.int32)
        pointer = np.arange(0, self._size * count + 1, count)
        shape = self._size, bodies * count
        return sparse.csr_array((self._vectors(self._modes).ravel(), column.ravel(), pointer), shape=shape)
