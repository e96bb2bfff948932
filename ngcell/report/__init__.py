"""The report of results: one HTML file, without anything to load from elsewhere."""

from ngcell.report.page import REPORT, Report, write_report

__all__ = ["REPORT", "Report", "write_report"]
