"""The names of the committed tables of the blind trials that the paper reads in addition to ``numbers.json``.

They have a module of their own, so that the rules of the workflow, which list these files, import nothing slow.
"""

TABLES = ("by_scene", "power", "errors", "unknown", "nulls")
