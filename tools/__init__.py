"""What the project is measured with: `references` gives answers a second way, `studies` asks what results depend on
and what they cost, `extreme` maps scenes far outside comfort. Each is called as ``python -m tools.PACKAGE COMMAND``.
"""
