"""MuJoCo models as bodies: what a leg can feel is observed, and many are stepped side by side.

Needs the extra `mujoco`.
"""
