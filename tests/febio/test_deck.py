"""Decks hold FEBio's keywords only, and the tissue that they were written of."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree.ElementTree import Element, parse

import ngsolve
import numpy as np
import pytest
from click.testing import CliRunner

import ngcell
from ngcell.build.simulation import Simulation
from ngcell.cli import ngcell as command
from ngcell.geometry.sections import along_walls
from ngcell.mechanics.fluid import LumenFluids
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from tests.febio.keywords import ALLOWED, CURVED, PARAMETERS, WORDS

CASES = (
    "shear-empty-3x3",
    "shear-pressurised",
    "shear-filled",
    "shear-fibres",
    "shear-fluid",
    "frame-shear",
    "shear-empty-single-step",
)
#: Tags whose type says what may stand in them.
TYPED = {"material", "solid", "bc", "contact", "surface_load", "constraint", "solver", "qn_method"}


@cache
def deck(name: str, *sets: str) -> Element:
    with TemporaryDirectory() as folder:
        file = Path(folder, "tissue.feb")
        options = [part for each in sets for part in ("--set", each)]
        answer = CliRunner().invoke(command, ["export-febio", name, *options, "--out", str(file)])
        assert answer.exit_code == 0, answer.output
        return parse(file).getroot()


@cache
def built(name: str, *sets: str) -> Simulation:
    return Simulation(ngcell.read_case(name, sets))


def numbers(tag: Element) -> np.ndarray:
    return np.array([int(word) for word in str(tag.text).split(",")])


def nodes(root: Element) -> np.ndarray:
    found = root.findall("Mesh/Nodes/node")
    assert [int(node.get("id", 0)) for node in found] == list(range(1, len(found) + 1))
    return np.array([[float(word) for word in str(node.text).split(",")] for node in found])


def area(ring: np.ndarray) -> float:
    """Area within a closed line through corner, middle, corner, ...: exact for parabolas through the three."""
    ends, middles = ring[::2], ring[1::2]
    after = np.roll(ends, -1, axis=0)

    def cross(one: np.ndarray, two: np.ndarray) -> np.ndarray:
        return one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]

    return float((4 * cross(ends, middles) + 4 * cross(middles, after) - cross(ends, after)).sum() / 6)


def check(tag: Element, path: str) -> None:
    owner = f"{tag.tag} {tag.get('type')}" if f"{tag.tag} {tag.get('type')}" in PARAMETERS else tag.tag
    assert set(tag.attrib) <= ALLOWED[path], (path, tag.attrib)
    if "type" in tag.attrib and tag.tag in TYPED:
        assert owner in PARAMETERS, owner
    for child in tag:
        place = f"{path}/{child.tag}"
        if place in ALLOWED:
            check(child, place)
            continue
        assert child.tag in PARAMETERS.get(owner, set()), (path, child.tag)
        assert set(child.attrib) <= ({"lc"} if child.tag in CURVED else set())
        words = WORDS.get(f"{owner} {child.tag}", WORDS.get(child.tag))
        assert words is None or child.text in words
        assert not len(child)


@pytest.mark.parametrize("name", CASES)
def test_a_deck_holds_keywords_of_febio_and_names_that_it_defines(name):
    root = deck(name)
    assert root.tag == "febio_spec" and root.get("version") == "4.0"
    check(root, "febio_spec")
    tags = ("NodeSet", "Surface", "SurfacePair")
    sets = {tag: [each.get("name") for each in root.findall(f"Mesh/{tag}")] for tag in tags}
    parts = [each.get("name") for each in root.findall("Mesh/Elements")]
    for found in (*sets.values(), parts):
        assert len(set(found)) == len(found)
    assert [each.get("name") for each in root.findall("MeshDomains/SolidDomain")] == parts
    materials = {each.get("name") for each in root.findall("Material/material")}
    assert {each.get("mat") for each in root.findall("MeshDomains/SolidDomain")} == materials
    assert {each.get("node_set") for each in root.iter() if each.get("node_set")} <= set(sets["NodeSet"])
    assert {each.get("surface") for tag in ("surface_load", "constraint") for each in root.iter(tag)} <= set(
        sets["Surface"]
    )
    assert {each.get("elem_set") for each in root.iter("ElementData")} <= set(parts)
    assert {each.get("surface_pair") for each in root.iter("contact")} <= set(sets["SurfacePair"])
    assert {each.text for pair in root.iter("SurfacePair") for each in pair} <= set(sets["Surface"])
    curves = {each.get("id") for each in root.iter("load_controller")}
    assert {each.get("lc") for each in root.iter() if each.get("lc")} <= curves


@pytest.mark.parametrize("scene", [*((name,) for name in CASES), ("shear-filled", "mesh.order=3")])
def test_elements_are_the_bodies_and_their_fillings(scene):
    """Each part has the area of its body's elements, upright edges, and no node of another body."""
    root, place, tissue = deck(*scene), nodes(deck(*scene)), built(*scene)
    bodies = tissue.bodies
    areas = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh, element_wise=True).NumPy()
    filled = np.zeros(len(areas), dtype=bool) if bodies.is_filling is None else bodies.is_filling
    owner: dict[int, str] = {}
    for part in root.findall("Mesh/Elements"):
        body, material = str(part.get("name")).split("-")[:2]
        total = 0.0
        for element in part:
            ring = numbers(element) - 1
            assert part.get("type") == "hex20" and len(ring) == 20
            below, above, middles, over, half = np.split(ring, 5)
            thickness = place[above[0], 2]
            np.testing.assert_allclose(place[above] - place[below], [[0, 0, thickness]] * 4, atol=1e-12)
            np.testing.assert_allclose(place[over] - place[middles], [[0, 0, thickness]] * 4, atol=1e-12)
            np.testing.assert_allclose(place[half] - place[below], [[0, 0, thickness / 2]] * 4, atol=1e-12)
            total += area(place[np.column_stack([below, middles]).ravel(), :2])
            assert all(owner.setdefault(int(node), body) == body for node in ring)
        mine = (bodies.body_of_element == bodies.body_names.index(body)) & (filled == (material == "filling"))
        assert total == pytest.approx(areas[mine].sum(), rel=1e-9)
    assert len(owner) == len(place)


