"""Error against run time: one runner for exact problems, tissues, strategies and peers."""

from tools.studies.work_precision.study import command as command
