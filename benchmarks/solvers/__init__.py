"""The same fit by solvers that are no part of the project's environment: Ceres in C++, and JAX."""
