"""Illuminances through openings after CIE 171:2006, cases 5.9 to 5.12, under its other fourteen general skies: by openings.py, beside this folder."""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from openings import write_case  # noqa: E402

write_case(HERE, [kind for kind in range(1, 16) if kind != 5], "0.2%", {"true_error": "0.3%"}, ["sky"])
