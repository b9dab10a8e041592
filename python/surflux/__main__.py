"""`python -m surflux` is the command line."""

import sys

from surflux.cli import main

sys.exit(main())
