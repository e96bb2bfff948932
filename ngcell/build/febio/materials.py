"""The materials of a deck, and the directions of fibres in them.

FEBio's uncoupled "Mooney-Rivlin" is ``c1 (I1* - 3) + c2 (I2* - 3) + k/2 (ln J)^2``: its c1 and c2 are half of ours, its
k is the bulk modulus. Fibres join it in a "solid mixture", which adds stresses: that of "fiber-exp-pow", of the whole
stretch and in tension only, is ours with beta = 2, its ksi our k1 and its alpha our k2. Each element has its axes: the
first is the wall's direction, the third that of the cell, and a fibre of angle a is ``(cos a, 0, sin a)`` in them.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ngcell.build.febio.deck import Deck
from ngcell.build.febio.elements import listed, put
from ngcell.build.febio.scope import fibres_of
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin


def put_materials(root: Element, deck: Deck) -> None:
    """Put all materials into a deck."""
    section = SubElement(root, "Material")
    for number, (name, law) in enumerate(deck.materials.items(), 1):
        fibres = fibres_of(law)
        kind = "Mooney-Rivlin" if fibres is None else "solid mixture"
        material = SubElement(section, "material", id=str(number), name=name, type=kind)
        if fibres is None:
            _put_solid(material, law)
            continue
        _put_solid(SubElement(material, "solid", type="Mooney-Rivlin"), law)
        for angle in fibres.radians:
            family = SubElement(material, "solid", type="fiber-exp-pow")
            put(family, {"alpha": fibres.exponent_or_zero, "beta": 2, "ksi": fibres.stiffness})
            SubElement(family, "fiber", type="vector").text = listed((np.cos(angle), 0.0, np.sin(angle)))


def _put_solid(material: Element, law: MooneyRivlin) -> None:
    put(material, {"density": 1, "k": law.bulk_modulus, "pressure_model": "default"})
    put(material, {"c1": law.c1 / 2, "c2": law.c2 / 2})


def put_axes(root: Element, deck: Deck) -> None:
    """Put the axes of each element with fibres into a deck: the wall's direction, and the one across it."""
    if deck.directions is None:
        return
    section = SubElement(root, "MeshData")
    for name, (material, elements) in deck.parts.items():
        if fibres_of(deck.materials[material]) is None:
            continue
        axes = SubElement(section, "ElementData", type="mat_axis", elem_set=name)
        for number, (x, y) in enumerate(deck.directions[elements], 1):
            element = SubElement(axes, "e", lid=str(number))
            put(element, {"a": listed((x, y, 0.0)), "d": listed((-y, x, 0.0))})
