"""Runs the blocks of Python of a page, in order and as one program, in the folder that it is started in."""

import re
import sys
from pathlib import Path

page = Path(sys.argv[1])
text = page.read_text()
names = {}
found = list(re.finditer(r"^```python\n(.*?)^```$", text, re.M | re.S))
for block in found:
    # Errors name the line of the page.
    before = text.count("\n", 0, block.start(1))
    exec(compile("\n" * before + block[1], page, "exec"), names)
if len(found) < 5:
    sys.exit(f"{page}: {len(found)} blocks of Python")
print(f"{page}: {len(found)} blocks ran")
