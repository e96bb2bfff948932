"""A deck as the XML text of FEBio 4 (`febio_spec` 4.0).

FEBio's faces are seen from outside, and a pressure > 0 presses into the body. Time is 0 to 1 while the supports move,
and, where walls are tied first, 1 to 2 while they are released. A "volume" constraint keeps what its surface integral
makes of the sides of a lumen alone, without a bottom and a lid: two thirds of the volume.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray

from ngcell.build.febio.deck import TIE, Deck, Pair
from ngcell.build.febio.elements import listed, put
from ngcell.build.febio.materials import put_axes, put_materials
from ngcell.build.febio.scope import SILENT
from ngcell.mechanics.supports import Support

Index = NDArray[np.int64]

#: Increments of each step, and by how much they may shrink.
_INCREMENTS, _SMALLEST = 20, 1e-4
#: Load curves: that of the supports, and that of pressures.
_MOVES, _PRESSES = "1", "2"
#: Change of the pressure in a lumen, as a share of itself, at which its multiplier is found.
_KEPT = 0.01


def deck_text(deck: Deck) -> str:
    """Return the text of a deck."""
    root = Element("febio_spec", version="4.0")
    thickness = f"{deck.layer.thickness:.9g}"
    told = (f"{deck.title}", f"one layer of thickness {thickness}; forces are for that thickness", *SILENT)
    root.append(Comment(" " + "; ".join(told).replace("--", "-") + " "))
    SubElement(root, "Module", type="solid")
    put_materials(root, deck)
    _mesh(root, deck)
    domains = SubElement(root, "MeshDomains")
    for name, (material, _) in deck.parts.items():
        SubElement(domains, "SolidDomain", name=name, mat=material)
    put_axes(root, deck)
    _boundary(root, deck)
    if deck.pressures:
        _loads(root, deck)
    if deck.fluids:
        _constraints(root, deck)
    _steps(root, deck)
    _curves(root, deck)
    _output(root, deck)
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _mesh(root: Element, deck: Deck) -> None:
    mesh, layer = SubElement(root, "Mesh"), deck.layer
    nodes = SubElement(mesh, "Nodes", name="tissue")
    for number, place in enumerate(layer.nodes, 1):
        SubElement(nodes, "node", id=str(number)).text = listed(place)
    number = 0
    for name, (_, elements) in deck.parts.items():
        part = SubElement(mesh, "Elements", type="hex20", name=name)
        for element in elements:
            number += 1
            SubElement(part, "elem", id=str(number)).text = _listed(layer.elements[element])
    _node_set(mesh, "in-plane", _in_plane(deck))
    for support, held in deck.supports:
        _node_set(mesh, support.region, held)
    for name, edges in deck.outlines.items():
        _surface(mesh, deck, f"{name}-outline", edges)
    for pair in deck.pairs:
        for mine, other, edges in zip(pair.names, pair.names[::-1], pair.edges, strict=True):
            _surface(mesh, deck, f"{mine}-facing-{other}", edges)
    for name, (_, edges) in (*deck.pressures.items(), *deck.fluids.items()):
        _surface(mesh, deck, name, edges)
    for pair in deck.pairs:
        one, two = pair.names
        _surface_pair(mesh, _name(pair, "contact"), f"{one}-outline", f"{two}-outline")
        if deck.is_tied_first:
            _surface_pair(mesh, _name(pair, "tie"), f"{one}-facing-{two}", f"{two}-facing-{one}")


def _in_plane(deck: Deck) -> Index:
    """Return the nodes that are kept from moving across the layer; a support that deforms its own keeps those."""
    deformed = [nodes for support, nodes in deck.supports if support.gradient.any()]
    return np.setdiff1d(np.arange(len(deck.layer.nodes)), np.concatenate([np.zeros(0, dtype=np.int64), *deformed]))


def _node_set(mesh: Element, name: str, nodes: Index) -> None:
    SubElement(mesh, "NodeSet", name=name).text = _listed(nodes)


def _surface(mesh: Element, deck: Deck, name: str, edges: Index) -> None:
    surface = SubElement(mesh, "Surface", name=name)
    faces = np.concatenate([deck.layer.faces[edge] for edge in edges])
    for number, face in enumerate(faces, 1):
        SubElement(surface, "quad8", id=str(number)).text = _listed(face)


def _surface_pair(mesh: Element, name: str, primary: str, secondary: str) -> None:
    pair = SubElement(mesh, "SurfacePair", name=name)
    put(pair, {"primary": primary, "secondary": secondary})


def _boundary(root: Element, deck: Deck) -> None:
    section = SubElement(root, "Boundary")
    _held(section, "plane-strain", "in-plane", (False, False, True))
    for support, _ in deck.supports:
        if support.gradient.any():
            _deformed(section, support)
            continue
        still = [value == 0 for value in support.translation]
        if any(still):
            _held(section, f"{support.region}-held", support.region, (*still, False))
        for axis, value in zip("xy", support.translation, strict=True):
            if value:
                moved = _condition(section, f"{support.region}-{axis}", support.region, "prescribed displacement")
                put(moved, {"dof": axis})
                SubElement(moved, "value", lc=_MOVES).text = f"{value:.15g}"
                put(moved, {"relative": 0})


def _held(section: Element, name: str, nodes: str, axes: tuple[bool, ...]) -> None:
    held = _condition(section, name, nodes, "zero displacement")
    put(held, {f"{axis}_dof": int(is_held) for axis, is_held in zip("xyz", axes, strict=True)})


def _deformed(section: Element, support: Support) -> None:
    """Let nodes follow ``u = scale (F - 1) X``."""
    moved = _condition(section, f"{support.region}-moved", support.region, "prescribed deformation")
    gradient = np.eye(3)
    gradient[:2, :2] += support.gradient
    SubElement(moved, "scale", lc=_MOVES).text = "1"
    put(moved, {"F": listed(gradient.ravel())})


def _condition(section: Element, name: str, nodes: str, kind: str) -> Element:
    return SubElement(section, "bc", name=name, node_set=nodes, type=kind)


def _loads(root: Element, deck: Deck) -> None:
    section = SubElement(root, "Loads")
    for name, (value, _) in deck.pressures.items():
        load = SubElement(section, "surface_load", name=f"pressure-{name}", surface=name, type="pressure")
        SubElement(load, "pressure", lc=_PRESSES).text = f"{value:.15g}"
        put(load, {"linear": 0, "symmetric_stiffness": 1})


def _constraints(root: Element, deck: Deck) -> None:
    """Let lumens keep their volume: at first by a liquid as stiff as the walls' bulk, then by multipliers."""
    section = SubElement(root, "Constraints")
    for name, (area, _) in deck.fluids.items():
        kept = SubElement(section, "constraint", name=f"fluid-{name}", surface=name, type="volume")
        volume = 2 / 3 * area * deck.layer.thickness
        put(kept, {"laugon": 1, "augtol": _KEPT, "penalty": deck.materials["wall"].bulk_modulus / volume})


