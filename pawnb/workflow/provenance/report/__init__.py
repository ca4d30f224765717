"""Pages a person reads: the index of a folder of gait results, and the report of a study.

Comes in: tables, figures and their record. Goes out: pages of HTML. ``words`` say what each file
is, ``methods_text`` what was done, ``html`` lays out; ``index_page`` is written with every gait
analysis, ``report`` makes one page that needs no other file.
"""

from pawnb import _lazy

_HOME = {"write_report": "pawnb.workflow.provenance.report.report"}

__all__ = ["html", "index_page", "methods_text", "report", "tracking_text", "words", "write_report"]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
