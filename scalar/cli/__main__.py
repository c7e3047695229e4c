"""``python -m scalar.cli``."""

from scalar.cli import main

main()
