"""``python -m pawnb`` is the command ``pawnb``."""

import sys

from pawnb.cli import main

sys.exit(main())
