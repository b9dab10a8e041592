"""`python -m surflux` is the command line."""

import sys

from surflux.cli.commands import main

sys.exit(main())
