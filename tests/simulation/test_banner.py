"""Importing the simulator writes nothing."""

from __future__ import annotations

import subprocess
import sys


def test_the_simulator_is_imported_without_a_word_and_standard_error_still_works() -> None:
    code = "import pft_exec.simulation, sys; print('heard', file=sys.stderr)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (result.stdout, result.stderr) == ("", "heard\n")
