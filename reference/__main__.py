"""``python -m reference`` is ``restir``."""

import sys

from reference.cli.main import main

if __name__ == "__main__":  # documentation tools import every module
    sys.exit(main())
