"""Values in the tags of a deck."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement

Values = dict[str, object]


def put(parent: Element, values: Values) -> None:
    """Put a tag for each value into another, in this order."""
    for name, value in values.items():
        SubElement(parent, name).text = f"{value:.12g}" if isinstance(value, float) else str(value)


def listed(components: Iterable[float]) -> str:
    """Return the components of a vector or a matrix as FEBio reads them."""
    return ",".join(f"{value:.15g}" for value in components)
