"""Prints the first Python block of a page: snippet.py PAGE."""

import re
import sys

print(re.search(r"```python\n(.*?)```", open(sys.argv[1], encoding="utf-8").read(), re.S)[1], end="")
