"""PyBullet's first import, without the line about its build that it writes to standard error.

Imported before anything else of this folder: whoever reads standard error finds only what concerns them.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module


def import_without_banner(name: str) -> None:
    """Import a module while the process's standard error, below Python, leads nowhere."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        import_module(name)
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


import_without_banner("pybullet")
