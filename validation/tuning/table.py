#!/usr/bin/env python3
"""Writes docs/tuned.md: every number of the engine that was chosen by trying or by judgement, with what it does and what 30 % of it cost.

    python3 validation/tuning/table.py

What each number is stands in kinds.txt, what it does in the comment above it in the code, what 30 % of it cost in measured.csv, which
measure.py writes.
"""
import csv
import math
import re
from collections import defaultdict
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TUNED = ("speed", "forecast", "model")
CONSTANT = re.compile(r"^(?:pub(?:\([a-z]+\))? )?const (\w+): [^=]+ = (.*);$")


def kinds():
    """(file, name) → kind, in the list's order."""
    found = {}
    for line in (HERE / "kinds.txt").read_text().splitlines():
        if line.startswith("#") or not line.strip():
            continue
        file, groups = line.split(": ", 1)
        for group in groups.split("; "):
            kind, *names = group.split()
            found.update({(file, name): kind for name in names})
    return found


def constants(file):
    """Name → (value, what the comment says), of a file; a comment holds for the constants below it that have none of their own."""
    comment, in_comment, found = [], False, {}
    for line in (ROOT / "src" / file).read_text().splitlines():
        if line.startswith("///"):
            comment = (comment if in_comment else []) + [line[3:].strip()]
            in_comment = True
            continue
        in_comment = False
        match = CONSTANT.match(line)
        if match:
            found[match[1]] = (match[2], " ".join(comment))
        elif line.strip() and not line.startswith("#["):
            comment = []
    return found


def costs():
    """(file, name) → text on what 30 % less and 30 % more of it cost."""
    path = HERE / "measured.csv"
    works = defaultdict(dict)
    if path.exists():
        for row in csv.DictReader(path.open()):
            works[row["file"], row["name"]].setdefault(row["factor"], []).append((float(row["work_over_usual"]), row["case"]))
    texts = {}
    for key, factors in works.items():
        parts = []
        for factor in sorted(factors, key=float):
            ratios = factors[factor]
            mean = math.exp(sum(math.log(ratio) for ratio, _ in ratios) / len(ratios))
            worst, room = max(ratios)
            parts.append(f"× {factor}: {100 * (mean - 1):+.1f} % (at worst {100 * (worst - 1):+.1f} %, {room})")
        texts[key] = "; ".join(parts)
    return texts


def main():
    listed, measured = kinds(), costs()
    rows = defaultdict(list)
    for (file, name), kind in listed.items():
        if kind in TUNED:
            value, comment = constants(file)[name]
            source = "measured, see there" if "easured" in comment else "judgement"
            cost = measured.get((file, name), "not measured")
            what = comment.replace("|", "\\|")
            rows[file.split("/")[0]].append(f"| `{file}` `{name}` | {value} | {kind} | {what} | {source} | {cost} |")
    count = sum(map(len, rows.values()))
    text = (HERE / "head.md").read_text().format(count=count, all=len(listed), measured=len(measured))
    for room, lines in rows.items():
        text += f"\n## {room}\n\n| number | value | kind | what it is | from | 30 % less and more |\n| --- | --- | --- | --- | --- | --- |\n"
        text += "\n".join(lines) + "\n"
    (ROOT / "docs" / "tuned.md").write_text(text)


if __name__ == "__main__":
    main()
