"""Labels of the points, from which `map --only TEXT` chooses.

python -m tools.extreme list [--quick]
"""

from __future__ import annotations

import click

from tools.commands import described
from tools.extreme.points import points


@described(__doc__)
@click.option("--quick", is_flag=True, help="Those that are tried often.")
def command(quick: bool) -> None:
    """Print a label a line."""
    click.echo("\n".join(point.label for point in points() if point.is_quick or not quick))
