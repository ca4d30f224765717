"""What an earlier run found is used again after a correction or a further click.

Comes in: what the earlier run left, and what was placed since. Goes out: the stretch of frames that
is tracked anew (``retracking``), and the evidence that need not be found again (``kept_evidence``).
"""
