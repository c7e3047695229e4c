"""The real-arm trials: what campaigns with real arms record and suffer, injected at three sizes, diagnosed blind and scored.

Angles that are logged before the arm has settled, friction with a memory, play by the moves, compliance by measured torques, deflection under a
payload, warm-up that restarts after stops, a tracker that drifts, an error of one joint over two angles, and a linear axis with errors of
its own. All are injected by the simulator's physics (``scalar.simulation.injected``), alone and beside two others.
"""
