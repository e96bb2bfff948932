"""Values in the tags of a deck."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

Values = dict[str, object]


def put(parent: Element, values: Values) -> None:
    """Put a tag for each value into another, in this order."""
    for name, value in values.items():
        SubElement(parent, name).text = f"{value:.12g}" if isinstance(value, float) else str(value)
