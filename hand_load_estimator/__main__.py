"""`python -m hand_load_estimator` is `hand_load`."""

import sys

from .cli import main

sys.exit(main())
