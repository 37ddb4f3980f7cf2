"""``python -m reference`` is ``restir``."""

import sys

from reference.cli import main

sys.exit(main())
