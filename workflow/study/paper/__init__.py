"""The paper: the numbers that it quotes, and its typesetting."""
