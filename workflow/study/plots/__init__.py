"""The figures of the studies: each module draws tables that a study has written, and no study imports a module of this package."""
