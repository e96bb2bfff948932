"""Scenes far outside comfort: one group a kind of extremity, each point a whole case; `tools.extreme` runs them.

Tissues of 2x2 or 3x3 cells and pairs of rings or blocks: a point takes seconds. Where a ring has an exact answer, the
radial balance of `tools.radial`, the case expects it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import log, sqrt

from tools import extreme_solids
from tools.extreme_scenes import MORTAR, PENALTY, WRONG, Case, blocks, burst, height, material, rings, tissue

METHODS = {"penalty": PENALTY, "mortar": MORTAR}

#: Points whose answer is perturbed.
STIFF: tuple[str, ...] = (
    "wall / side: 0.02, penalty",
    "bulk / shear: 1e+04 tissue, penalty",
    "bulk / shear: 1e+06 tissue, penalty",
    "inclusion / wall: 1e+04, penalty",
    "stiff neighbour: 1e-06 blocks, penalty",
    "stiff neighbour: 1e+06 press-fit, penalty",
    "c2 / c1: 100",
    "shear: 1 frame, penalty",
    "compression: 0.9 plates, penalty",
    "cell pressure: 0.98 of a ring's limit",
    "penalty: 1e+04 tissue",
    "overlap and gap: overlap 0.3, penalty",
    "mesh: graded to 0.01, penalty",
    "unequal sizes: 0.1 on 1, penalty",
)
#: Some forty points of all kinds that take seconds.
QUICK: tuple[str, ...] = (
    "wall / side: 0.05, mortar",
    "wall / side: 0.2, penalty",
    "wall / side: 0.5, penalty",
    "bulk / shear: 1e+00 tissue, penalty",
    "bulk / shear: 1e+04 tissue, penalty",
    "bulk / shear: 1e+06 tissue, penalty",
    "bulk / shear: 1e+02 press-fit, mortar",
    "inclusion / wall: 1e-04, penalty",
    "inclusion / wall: 1e+02, penalty",
    "inclusion / wall: 1e+04, penalty",
    "stiff neighbour: 1e-06 blocks, penalty",
    "stiff neighbour: 1e+06 blocks, penalty",
    "stiff neighbour: 1e+03 press-fit, penalty",
    "c2 / c1: 0",
    "c2 / c1: 10",
    "c2 / c1: 100",
    "shear: 1 frame, penalty",
    "compression: 0.9 plates, penalty",
    "compression: 0.9 plates, mortar",
    "cell pressure: 0.5 of a ring's limit",
    "cell pressure: 0.9 of a ring's limit",
    "cell pressure: tissue 0.02, penalty",
    "cell pressure: a pair of cells 2",
    "penalty: 1e-02 press-fit",
    "penalty: 1e+01 tissue",
    "penalty: 1e+02 tissue",
    "penalty: 1e+04 tissue",
    "penalty: 1e+06 press-fit",
    "units: m and Pa, penalty",
    "units: um and MPa, penalty",
    "units: km and GPa, penalty",
    "overlap and gap: overlap 0.01, mortar",
    "overlap and gap: overlap 0.3, penalty",
    "overlap and gap: overlap 0.4, mortar",
    "mesh: size 1, 1 layers, mortar",
    "mesh: size 1, 8 layers, penalty",
    "mesh: size 0.5, 16 layers, penalty",
    "mesh: graded to 0.01, penalty",
    "unequal sizes: 0.1 on 1, penalty",
    "unequal sizes: 0.001 on 1, mortar",
    "steps: 1, sddp",
    "there and back: sddp, penalty",
    "there and back: single-step, penalty",
    "prisms: planar",
    "prisms: height 1, held",
    "prisms: height 0.05",
    "prisms: closed, pressure 0.2",
    "prisms: bulk / shear 1e+04",
)


@dataclass(frozen=True)
class Point:
    """One scene.

    Attributes
    ----------
    group : str
        What is extreme.
    setting : str
        How much, and by which method.
    build : partial
        Makes the case, as in a TOML file; exact answers take a second.
    has_solution : bool
        Whether an equilibrium exists at the last level, by an argument that is not the solver's.
    same_as : str
        Setting of the group whose answer must be the same, without units; empty where there is none.
    units : tuple of float
        Units of length and stress, as multiples of those of the plain scene.
    is_quick : bool
        Whether it is one of those that are tried often.
    perturbed_from : str
        Label of the point that this one is a perturbation of; empty if it is none.
    tolerance : float
        Multiple of the decrement at which equilibria end.
    """

    group: str
    setting: str
    build: partial[Case]
    has_solution: bool = True
    same_as: str = ""
    units: tuple[float, float] = field(default=(1.0, 1.0))
    is_quick: bool = False
    perturbed_from: str = ""
    tolerance: float = 1.0

    @cached_property
    def case(self) -> Case:
        """The case, as in a TOML file."""
        return self.build()

    @property
    def label(self) -> str:
        """The point's key."""
        return f"{self.group}: {self.setting}"


