"""The tracked trials: simulated arms before a tracker or with a probe, with effects of known size, diagnosed blind and scored.

The arms are simulated by elementary matrices and point masses (``study.common.kinematics``, ``flawed_arm``), which share no formula with
the estimator. Besides the effects, the noise that the dataset states is varied: the true one, a fifth of it, three times as much, or none.
"""
