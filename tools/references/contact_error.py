"""What contact costs in accuracy: rings beside their one-dimensional solution.

    python -m tools.references contact-error          all rings with all contact methods, into tools/results

Every ring is solved as a case that names nothing but bodies, supports and loads: sizes and stiffness are the defaults
at accuracy 0.01, and orders are, too, or 3. The rings were chosen before anything was computed. A penalty is held to a
quarter of the accuracy in radii, gaps and pressures, the mortar method to 2e-4.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import process_time
from typing import Any

import click

import ngcell
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.references import radial

#: What is asked of methods: a share of the default accuracy, and a number.
LIMIT = {"penalty": 2.5e-3, "ngsolve": 2.5e-3, "mortar": 2e-4}
COLUMNS = ("rings", "contact", "order", "radii", "gap", "pressure", "estimated", "certified", "unknowns", "seconds")


@dataclass(frozen=True)
class Rings:
    """A ring in another one.

    Attributes
    ----------
    inner, outer : tuple of float
        Radii of bore and rim [length].
    moduli : tuple of float
        Shear moduli of the inner and of the outer ring [stress]; kappa / mu = 100.
    pressure : float, optional
        Pressure in the inner ring [stress].
    pulled : float, optional
        Radius that the rim of the outer ring is pulled to [length].
    """

    inner: tuple[float, float]
    outer: tuple[float, float]
    moduli: tuple[float, float] = (1.0, 1.0)
    pressure: float | None = None
    pulled: float | None = None

    @property
    def exact(self) -> radial.NestedState:
        """The one-dimensional solution."""
        solids = [radial.RadialSolid(modulus / 2, modulus / 2, 100 * modulus) for modulus in self.moduli]
        rings = [radial.Ring(solid, *radii) for solid, radii in zip(solids, (self.inner, self.outer), strict=True)]
        if self.pulled is not None:
            return radial.pulled_apart(rings[0], rings[1], self.pulled)
        if self.pressure is not None:
            return radial.closing(rings[0], rings[1], self.pressure)
        return radial.press_fit(rings[0], rings[1])

    def text(self, contact: str, order: int | None = None) -> str:
        """Return the case as TOML; meshes of a given order are kept, others refined until the accuracy is met."""
        lines = ["levels = 1", f'contact.kind = "{contact}"', *([f"mesh.order = {order}"] if order else [])]
        lines += ["expected = ["]
        told = 'tolerance = 1.0, origin = "python -m tools.references radial"'
        lines += [f"{{ {what}, value = {value:.12g}, {told} }}," for what, value in self._wanted]
        lines += ["]"]
        for name, radii, modulus, wall in zip(
            ("inner", "outer"), (self.inner, self.outer), self.moduli, ("outer", "inner"), strict=True
        ):
            constants = f"c1 = {modulus / 2}, c2 = {modulus / 2}, bulk_modulus = {100 * modulus}"
            lines += ["[[bodies]]", f'name = "{name}"', 'kind = "ring"', 'part = "upper-right"', f'walls = ["{wall}"]']
            lines += [f"inner = {radii[0]}", f"outer = {radii[1]}"]
            lines += [f'material = {{ kind = "mooney-rivlin", {constants} }}']
            for side, component in (("x0", "x"), ("y0", "y")):
                lines += ["[[supports]]", f'boundary = "{name}_{side}"', f'components = "{component}"']
        if self.pulled is not None:
            growth = self.pulled / self.outer[1] - 1
            lines += ["[[supports]]", 'boundary = "outer_outer"', f"gradient = [[{growth}, 0.0], [0.0, {growth}]]"]
        if self.pressure is not None:
            lines += ["[[loads]]", 'kind = "pressure"', 'boundary = "inner_inner"', f"value = {self.pressure}"]
        return "\n".join(lines) + "\n"

    @property
    def _wanted(self) -> list[tuple[str, float]]:
        state, between = self.exact, 'between = ["inner_outer", "outer_inner"]'
        radii = {"inner_inner": state.inside.inner, "inner_outer": state.inside.outer}
        radii |= {"outer_inner": state.outside.inner, "outer_outer": state.outside.outer}
        wanted = [(f'quantity = "mean_radius", boundary = "{name}"', radius) for name, radius in radii.items()]
        if self.pulled is not None:
            return [*wanted, (f'quantity = "gap", {between}', state.gap)]
        return [*wanted, (f'quantity = "contact_pressure", {between}', state.contact_pressure)]


#: A hub five times stiffer, a jacket five times stiffer, thin rings, rings that part, rings that close under pressure.
RINGS = {
    "stiff hub": Rings((0.3, 1.0), (0.93, 1.6), moduli=(5.0, 1.0)),
    "stiff jacket": Rings((0.5, 1.0), (0.95, 1.3), moduli=(1.0, 5.0)),
    "thin": Rings((0.9, 1.0), (0.97, 1.07)),
    "parting": Rings((0.4, 1.0), (1.0, 1.45), moduli=(1.0, 2.0), pulled=1.6),
    "closing": Rings((0.6, 1.0), (1.05, 1.4), moduli=(1.0, 2.0), pressure=0.5),
}


def found(rings: Rings, contact: str, order: int | None = None) -> dict[str, Any]:
    """Return relative errors of the last step: of all radii, of the gap and of the contact pressure."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "rings.toml")
        file.write_text(rings.text(contact, order), encoding="utf-8")
        started = process_time()
        *_, last = ngcell.simulate(ngcell.read_case(file))
        seconds = process_time() - started
    errors: dict[str, float] = {}
    for finding in last.findings:
        error = abs(finding.measured / finding.expected - 1)
        errors[finding.quantity] = max(error, errors.get(finding.quantity, 0.0))
    record = last.record
    return {
        "radii": errors["mean_radius"],
        "gap": errors.get("gap", ""),
        "pressure": errors.get("contact_pressure", ""),
        "estimated": record.contact_force_error / record.contact_force if record.contact_force else "",
        "certified": record.certified,
        "unknowns": last.mesh.unknowns,
        "seconds": round(seconds, 2),
    }


@described(__doc__)
def command() -> None:
    """Solve all rings and write the tables."""
    rows = []
    for name, rings in RINGS.items():
        for contact, order in product(LIMIT, (None, 3)):
            rows.append({"rings": name, "contact": contact, "order": order or "", **found(rings, contact, order)})
            click.echo(str(rows[-1]), err=True)
    tables.write(RESULTS / "contact-error.csv", COLUMNS, rows)
    lines = [[_shown(row[column]) for column in COLUMNS] for row in rows]
    text = f"# Errors of contact\n\n{(__doc__ or '').splitlines()[0]}\n\n{tables.markdown(COLUMNS, lines)}\n"
    (RESULTS / "contact-error.md").write_text(text, encoding="utf-8")


def _shown(value: Any) -> str:
    return f"{value:.1e}" if isinstance(value, float) and value < 0.05 else str(value)