def points() -> list[Point]:
    """Return all points, in the order of the groups, and after them the stiff ones perturbed."""
    found: list[Point] = []
    for group in (
        thin_and_thick_walls, stiff_volumes, stiff_fillings, stiff_neighbours, second_constants, far_shear,
        crushed, swollen, penalties, units, overlaps_and_gaps, bad_meshes, unequal_sizes, step_counts, there_and_back,
        prisms,
    ):  # fmt: skip
        found += group()
    found = [replace(point, is_quick=point.label in QUICK) for point in found]
    return found + [other for point in found if point.label in STIFF for other in perturbations(point)]


def perturbations(point: Point) -> Iterator[Point]:
    """Yield the point with a finer mesh, with three times the steps, a stiffer penalty, and less exactly solved."""
    changes = {"mesh": _finer, "steps": _with_more_steps, "penalty": _with_stiffer_penalty}
    for name, change in changes.items():
        if name == "penalty" and _has_mortar(point):
            continue
        case = partial(change, point)
        yield replace(point, setting=f"{point.setting}; {name}", build=case, perturbed_from=point.label, is_quick=False)
    yield replace(
        point, setting=f"{point.setting}; tolerance", perturbed_from=point.label, tolerance=1e4, is_quick=False
    )


def _has_mortar(point: Point) -> bool:
    """Return whether a point has mortar contact, without building its case."""
    default = PENALTY if point.build.func is tissue else MORTAR
    return bool(point.build.keywords.get("contact", default)["kind"] == "mortar")


def _finer(point: Point) -> Case:
    """A mesh with elements three quarters as long."""
    case = point.case
    mesh = dict(case.get("mesh", {}))
    if "tissue" in case:
        side = case["tissue"].get("side", 1.0)
        return case | {"mesh": mesh | {"size": 0.75 * mesh.get("size", side / 2)}}
    if "refine" in mesh:
        mesh["refine"] = [zone | {"size": 0.75 * zone["size"]} for zone in mesh["refine"]]
    return case | {"mesh": mesh, "bodies": [body | {"size": 0.75 * body["size"]} for body in case["bodies"]]}


def _with_more_steps(point: Point) -> Case:
    case = point.case
    if "tissue" in case:
        levels = case["load"]["levels"]
        strategy = {"kind": "sddp"} | case.get("strategy", {})
        return case | {"strategy": strategy | {"steps": 3 * (levels if isinstance(levels, int) else len(levels))}}
    return case | {"steps": 3 * case["levels"]}


def _with_stiffer_penalty(point: Point) -> Case:
    contact = point.case["contact"]
    return point.case | {"contact": contact | {"stiffness": 3 * contact.get("stiffness", 1.0)}}


def thin_and_thick_walls() -> Iterator[Point]:
    """Wall over side."""
    for wall in (0.01, 0.02, 0.05, 0.2, 0.35, 0.5):
        for name, contact in METHODS.items():
            yield Point("wall / side", f"{wall:g}, {name}", partial(tissue, wall=wall, contact=contact))


def stiff_volumes() -> Iterator[Point]:
    """Bulk over shear modulus."""
    for bulk in (1.0, 1e2, 1e3, 1e4, 1e5, 1e6):
        for name, contact in METHODS.items():
            case = partial(tissue, contact=contact, material=material(bulk=bulk))
            yield Point("bulk / shear", f"{bulk:.0e} tissue, {name}", case)
    for bulk in (1.0, 1e2, 1e4, 1e6):
        for name, contact in METHODS.items():
            case = partial(rings, 0.9, bulk=bulk, contact=contact)
            yield Point("bulk / shear", f"{bulk:.0e} press-fit, {name}", case)


def stiff_fillings() -> Iterator[Point]:
    """Shear modulus of what fills the lumens over that of the walls."""
    for ratio in (1e-4, 1e-2, 1.0, 1e2, 1e4):
        for name, contact in METHODS.items():
            filling = {"kind": "inclusion", "material": material(2.0 * ratio)}
            yield Point(
                "inclusion / wall",
                f"{ratio:.0e}, {name}",
                partial(tissue, move=(0.05, 0.0), contact=contact, lumen=filling),
            )
    for bulk in (1e4, 1e6):
        filling = {"kind": "inclusion", "material": material(0.2, bulk)}
        yield Point("inclusion / wall", f"0.1 with bulk / shear {bulk:.0e}", partial(tissue, lumen=filling))