@pytest.mark.parametrize("name", CASES)
def test_walls_look_outwards_and_pairs_are_those_that_face_each_other(name):
    root, place, tissue = deck(name), nodes(deck(name)), built(name)
    surfaces = {surface.get("name"): [numbers(face) - 1 for face in surface] for surface in root.iter("Surface")}
    lengths = np.zeros(tissue.bodies.body_count)
    np.add.at(lengths, tissue.walls.body, tissue.walls.weights.sum(1))
    for body, label in enumerate(tissue.bodies.body_names):
        faces = np.array(surfaces[f"{label}-outline"])
        along = place[faces[:, 1]] - place[faces[:, 0]]
        assert np.linalg.norm(along, axis=1).sum() == pytest.approx(lengths[body], rel=1e-2)
        outward = np.column_stack([along[:, 1], -along[:, 0]])
        middle = place[faces[:, :2]].mean(1)[:, :2]
        # The outline is closed: by Gauss its area is half of the flux of the place.
        assert (middle * outward).sum() / 2 > 0
        assert (place[faces[:, 0], 2] == 0).all() and (place[faces[:, 2], 2] > 0).all()
    facing = {tuple(tissue.bodies.body_names[body] for body in pair) for pair in tissue.setup.facing.pairs}
    found = {tuple(str(pair.get("name")).split("-")[1:]) for pair in root.iter("SurfacePair")}
    assert found == facing
    for one, two in facing:
        mine, theirs = (place[np.unique(surfaces[f"{a}-facing-{b}"])] for a, b in ((one, two), (two, one)))
        apart = np.linalg.norm(mine[:, None] - theirs[None], axis=2)
        assert len(mine) == len(theirs) and apart.min(1).max() < 1e-9


@pytest.mark.parametrize("name", CASES)
def test_steps_are_tied_then_released_or_pressed_at_once(name):
    steps = 1 if name == "shear-empty-single-step" else 2
    found = deck(name).findall("Step/step")
    kinds = [{each.get("type") for each in step.iter("contact")} for step in found]
    assert kinds == [{"tied-elastic"}, {"sliding-elastic"}][-steps:]
    pairs = len(built(name).setup.facing.pairs)
    assert all(len(step.findall("Contact/contact")) == pairs for step in found)


