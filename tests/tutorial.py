"""Runs the commands of a page such as docs/tutorial.md and compares what they print.

Blocks of TOML and Python that begin with `# NAME.toml` or `# NAME.py` are written as files; in blocks of `console` each line that begins with `$ ` is run, and
the lines below it have to come in its output, in that order. `...` stands for any lines. Words are compared as they are, numbers
to 2 %, and those of lines that speak of time or memory not at all.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

SUFFIXES = {"toml": ".toml", "python": ".py"}
NUMBER = re.compile(r"-?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?")
CHANGES = re.compile(r" ms a step|steps/s|\bMB\b|\bCPU s|ns per cell|us per cell|^cost |^[a-z]+ +\d+\.\d( +\d+\.\d %)?$")


def blocks(text):
    """The blocks of a page: (language, lines)."""
    for language, body in re.findall(r"^```(\w+)\n(.*?)^```$", text, re.M | re.S):
        yield language, body.rstrip("\n").split("\n")


def alike(expected, found):
    """Whether a line is the one that the page prints."""
    if NUMBER.sub("#", expected).split() != NUMBER.sub("#", found).split():
        return False
    if CHANGES.search(expected) or expected.lstrip().startswith("| "):
        pairs = []
    else:
        pairs = zip(NUMBER.findall(expected), NUMBER.findall(found))
    values = [(float(a.replace(",", "")), float(b.replace(",", ""))) for a, b in pairs]
    return all(abs(a - b) <= 0.02 * abs(a) + 1e-12 for a, b in values)


def missing(expected, found):
    """The first line of the page that does not come in the output, in order."""
    rest = iter(found)
    for line in expected:
        if line.strip() in ("", "..."):
            continue
        if not any(alike(line, other) for other in rest):
            return line
    return None


def main(page, mics, folder):
    os.environ["PATH"] = f"{mics.parent}:{os.environ['PATH']}"
    wrong, count = [], 0
    for language, lines in blocks(page.read_text()):
        if language in SUFFIXES and lines[0].startswith("# ") and lines[0].endswith(SUFFIXES[language]):
            (folder / lines[0][2:]).write_text("\n".join(lines) + "\n")
        if language != "console":
            continue
        commands = [k for k, line in enumerate(lines) if line.startswith("$ ")] + [len(lines)]
        for start, end in zip(commands, commands[1:]):
            command = lines[start][2:]
            done = subprocess.run(command, shell=True, cwd=folder, text=True, capture_output=True)
            count += 1
            said = (done.stdout + done.stderr).split("\n")
            line = missing(lines[start + 1 : end], said)
            if done.returncode != 0 or line is not None:
                why = f"ended with {done.returncode}" if done.returncode else f"does not print `{line}`"
                wrong.append(f"`{command}` {why}:\n  " + "\n  ".join(said))
    print(f"{count} commands of {page}, {len(wrong)} not as printed")
    print("\n".join(wrong))
    return 1 if wrong or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main(*(Path(given).absolute() for given in sys.argv[1:])))
