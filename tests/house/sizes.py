#!/usr/bin/env python3
"""Sizes of the house, for the table in docs/decisions.md: lines of every room, the longest functions and the widest parameter lists.

    python3 tests/house/sizes.py

Code of the library without its modules of tests; a function counts from its `fn` to its closing brace.
"""
import re
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[2] / "src"
TESTS = "#[cfg(test)]\nmod tests {"
FUNCTION = re.compile(r"( *)(?:pub(?:\([a-z]+\))? )?(?:const )?(?:unsafe )?fn (\w+)")


def parameters(signature):
    """Parameters between the first brackets of a signature."""
    depth, count, told = 0, 0, False
    text = signature[signature.index("("):]
    for place, letter in enumerate(text):
        if letter in ")]}" or (letter == ">" and text[place - 1] not in "-="):
            depth -= 1
            if depth == 0:
                return count + told
        elif letter in "([{<":
            depth += 1
        elif letter == "," and depth == 1:
            count, told = count + 1, False
        elif not letter.isspace():
            told = True
    return count + told


def functions(path):
    """Lines, parameters, and name of every function of a file."""
    lines = path.read_text().split(TESTS)[0].split("\n")
    for first, line in enumerate(lines):
        if found := FUNCTION.match(line):
            last = next((at for at in range(first, len(lines)) if lines[at].startswith(found[1] + "}")), first)
            yield last - first + 1, parameters(" ".join(lines[first:last + 1])), f"{found[2]} in {path.relative_to(SOURCES)}"


def main():
    files = sorted(SOURCES.rglob("*.rs"))
    rooms = {}
    for path in files:
        room = path.relative_to(SOURCES).parts[0]
        rooms[room] = rooms.get(room, 0) + len(path.read_text().splitlines())
    found = [function for path in files for function in functions(path)]
    print(f"{sum(rooms.values())} lines in {len(files)} files, {len(found)} functions")
    print(", ".join(f"{room} {lines}" for room, lines in sorted(rooms.items(), key=lambda entry: -entry[1])))
    for lines, _, name in sorted(found, reverse=True)[:5]:
        print(f"{lines} lines: {name}")
    widest = max(count for _, count, _ in found)
    print(f"{widest} parameters: {sum(count == widest for _, count, _ in found)} functions")


main()
