"""A calibration in the forms that other software reads: URDF, UR's kinematics.yaml, DH tables."""