def _steps(root: Element, deck: Deck) -> None:
    steps = SubElement(root, "Step")
    names = ("tied", "released") if deck.is_tied_first else ("pressed",)
    for number, name in enumerate(names, 1):
        step = SubElement(steps, "step", id=str(number), name=name)
        _control(step)
        contacts = SubElement(step, "Contact")
        for pair in deck.pairs:
            _contact(contacts, deck, pair, is_tie=name == "tied")


def _control(step: Element) -> None:
    control, size = SubElement(step, "Control"), 1 / _INCREMENTS
    put(control, {"analysis": "STATIC", "time_steps": _INCREMENTS, "step_size": size})
    put(control, {"plot_level": "PLOT_MAJOR_ITRS", "output_level": "OUTPUT_MAJOR_ITRS"})
    stepper = SubElement(control, "time_stepper", type="default")
    put(stepper, {"max_retries": 20, "opt_iter": 15, "dtmin": _SMALLEST * size, "dtmax": size, "cutback": 0.5})
    solver = SubElement(control, "solver", type="solid")
    put(solver, {"symmetric_stiffness": "symmetric", "max_refs": 50, "diverge_reform": 1, "reform_each_time_step": 1})
    put(solver, {"lstol": 0.9, "dtol": 1e-3, "etol": 1e-3, "rtol": 1e-6})
    put(SubElement(solver, "qn_method", type="BFGS"), {"max_ups": 0})


def _contact(contacts: Element, deck: Deck, pair: Pair, *, is_tie: bool) -> None:
    """Write a contact: both walls are primary in turn, so that each has half of the stiffness."""
    name, kind = (_name(pair, "tie"), "tied-elastic") if is_tie else (_name(pair, "contact"), "sliding-elastic")
    contact = SubElement(contacts, "contact", name=name, surface_pair=name, type=kind)
    stiffness, reach = (pair.stiffness * TIE, 0.1) if is_tie else (pair.stiffness, 1.0)
    put(contact, {"laugon": "PENALTY", "penalty": stiffness / 2, "auto_penalty": 0, "two_pass": 1})
    put(contact, {"search_tol": 0.01, "search_radius": reach * deck.layer.thickness, "symmetric_stiffness": 1})
    if not is_tie:
        put(contact, {"seg_up": 0, "tension": 0, "fric_coeff": 0})


def _name(pair: Pair, kind: str) -> str:
    return f"{kind}-{pair.names[0]}-{pair.names[1]}"


def _curves(root: Element, deck: Deck) -> None:
    """Write how supports and pressures grow; pressures that come first take a tenth of the time, supports the rest."""
    section = SubElement(root, "LoadData")
    first = [(0.1, 0.0)] if deck.comes_first else []
    _curve(section, _MOVES, [(0.0, 0.0), *first, (1.0, 1.0), (2.0, 1.0)])
    _curve(section, _PRESSES, [(0.0, 0.0), (0.1 if deck.comes_first else 1.0, 1.0), (2.0, 1.0)])


def _curve(section: Element, number: str, points: Iterable[tuple[float, float]]) -> None:
    curve = SubElement(section, "load_controller", id=number, type="loadcurve")
    put(curve, {"interpolate": "LINEAR", "extend": "CONSTANT"})
    places = SubElement(curve, "points")
    for time, value in points:
        SubElement(places, "pt").text = f"{time:g},{value:g}"


def _output(root: Element, deck: Deck) -> None:
    section = SubElement(root, "Output")
    plot = SubElement(section, "plotfile", type="febio")
    for name in ("displacement", "stress", "contact gap", "contact pressure"):
        SubElement(plot, "var", type=name)
    log = SubElement(section, "logfile")
    for support, _ in deck.supports:
        SubElement(log, "node_data", data="Rx;Ry", node_set=support.region, file=f"{support.region}.csv", delim=",")


def _listed(numbers: Index) -> str:
    """Return numbers of nodes as FEBio counts them, from 1."""
    return ",".join(str(number + 1) for number in numbers)
