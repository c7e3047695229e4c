"""What the documentation makes of the code when it is built: pages of effects and commands, keys of a mapping, and formulas in MathML."""