def stiff_neighbours() -> Iterator[Point]:
    """One wall stiffer than its neighbour."""
    for ratio in (1e-6, 1e-3, 1e3, 1e6):
        for name, contact in METHODS.items():
            case = partial(rings, 0.96, moduli=(1.0, ratio), contact=contact)
            yield Point("stiff neighbour", f"{ratio:.0e} press-fit, {name}", case)
    for ratio in (1e-6, 1e6):
        for name, contact in METHODS.items():
            case = partial(blocks, (1.0, ratio), contact=contact)
            yield Point("stiff neighbour", f"{ratio:.0e} blocks, {name}", case)


def second_constants() -> Iterator[Point]:
    """c2 over c1."""
    for ratio in (0.0, 1.0, 10.0, 100.0):
        case = partial(tissue, material=material(share=ratio / (1 + ratio)))
        yield Point("c2 / c1", f"{ratio:g}", case)


def far_shear() -> Iterator[Point]:
    """Plates moved by up to twice their distance, and a frame sheared as far."""
    for shear in (0.5, 1.0, 2.0, -2.0):
        for name, contact in METHODS.items():
            case = partial(tissue, move=(shear * height(2), 0.0), contact=contact, levels=2)
            yield Point("shear", f"{shear:g} plates, {name}", case)
    for shear in (1.0, 2.0, -2.0):
        for name, contact in METHODS.items():
            case = partial(tissue, contact=contact, load={"kind": "frame", "shear": shear, "levels": 2})
            yield Point("shear", f"{shear:g} frame, {name}", case)


def crushed() -> Iterator[Point]:
    """The tissue pressed to half of its height."""
    for stretch in (0.9, 0.75, 0.5):
        for name, contact in METHODS.items():
            case = partial(tissue, contact=contact, load={"kind": "plates", "stretch": stretch, "levels": 2})
            yield Point("compression", f"{stretch:g} plates, {name}", case)
    for stretch in (0.75, 0.5):
        frame = {"kind": "frame", "stretch": [1.0, stretch], "levels": 2}
        yield Point("compression", f"{stretch:g} frame, penalty", partial(tissue, load=frame))
    for stretch in (0.9, 0.75, 0.5):
        frame = {"kind": "frame", "stretch": [stretch, stretch], "levels": 2}
        yield Point("compression", f"{stretch:g} frame, both ways", partial(tissue, load=frame))


def swollen() -> Iterator[Point]:
    """Pressures up to and past the one that a wall can bear.

    A ring of radii A, B in plane strain bears no more than ``mu ln(B / A)`` if it is incompressible: its radius grows
    beyond bounds as the pressure comes near. At this ratio of bulk to shear modulus the bound differs by its inverse.
    """
    limit = log(2.0)
    for share in (0.5, 0.9, 0.98):
        case = partial(rings, 4.0, 4.5, pressure=share * limit, levels=2)
        yield Point("cell pressure", f"{share:g} of a ring's limit", case)
    for share in (1.1, 2.0, 10.0):
        yield Point("cell pressure", f"{share:g} of a ring's limit", partial(burst, share * limit), has_solution=False)
    for pressure in (0.02, 0.1):
        for name, contact in METHODS.items():
            lumen = {"kind": "pressure", "pressure": pressure, "ramp": "first"}
            yield Point(
                "cell pressure", f"tissue {pressure:g}, {name}", partial(tissue, contact=contact, lumen=lumen, levels=2)
            )
    # Free walls of the outer cells bear about mu times wall over radius, 0.2, and no more.
    for pressure in (0.5, 2.0):
        lumen = {"kind": "pressure", "pressure": pressure}
        case = partial(tissue, lumen=lumen, levels=4)
        yield Point("cell pressure", f"tissue {pressure:g}", case, has_solution=False)
    lumen = {"kind": "pressure", "pressure": 2.0}
    case = partial(tissue, 1, 2, lumen=lumen)
    yield Point("cell pressure", "a pair of cells 2", case, has_solution=False)
    for pressure in (0.2, 5.0, 50.0):
        # Held all around, walls between cells of one pressure bear it without bending.
        walls = 5 * 1.0
        exact = {
            "level": 1.0,
            "quantity": "contact_force",
            "value": walls * pressure,
            "tolerance": WRONG,
            "origin": "K5",
        }
        case = partial(
                tissue, lumen={"kind": "pressure", "pressure": pressure}, material=material(bulk=1e4), contact=MORTAR,
            load={"kind": "frame", "shear": 0.0, "levels": 1}, expected=[exact],
        )  # fmt: skip
        yield Point("cell pressure", f"held tissue {pressure:g}", case)


