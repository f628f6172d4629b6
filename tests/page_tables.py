"""Compares the tables of the pages in cases/ with the studies that make them, or writes them.

A table that a study makes stands below a line `<!-- mics study FILE -->`. Its columns are some of those of the study's study.md, in
their order there. A number has moved where it differs by more than 0.5 % of itself, a percentage by more than 0.1; where the table of
the page has other columns than there are, or other rows, that is said.
"""

import re
import subprocess
import sys
from pathlib import Path

MARK = re.compile(r"^<!-- mics study (\S+) -->\n+((?:\|.*\n)+)", re.M)


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def fresh(study, mics, out):
    """Header and rows of a study's study.md, after running it; runs that are done are kept."""
    folder = out / study.replace("/", "-").removesuffix(".study.toml")
    subprocess.run([mics, "study", study, "--out", folder], check=True, stdout=subprocess.DEVNULL)
    header, _, *rows = [line for line in (folder / "study.md").read_text().splitlines() if line.startswith("|")]
    return cells(header), [cells(row) for row in rows]


def chosen(wanted, there):
    """Where the wanted columns are among those that are there, in order."""
    places, at = [], 0
    for name in wanted:
        at = there.index(name, at)
        places.append(at)
        at += 1
    return places


def moved(old, new):
    if old == new:
        return False
    try:
        a, b = (float(text.removesuffix(" %")) for text in (old, new))
    except ValueError:
        return True
    # What is zero but for rounding is as good as any other such number.
    return abs(a - b) > (0.1 if old.endswith("%") else max(0.005 * abs(a), 1e-9))


def main(mics, out, options):
    write, some = "--write" in options, [name for name in options if name != "--write"]
    news, count = [], 0
    for page in sorted(Path("cases").glob("*/README.md")):
        text = page.read_text()
        for match in list(MARK.finditer(text)):
            study, table = match[1], match[2].splitlines()
            if some and study not in some:
                continue
            count += 1
            there, rows = fresh(study, mics, out)
            wanted = cells(table[0])
            try:
                places = chosen(wanted, there)
            except ValueError as error:
                news.append(f"{page}: {study} has no such column: {error}")
                continue
            now = [[row[place] for place in places] for row in rows]
            before = [cells(line) for line in table[2:]]
            if len(now) != len(before):
                news.append(f"{page}: {study} has {len(now)} rows, the page {len(before)}")
            for old, new in zip(before, now):
                differ = [f"{name} {b}, was {a}" for name, a, b in zip(wanted, old, new) if moved(a, b)]
                if differ:
                    news.append(f"{page}: {study}, {', '.join(old[:2])}: {'; '.join(differ)}")
            if write:
                lines = table[:2] + ["| " + " | ".join(row) + " |" for row in now]
                text = text.replace(match[2], "\n".join(lines) + "\n")
        if write:
            page.write_text(text)
    print(f"{count} tables, {len(news)} rows moved")
    print("\n".join(news))
    return 1 if count == 0 or (news and not write) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:]))
