"""Sweeps: many runs of one case along axes, on the cores of a machine or of a cluster, into one table.

A study is expanded into cases, each known by the content of its resolved text. A case whose result is in the store is
not run again. Those that are missing go to Dask in bounded windows; each runs in a process of its own, so that one that
dies costs itself only. The tables are made from the store, in the order of the cases.
"""
