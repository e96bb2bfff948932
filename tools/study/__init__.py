"""Error against run time: one runner for exact problems, tissues, strategies and peers (`python -m tools.study`)."""