def penalties() -> Iterator[Point]:
    """Stiffness of the penalty over its default."""
    for multiple in (1e-2, 1e-1, 1e1, 1e2, 1e3, 1e4, 1e6):
        stiff = {"kind": "penalty", "stiffness": multiple}
        yield Point("penalty", f"{multiple:.0e} tissue", partial(tissue, contact=stiff))
        yield Point("penalty", f"{multiple:.0e} press-fit", partial(rings, 0.9, contact=stiff))


def units() -> Iterator[Point]:
    """The same tissue in other units of length and stress."""
    for name, contact in METHODS.items():
        for word, length, stress in (
            ("m and Pa", 1.0, 1.0), ("um and MPa", 1e6, 1e-6), ("km and GPa", 1e-3, 1e-9),
            ("m and Pa of um and MPa", 1e-6, 1e6),
        ):  # fmt: skip
            cells = {"rows": 2, "cols": 2, "side": length, "wall": 0.1 * length}
            case = partial(
                tissue, move=(0.3 * length, 0.0), contact=contact, material=material(2.0 * stress), tissue=cells
            )
            yield Point("units", f"{word}, {name}", case, same_as=f"m and Pa, {name}", units=(length, stress))


def overlaps_and_gaps() -> Iterator[Point]:
    """Bodies drawn into each other, and apart."""
    for bore in (0.99, 0.8, 0.7, 0.6):
        for name, contact in METHODS.items():
            case = partial(rings, bore, bore + 0.6, contact=contact)
            yield Point("overlap and gap", f"overlap {1 - bore:g}, {name}", case)
    for bore in (1.001, 1.1, 1.5):
        for name, contact in METHODS.items():
            case = partial(rings, bore, bore + 0.5, pressure=0.68, contact=contact, levels=2)
            yield Point("overlap and gap", f"gap {bore - 1:.3g}, {name}", case)
    for gap in (1e-6, 0.5):
        yield Point("overlap and gap", f"blocks {gap:g} apart", partial(blocks, gap=gap))


def bad_meshes() -> Iterator[Point]:
    """Needles and grading."""
    for size, layers in ((1.0, 1), (1.0, 8), (0.5, 16), (0.02, 1)):
        for name, contact in METHODS.items():
            mesh = {"size": size, "layers": layers, "order": 2}
            yield Point(
                "mesh", f"size {size:g}, {layers} layers, {name}", partial(tissue, 1, 2, contact=contact, mesh=mesh)
            )
    for size in (1e-2, 1e-3):
        for name, contact in METHODS.items():
            mesh = {"order": 2, "refine": [{"at": [1.0, 1.0], "within": size, "size": size / 2}]}
            yield Point("mesh", f"graded to {size:g}, {name}", partial(blocks, contact=contact, mesh=mesh))
    for sizes in ((0.5, 0.02), (0.02, 0.5)):
        for name, contact in METHODS.items():
            yield Point("mesh", f"{sizes[0]:g} on {sizes[1]:g}, {name}", partial(blocks, sizes=sizes, contact=contact))


def unequal_sizes() -> Iterator[Point]:
    """Bodies of very different size."""
    for width in (0.1, 0.01, 0.001):
        for name, contact in METHODS.items():
            case = partial(blocks, width=width, down=0.1 * width, contact=contact)
            yield Point("unequal sizes", f"{width:g} on 1, {name}", case)


def step_counts() -> Iterator[Point]:
    """One load step, and two hundred."""
    for steps in (1, 200):
        for strategy in ("sddp", "single-step"):
            case = partial(tissue, 1, 2, strategy={"kind": strategy, "steps": steps}, mesh={"order": 2})
            yield Point("steps", f"{steps}, {strategy}", case, same_as=f"1, {strategy}")
    for steps in (1, 50):
        case = partial(rings, 1.1, 1.6, pressure=0.68, steps=steps)
        yield Point("steps", f"{steps}, closing rings", case)


def there_and_back() -> Iterator[Point]:
    """The load taken back: no energy is left."""
    for strategy in ("sddp", "single-step"):
        for name, contact in METHODS.items():
            rest = {
                "level": 0.0,
                "quantity": "energy",
                "value": 0.0,
                "tolerance": 1e-10,
                "origin": "no law of debonding",
            }
            case = partial(
                tissue, 2, 2, move=(sqrt(3), 0.0), levels=[0.5, 1.0, 0.5, 0.0], contact=contact, mesh={"order": 2},
                strategy={"kind": strategy}, expected=[rest],
            )  # fmt: skip
            yield Point("there and back", f"{strategy}, {name}", case)


def prisms() -> Iterator[Point]:
    """Prisms: flat and tall, thin and stiff, closed and turned."""
    for setting, case, same_as in extreme_solids.entries():
        yield Point("prisms", setting, case, same_as=same_as)
