"""`python -m ngcell` is the command `ngcell`."""

from ngcell.cli import ngcell

if __name__ == "__main__":
    ngcell(prog_name="ngcell")
