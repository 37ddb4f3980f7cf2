"""One image judged against another: numbers, error maps, and a page to look at."""

from restir_gi.reference.reports.comparison.judge import Comparison, compare

__all__ = ["Comparison", "compare"]
