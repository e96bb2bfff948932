"""Why points of `tools.extreme` that have a solution are not certified, by how their labels start."""

from __future__ import annotations

CAUSES: dict[str, str] = {}
