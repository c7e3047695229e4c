"""Run the command line by ``python -m scalar.cli``."""

from scalar.cli import main

main()
