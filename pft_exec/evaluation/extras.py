"""Packages that only baselines need: the extra ``evaluation`` installs them, and who lacks them is told so at once."""

from __future__ import annotations

from importlib.util import find_spec

from pft_exec.exceptions import MissingPackageError

BASELINES = {"hmmlearn": "hmmlearn", "movement_primitives": "movement-primitives"}
"""Module to package."""


def check_baselines() -> None:
    """Make sure that the packages of the baselines are installed.

    Raises
    ------
    MissingPackageError
        If one is not.
    """
    missing = [package for module, package in BASELINES.items() if find_spec(module) is None]
    if missing:
        raise MissingPackageError(
            f"the baselines need {' and '.join(missing)}: "
            "run ./scripts/setup dev, or pip install 'pft_exec[evaluation]'."
        )
