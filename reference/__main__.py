"""``python -m restir_gi.reference`` is ``restir``."""

import sys

from restir_gi.reference.cli.main import main

if __name__ == "__main__":  # documentation tools import every module
    sys.exit(main())