def test_plates_are_held_and_moved_as_the_last_level_says():
    root, tissue = deck("shear-empty-3x3"), built("shear-empty-3x3")
    place, sets = nodes(root), {each.get("name"): numbers(each) - 1 for each in root.iter("NodeSet")}
    assert (np.sort(sets["in-plane"]) == np.arange(len(place))).all()
    extent = tissue.bodies.extent[:, 1]
    for name, height in (("lower-plate", extent[0]), ("upper-plate", extent[1])):
        edges, parts = list(tissue.bodies.mesh.Boundaries(name).Elements()), -(-tissue.space.order // 2)
        assert abs(place[sets[name], 1] - height).max() <= 0.5 + 1e-9
        # Corners of quadratic elements have three nodes above each other, middles of sides two.
        ends = {vertex.nr for edge in edges for vertex in edge.vertices}
        assert len(sets[name]) == 3 * (len(ends) + (parts - 1) * len(edges)) + 2 * parts * len(edges)
    (moved,) = root.findall("Boundary/bc[@type='prescribed displacement']")
    assert moved.get("node_set") == "upper-plate" and moved.findtext("dof") == "x"
    assert float(str(moved.findtext("value"))) == 1.0
    held = {(each.get("node_set"), *(each.findtext(f"{axis}_dof") for axis in "xyz")) for each in root.iter("bc")
            if each.get("type") == "zero displacement"}  # fmt: skip
    assert held == {("in-plane", "0", "0", "1"), ("lower-plate", "1", "1", "0"), ("upper-plate", "0", "1", "0")}


def test_a_frame_deforms_as_the_case_says_and_keeps_its_plane():
    root, case = deck("frame-shear"), ngcell.read_case("frame-shear")
    (moved,) = root.findall("Boundary/bc[@type='prescribed deformation']")
    gradient = np.array([float(word) for word in str(moved.findtext("F")).split(",")]).reshape(3, 3)
    expected = np.eye(3)
    expected[:2, :2] += case.level_factors[-1] * (np.array(case.load.final_gradient) - np.eye(2))
    np.testing.assert_allclose(gradient, expected, atol=1e-12)
    sets = {each.get("name"): numbers(each) for each in root.iter("NodeSet")}
    assert not np.isin(sets["frame"], sets["in-plane"]).any()
    assert len(sets["frame"]) + len(sets["in-plane"]) == len(nodes(root))


def test_pressures_press_on_the_lumens_of_their_cells():
    root, tissue = deck("shear-pressurised"), built("shear-pressurised")
    case, place = ngcell.read_case("shear-pressurised"), nodes(root)
    (load,) = root.findall("Loads/surface_load")
    value = float(str(load.findtext("pressure")))
    assert value == pytest.approx(case.lumen.pressure * (1 if case.lumen.ramp == "first" else case.level_factors[-1]))
    (surface,) = [each for each in root.iter("Surface") if each.get("name") == load.get("surface")]
    faces = np.array([numbers(face) - 1 for face in surface])
    along = place[faces[:, 1], :2] - place[faces[:, 0], :2]
    outward = np.column_stack([along[:, 1], -along[:, 0]])
    found = [each for each in root.iter("Surface") if "-outline" in str(each.get("name"))]
    outlines = [[numbers(face) - 1 for face in each] for each in found]
    centres = np.array([place[np.array(outline), :2].mean((0, 1)) for outline in outlines])
    middle = place[faces[:, :2], :2].mean(1)
    own = centres[np.argmin(np.linalg.norm(middle[:, None] - centres[None], axis=2), axis=1)]
    # Seen from the wall, outwards is into the lumen: towards the centre of the cell.
    assert (((own - middle) * outward).sum(1) > 0).all()
    lumens = ngsolve.Integrate(1, tissue.bodies.mesh.Boundaries("lumen.*"))
    assert np.linalg.norm(along, axis=1).sum() == pytest.approx(lumens, rel=1e-2)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_febios_law_with_the_decks_constants_is_ours(seed):
    """FEBio: dev part 2/J dev((c1 + c2 I1) B - c2 B^2) with B = J^(-2/3) F F^T, and the pressure k ln(J) / J."""
    for material in deck("shear-filled").iter("material"):
        k, c1, c2 = (float(str(material.findtext(name))) for name in ("k", "c1", "c2"))
        case = ngcell.read_case("shear-filled")
        law: MooneyRivlin = case.material if material.get("name") == "wall" else case.lumen.material
        gradient = np.eye(3) + 0.3 * np.random.default_rng(seed).standard_normal((3, 3))
        gradient *= np.sign(np.linalg.det(gradient))
        jacobian = np.linalg.det(gradient)
        left = gradient @ gradient.T * jacobian ** (-2 / 3)
        inner = (c1 + c2 * np.trace(left)) * left - c2 * left @ left
        deviator = inner - np.trace(inner) / 3 * np.eye(3)
        stress = 2 / jacobian * deviator + k * np.log(jacobian) / jacobian * np.eye(3)
        np.testing.assert_allclose(stress, law.cauchy_stress(gradient[None])[0], atol=1e-12 * np.abs(stress).max())


@pytest.mark.parametrize("name", ["exponential", "quadratic"])
def test_febios_fibres_with_the_decks_constants_and_axes_are_ours(name):
    """FEBio: 2/J ksi (I4 - 1)^(beta - 1) exp(alpha (I4 - 1)^beta) (F n) (F n) of each fibre in tension."""
    sets = () if name == "exponential" else ('material.fibres={kind="quadratic", stiffness=2.0, angles=[30.0, -30.0]}',)
    root, tissue = deck("shear-fibres", *sets), built("shear-fibres", *sets)
    along, law = along_walls(tissue.bodies.mesh), ngcell.read_case("shear-fibres", sets).material
    random, owner, count = np.random.default_rng(0), {}, len(root.findall("Mesh/Elements/elem"))
    for part in root.findall("Mesh/Elements"):
        body = tissue.bodies.body_names.index(str(part.get("name")).split("-")[0])
        owner[part.get("name")] = np.repeat(np.flatnonzero(tissue.bodies.body_of_element == body), count // len(along))
    axes = [(element, owner[data.get("elem_set")][int(element.get("lid", 0)) - 1])
            for data in root.iter("ElementData") for element in data]  # fmt: skip
    assert len(axes) == count
    for element, planar in (axes[number] for number in random.integers(len(axes), size=20)):
        a, d = (np.array([float(word) for word in str(element.findtext(tag)).split(",")]) for tag in "ad")
        np.testing.assert_allclose(a[:2], along[planar], atol=1e-9)
        third = np.cross(a, d)
        frame = np.column_stack([a, np.cross(third, a), third])
        gradient = np.eye(3)
        gradient[:2, :2] += 0.3 * random.standard_normal((2, 2))
        stress, jacobian = np.zeros((3, 3)), np.linalg.det(gradient)
        for family in root.findall("Material/material/solid[@type='fiber-exp-pow']"):
            alpha, beta, ksi = (float(str(family.findtext(word))) for word in ("alpha", "beta", "ksi"))
            moved = gradient @ frame @ np.array([float(word) for word in str(family.findtext("fiber")).split(",")])
            strain = max(moved @ moved - 1, 0.0)
            stress += 2 / jacobian * ksi * strain ** (beta - 1) * np.exp(alpha * strain**beta) * np.outer(moved, moved)
        ours = law.fibres.cauchy_stress(gradient[None], along[planar][None])[0]
        np.testing.assert_allclose(stress, ours, atol=1e-9 * max(np.abs(ours).max(), 1))


def test_fluids_keep_the_volume_of_each_lumen():
    root, tissue = deck("shear-fluid"), built("shear-fluid")
    place = nodes(root)
    surfaces = {each.get("name"): np.array([numbers(face) - 1 for face in each]) for each in root.iter("Surface")}
    (fluid,) = [term for term in tissue.discretisation.terms if isinstance(term, LumenFluids)]
    found = root.findall("Constraints/constraint[@type='volume']")
    assert len(found) == len(fluid.area) == tissue.bodies.body_count
    for constraint, area in zip(found, fluid.area, strict=True):
        faces = surfaces[constraint.get("surface")]
        one, two = (place[faces[:, number], :2] for number in (0, 1))
        # Sides seen from the wall run clockwise around the lumen.
        assert -(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]).sum() / 2 == pytest.approx(area, rel=1e-2)
        assert place[faces[:, 2], 2] - place[faces[:, 1], 2] == pytest.approx(place[:, 2].max())


REFUSED = [
    (("shear-fluid", "--set", "lumen.fill=1.1"), "lumen.fill = 1.1"),
    (("shear-cohesive",), "cohesion"),
    (("press-fit",), "bodies"),
    (("shear-empty-3d",), "tissue.height"),
]


@pytest.mark.parametrize(("case", "what"), REFUSED)
def test_what_cannot_be_exported_is_named_in_one_line(case, what, tmp_path):
    file = tmp_path / "tissue.feb"
    answer = CliRunner().invoke(command, ["export-febio", *case, "--out", str(file)])
    assert answer.exit_code == 3 and not file.exists()
    (line,) = answer.output.strip().splitlines()
    assert what in line and "allowed:" in line


def test_a_deck_ends_with_feb(tmp_path):
    answer = CliRunner().invoke(command, ["export-febio", "shear-empty-3x3", "--out", str(tmp_path / "tissue.xml")])
    assert answer.exit_code == 2 and ".feb" in answer.output


def test_an_indenter_is_paired_with_all_cells_that_have_outer_walls():
    load = "load={kind='indenter', shape='disc', radius=1.0, depth=0.1}"
    root = deck("shear-empty-3x3", load, "strategy.kind='single-step'", "expected=[]", "accuracy=0.1")
    pairs = {tuple(str(pair.get("name")).split("-")[1:]) for pair in root.iter("SurfacePair")}
    assert {one for one, two in pairs if two == "indenter"} == {f"cell{cell}" for cell in range(9) if cell != 4}
    contacts = {each.get("surface_pair") for each in root.iter("contact")}
    assert contacts == {pair.get("name") for pair in root.iter("SurfacePair")}
