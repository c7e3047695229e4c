"""The blind trials: effects and gross errors are injected into simulated workcells, which are diagnosed blind; the answers are scored.

The simulator injects by its own physics (``scalar.simulation``); the diagnosis is given a ``Dataset`` and nothing else. There are two designs. In
the first (``cases``, ``run``, ``score``, ``summaries``, ``benefit``, ``numbers``), each effect is injected in several sizes. In the second, the
stratified one (modules ``stratified_*``), sets cross scanners, surfaces, effects, numbers of poses and robots.
"""
