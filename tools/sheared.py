"""Runs of the sheared tissue that figures, curves and certificates share, by what holds the cells together."""

from __future__ import annotations

from tools.runs import Run

#: Plate displacements, as shares of the last, which is a fifth of the tissue's height.
LEVELS = "[0.03125, 0.0625, 0.09375, 0.125, 0.25, 0.5, 1.0]"
#: Those of `single-step`, which ends at the same equilibria, and of large scenes that cost much or are in no figure.
FEW_LEVELS = "[0.0625, 0.125, 0.25, 1.0]"
DEAR = ("c1=0.02", "c1=0.05", "c1=0.1", "shear-fibres", "shear-uniform-pressure")
TISSUES = {"3x3": (3, 3, 1.0), "5x7": (5, 7, 1.6)}
BOTH, SDDP = ("sddp", "single-step"), ("sddp",)
#: Strategies of tissues with cohesion, where steps have a history.
BONDED = ("sddp", "load-stepping")
STRENGTHS, ENERGY_OVER_STRENGTH = (0.0125, 0.025, 0.05), 0.03

#: Case, settings and label of a curve.
Curve = tuple[str, str, str]


def pressures() -> list[Curve]:
    """Return a curve a cell pressure."""
    values = (0.00125, 0.0025, 0.005, 0.01)
    return [("shear-pressurised", f"lumen.pressure={value}", f"pressure {value}") for value in values]


def inclusions() -> list[Curve]:
    """Return a curve a shear modulus, with bulk moduli a thousand times it."""
    values = (0.01, 0.02, 0.05, 0.1)
    keys = "lumen.material.c1={0}; lumen.material.bulk_modulus={1:g}"
    return [("shear-filled", keys.format(value, 1000 * value), f"modulus {value}") for value in values]


def fibres() -> list[Curve]:
    """Return a curve an angle of the fibres."""
    pair = "material.fibres.angles=[{0}.0, -{0}.0]"
    return [("shear-fibres", pair.format(angle), f"fibres at {angle} degrees") for angle in (0, 30, 60)]


def bonded(strength: float) -> str:
    """Return the settings of a cohesive strength; bonds of all strengths are strongest at the same opening."""
    return f"cohesion.strength={strength}; cohesion.energy={ENERGY_OVER_STRENGTH * strength:g}"


def run_of(tissue: str, case: str, settings: str, strategy: str) -> Run:
    """Return the run behind a curve without cohesion."""
    rows, cols, displacement = TISSUES[tissue]
    scene = [f"tissue.rows={rows}", f"tissue.cols={cols}", f"load.displacement=[{displacement}, 0.0]"]
    scene = scene if tissue == "3x3" else []  # the shipped cases are the larger tissue
    is_dear = tissue == "5x7" and any(text in f"{case} {settings}" for text in DEAR)
    levels = FEW_LEVELS if is_dear or strategy != "sddp" else LEVELS
    entries = (*settings.split("; "), *scene, f"strategy.kind={strategy}", f"load.levels={levels}")
    return Run(case, tuple(entry for entry in entries if entry))


def large_run(case: str, settings: str, strategy: str) -> Run:
    """Return the run of the 5x7 tissue; SDDP with cohesion has every second level: none depends on another."""
    if case != "shear-cohesive":
        return run_of("5x7", case, settings, strategy)
    levels = ("load.levels=4",) if strategy == "sddp" else ()
    return Run(case, (*settings.split("; "), f"strategy.kind={strategy}", *levels))
