"""Illuminances through openings after CIE 171:2006, cases 5.9 to 5.12, under its uniform (type 5) and overcast (type 16) skies: by openings.py, beside this folder."""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from openings import write_case  # noqa: E402

write_case(HERE, [5, 16], "0.1%", {"worst": "0.3%"}, ["all", "sky"])
