"""Bodies from Python, recorded into a result folder, as `hostile` runs them.

    python -m tools.extreme hostile-python SPEC FOLDER

SPEC is a JSON file with polygons, their materials, and which of their edges are held or moved. It ends with the exit
code of `ngcell solve`.
"""

from __future__ import annotations

import json
import sys
from math import inf
from pathlib import Path
from typing import Any

import click
from netgen import occ

import ngcell
from ngcell.errors import NgcellError, NotConverged
from tools.commands import described


@described(__doc__)
@click.argument("spec", type=click.Path(path_type=Path))
@click.argument("folder", type=click.Path(path_type=Path))
def command(spec: Path, folder: Path) -> None:
    """Run SPEC into FOLDER."""
    table = json.loads(spec.read_text(encoding="utf-8"))
    try:
        recording = ngcell.record(scene_of(table), folder, threads=1)
        for _ in recording:
            pass
    except NgcellError as error:
        click.echo(str(error), err=True)
        sys.exit(error.exit_code)
    sys.exit(0 if recording.certified else NotConverged.exit_code)


def scene_of(table: dict[str, Any]) -> ngcell.BodyScene:
    """Return the scene of a table: its bodies, and what holds them."""
    bodies = [
        ngcell.Body(_face(body, table["held"]), ngcell.MooneyRivlin(**_constants(body)), body["name"])
        for body in table["bodies"]
    ]
    supports = [ngcell.BodySupport(f"{held['body']}-held", translation=tuple(held["move"])) for held in table["held"]]
    return ngcell.BodyScene(
        tuple(bodies), tuple(supports), size=table["size"], order=table["order"], levels=table["levels"], accuracy=inf
    )


def _constants(body: dict[str, Any]) -> dict[str, float]:
    return {name: value for name, value in body["material"].items() if name != "kind"}


def _face(body: dict[str, Any], held: list[dict[str, Any]]) -> occ.Face:
    """Return the face of a polygon, its corners counter-clockwise; edges at the height of a support get its name."""
    corners = [tuple(map(float, corner)) for corner in body["corners"]]
    if sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(corners, corners[1:] + corners[:1], strict=True)) < 0:
        corners = corners[::-1]
    line = occ.MoveTo(*corners[0])
    for corner in corners[1:]:
        line = line.LineTo(*corner)
    face = line.Close().Face()
    for support in held:
        for edge in face.edges:
            if support["body"] == body["name"] and abs(edge.center.y - support["y"]) < 1e-9:
                edge.name = f"{body['name']}-held"
    return face
