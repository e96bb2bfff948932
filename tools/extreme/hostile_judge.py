"""Whether a run's folder agrees with itself: numbers of the tables against what the fields say, and with another run.

Findings are sentences; a certified run with one is wrong. Limits are shares of what they are compared with, far above
round-off and far below what a reader of the numbers would accept.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from tools import tables
from tools.extreme.hostile_fields import Fields, deepest_overlap, entered_area, lumen_areas, read_levels, shapes
from tools.extreme.hostile_scenes import Case, Scene
from tools.runs import summary_in

#: Energy of the written field beyond the reported one, as a share of it: what the default mesh is off by is as much.
INTEGRATION = 0.10
#: Area of a cell that lies over itself as a share of it; mean thickness of an overlap over that of the wall; area that
#: the filled outlines of two cells may share, in squares of a side.
SELF_OVERLAP, OVERLAP, ENTERED = 2e-3, 0.03, 0.01
#: Area of a lumen beside that of its fluid; energy above the tied one and above what forces have done.
VOLUME, BOUND, WORK = 2e-3, 1e-3, 0.02
#: Largest relative difference of runs that are the same scene, of runs on another mesh, and by another path.
SAME = {"scaled": 1e-5, "threads": 1e-6, "far body": 1e-6, "mirrored": 1e-5, "levels": 0.02}
#: Length to which OpenCASCADE places points.
_PLACED = 1e-7
_OTHER_MESH, _OF_ANY_MESH = 0.15, ("energy", "plate_force_x", "plate_force_y")
#: What is compared: powers of length and of stress, and the sign in the mirror.
COMPARED = {
    "energy": (2, 1, 1), "plate_force_x": (1, 1, -1), "plate_force_y": (1, 1, 1), "contact_force": (1, 1, 1),
    "mean_gap": (1, 0, 1), "largest_gap": (1, 0, 1),
}  # fmt: skip
#: Numbers of this size count as nothing, in a unit made of a side and of the shear modulus.
NOTHING = 1e-6


@dataclass
class Findings:
    """What was found in a folder.

    Attributes
    ----------
    wrong : list of str
        What cannot be.
    integration, jacobian, overlap, self_overlap : float
        Largest deviation of the energy, smallest J, and overlaps as shares, over all levels.
    """

    wrong: list[str] = field(default_factory=list)
    integration: float = 0.0
    jacobian: float = math.inf
    overlap: float = 0.0
    self_overlap: float = 0.0

    def note(self, what: str, is_wrong: bool) -> None:
        """Note a sentence, once."""
        if is_wrong and what.split(":")[0] not in [other.split(":")[0] for other in self.wrong]:
            self.wrong.append(what)


def rows_of(folder: Path) -> list[dict[str, str]]:
    """Return the rows of the history of a folder."""
    return tables.read(folder / "history.csv")


def examine(scene: Scene, folder: Path) -> Findings:
    """Return what the files of a run say about it."""
    found, rows = Findings(), rows_of(folder)
    numbers = [float(row[name]) for row in rows for name in COMPARED]
    found.note("a number is none", not all(map(math.isfinite, numbers)))
    reported = list(_at_levels(scene.run.case, rows))
    written = list(read_levels(folder))
    found.note(f"levels: {len(written)} are written, {len(reported)} reported", len(written) != len(reported))
    for row, (_, fields) in zip(reported, written, strict=False):
        _examine_level(found, scene.run.case, row, fields)
    if "tissue" in scene.run.case and "lumen" not in scene.run.case:
        _bound(found, rows, scene.run.case)
        _work(found, reported, scene, folder)
    return found


def _at_levels(case: Case, rows: Sequence[dict[str, str]]) -> Iterator[dict[str, str]]:
    """Yield the released rows at the levels, which the path reaches in their order."""
    ahead = _levels(case)
    for row in rows:
        if ahead and row["phase"] == "released" and abs(float(row["load_factor"]) - ahead[0]) < 1e-8:
            ahead = ahead[1:]
            yield row


def _levels(case: Case) -> list[float]:
    levels = case["load"]["levels"] if "load" in case else case["levels"]
    return [(number + 1) / levels for number in range(levels)] if isinstance(levels, int) else list(levels)


def _units(case: Case) -> tuple[float, float, float]:
    """Return a length, a modulus and the thickness of a wall."""
    material = case["material"] if "material" in case else case["bodies"][0]["material"]
    tissue = case.get("tissue", {})
    return tissue.get("side", 1.0), material["c1"] + material["c2"], tissue.get("wall", 0.3)


def _examine_level(found: Findings, case: Case, row: Mapping[str, str], fields: Fields) -> None:
    side, modulus, wall = _units(case)
    energy, load = float(row["energy"]), float(row["load_factor"])
    jacobian = fields.smallest_jacobian
    found.jacobian = min(found.jacobian, jacobian)
    found.note(f"J: {jacobian:.3g} at {load:g}", jacobian <= 0)
    if not _has_inclusion(case):
        integral = sum(fields.of(cells).energy(law) for law, cells in _laws(case, fields))
        deviation = abs(integral - energy) / max(energy, NOTHING * modulus * side**2)
        found.integration = max(found.integration, deviation)
        found.note(f"energy: {energy:.4g}, of the field {integral:.4g} at {load:g}", deviation > INTEGRATION)
    outlines = shapes(fields)
    over = max(area / outlines.polygon[cell].area for cell, area in outlines.self_overlap.items())
    deep = deepest_overlap(outlines) / wall
    found.self_overlap, found.overlap = max(found.self_overlap, over), max(found.overlap, deep)
    found.note(f"self-overlap: {over:.2%} of a cell at {load:g}", over > SELF_OVERLAP)
    found.note(f"overlap: {deep:.1%} of the wall at {load:g}", deep > OVERLAP)
    if "tissue" in case:
        common = entered_area(outlines)
        found.note(f"one cell is in another: {common:.2g} at {load:g}", common > ENTERED * side**2)
    if case.get("lumen", {}).get("kind") == "fluid":
        _volumes(found, case["lumen"], load, fields)


def _has_inclusion(case: Case) -> bool:
    return bool(case.get("lumen", {}).get("kind") == "inclusion")


def _laws(case: Case, fields: Fields) -> list[tuple[dict[str, Any], list[int]]]:
    if "tissue" in case:
        return [(case["material"], fields.cells)]
    return [(body["material"], [number]) for number, body in enumerate(case["bodies"])]


def _volumes(found: Findings, lumen: Case, load: float, fields: Fields) -> None:
    grown = 1.0 if lumen.get("ramp") == "first" else load
    asked = 1 + (lumen["fill"] - 1) * grown
    for rest, now in lumen_areas(fields).values():
        is_off = abs(now / rest - asked) > VOLUME * asked
        found.note(f"volume: {now / rest:.5f} of a lumen, filled to {asked:.5f}", is_off)


def _bound(found: Findings, rows: Sequence[dict[str, str]], case: Case) -> None:
    """Released walls store no more than tied ones, which are among the states that they may take."""
    side, modulus, _ = _units(case)
    for tied, released in pairwise(rows):
        if (tied["phase"], released["phase"]) == ("tied", "released"):
            above = float(released["energy"]) - float(tied["energy"])
            is_above = above > BOUND * float(tied["energy"]) + NOTHING * modulus * side**2
            found.note(f"above the tied energy: by {above:.3g} at {float(tied['load_factor']):g}", is_above)


def _work(found: Findings, rows: Sequence[dict[str, str]], scene: Scene, folder: Path) -> None:
    """No energy comes from nowhere: it grows by no more than the largest force times the way between levels.

    Levels of a tissue are selected one by one. Where the summary tells that the walls have taken another branch, which
    may store more, nothing is claimed that is wrong.
    """
    told = summary_in(folder).get("changes_of_branch", {})
    case = scene.run.case
    move = case["load"].get("displacement")
    if move is None or not scene.is_slope:
        return
    side, modulus, _ = _units(case)
    for one, two in pairwise(rows):
        step = float(two["load_factor"]) - float(one["load_factor"])
        if step > 0.02 or two["step"] in told:
            continue
        rates = [float(row["plate_force_x"]) * move[0] + float(row["plate_force_y"]) * move[1] for row in (one, two)]
        grown = float(two["energy"]) - float(one["energy"])
        allowed = WORK * max(map(abs, rates)) * step + abs(rates[1] - rates[0]) * step + NOTHING * modulus * side**2
        surplus = grown - step * sum(rates) / 2
        place = f"{float(two['load_factor']):g}"
        found.note(f"energy from nowhere: {surplus:.3g} at {place}", surplus > allowed)
        # What is lost went with a jump to another equilibrium, which the gaps show.
        jump = abs(float(two["mean_gap"]) - float(one["mean_gap"]))
        found.note(f"energy lost: {-surplus:.3g} at {place}", -surplus > allowed and jump < 1e-3 * side)


def compare(scene: Scene, folder: Path, other: Path) -> list[str]:
    """Return how a related run differs from a scene where it may not."""
    mine, theirs = ([row for row in rows_of(place) if row["phase"] == "released"] for place in (folder, other))
    if scene.relation == "levels":
        mine, theirs = mine[-1:], theirs[-1:]
    if len(mine) != len(theirs):
        return [f"{scene.relation}: {len(theirs)} steps in place of {len(mine)}"]
    of_bodies = scene.relation in ("mirrored", "levels") and "bodies" in scene.run.case
    names = _OF_ANY_MESH if of_bodies else tuple(COMPARED)
    worst = max(((_difference(scene, name, mine, theirs), name) for name in names), default=(0.0, ""))
    limit = _OTHER_MESH if of_bodies and scene.relation == "mirrored" else SAME[scene.relation]
    if scene.relation == "scaled" and "bodies" in scene.run.case:
        # OpenCASCADE places points to within an absolute length.
        limit = max(limit, _PLACED / scene.factors[0])
    return [f"{scene.relation}: {worst[1]} differs by {worst[0]:.2g}"] if worst[0] > limit else []


def _difference(scene: Scene, name: str, mine: list[dict[str, str]], theirs: list[dict[str, str]]) -> float:
    """Return the largest difference of a column over its largest number."""
    length, stress, in_mirror = COMPARED[name]
    side, modulus, _ = _units(scene.run.case)
    unit = scene.factors[0] ** length * scene.factors[1] ** stress * (in_mirror if scene.relation == "mirrored" else 1)
    one, two = (np.array([float(row[name]) for row in rows]) for rows in (mine, theirs))
    # A component of a force is beside the whole of it.
    whole = [name] if "plate" not in name else ["plate_force_x", "plate_force_y"]
    largest = max(abs(float(row[column])) for row in mine for column in whole)
    least = 1e3 * NOTHING * side**length * modulus**stress
    return float(np.abs(two / unit - one).max(initial=0.0) / max(largest, least))
