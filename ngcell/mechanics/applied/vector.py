"""Vectors of loads that keep their direction: numbers, or a function of the place at rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import ngsolve
from pydantic import PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from ngcell.mechanics.space import DisplacementSpace
from ngcell.scene.entries import NUMBERS, check_dimension, is_number

#: Degrees that integrals of loads get besides those of displacements where loads depend on the place.
_EXTRA_DEGREES = 6


def _checked(value: Any) -> Any:
    if callable(value):
        return value
    if isinstance(value, (list, tuple)) and len(value) in (2, 3) and all(map(is_number, value)):
        return tuple(float(component) for component in value)
    raise PydanticCustomError("limit", "allowed: {numbers}", {"numbers": NUMBERS})


def _written(value: Any) -> Any:
    return f"not written: {getattr(value, '__qualname__', type(value).__qualname__)}" if callable(value) else value


#: Two numbers, or three for solids; from a script also a function that makes as many expressions of the coordinates x
#: and y (and z) at rest: sums, products, powers, and what NGSolve has for them, such as `ngsolve.sin`.
Vector = Annotated[
    tuple[float, ...] | Callable[..., tuple[Any, ...]],
    PlainValidator(_checked),
    PlainSerializer(_written, when_used="json"),
    WithJsonSchema({"type": "array", "prefixItems": [{"type": "number"}] * 2, "minItems": 2, "maxItems": 2}),
]


def check_vector(vector: Vector, place: str, dimension: int) -> None:
    """Raise CaseError if numbers, or expressions of a function, are not as many as bodies of this dimension need."""
    check_dimension(_components(vector, dimension), f"{place}: vector", dimension)


def work(
    vector: Vector, space: DisplacementSpace, displacement: ngsolve.CoefficientFunction
) -> ngsolve.CoefficientFunction:
    """Return the scalar product of the vector with the displacement."""
    first, *others = _components(vector, space.dimension)
    product = first * displacement[0]
    for axis, component in enumerate(others, start=1):
        product = product + component * displacement[axis]
    return product


def _components(vector: Vector, dimension: int) -> tuple[Any, ...]:
    return tuple(vector(*(ngsolve.x, ngsolve.y, ngsolve.z)[:dimension])) if callable(vector) else vector


def extra_degrees(vector: Vector) -> int:
    """Return the degrees that the integral needs besides those of the displacement."""
    return _EXTRA_DEGREES if callable(vector) else 0
