"""The examples in the package's docstrings are true."""

from __future__ import annotations

import doctest
import importlib

import pytest


# Exceptions bear the package's own name: their examples are found there.
@pytest.mark.parametrize("name, least", [("luxmc", 8), ("luxmc._scene", 6), ("luxmc._solve", 5), ("luxmc._words", 3)])
def test_examples(name: str, least: int) -> None:
    failed, tried = doctest.testmod(importlib.import_module(name))
    assert failed == 0
    assert tried >= least
