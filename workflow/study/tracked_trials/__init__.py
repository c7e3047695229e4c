"""The tracked trials: simulated arms before a tracker or with a probe, with effects of known size, diagnosed blind and scored.

The arms are simulated by elementary matrices and point masses (``study.common.kinematics``, ``flawed_arm``), which share no formula with
the estimator. Beside the effects, what the dataset states about the noise is varied: right, a fifth, three times, nothing.
"""
