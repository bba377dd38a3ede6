"""Named poses, and random ones."""

from types import MappingProxyType

from synthetic.pose import REST, Pose

HUMAN_POSES = MappingProxyType(
    {
        "rest": REST,
        "standing": Pose(
            (
                ("left_shoulder", (0.0, 0.0, -42.0)),
                ("right_shoulder", (0.0, 0.0, 42.0)),
                ("left_elbow", (0.0, -12.0, 0.0)),
                ("right_elbow", (0.0, 12.0, 0.0)),
                ("left_hip", (0.0, 0.0, 2.0)),
                ("right_hip", (0.0, 0.0, -2.0)),
            )
        ),
        "walking": Pose(
            (
                ("chest", (4.0, 10.0, 0.0)),
                ("left_shoulder", (32.0, 0.0, -38.0)),
                ("right_shoulder", (-32.0, 0.0, 38.0)),
                ("left_elbow", (-8.0, -18.0, 0.0)),
                ("right_elbow", (-30.0, 20.0, 0.0)),
                ("left_hip", (-34.0, 0.0, 3.0)),
                ("left_knee", (14.0, 0.0, 0.0)),
                ("right_hip", (20.0, 0.0, -3.0)),
                ("right_knee", (34.0, 0.0, 0.0)),
                ("left_ankle", (10.0, 0.0, 0.0)),
            )
        ),
        "reaching": Pose(
            (
                ("spine", (0.0, 0.0, -6.0)),
                ("chest", (0.0, 0.0, -8.0)),
                ("left_collar", (0.0, 0.0, 22.0)),
                ("left_shoulder", (0.0, 0.0, 72.0)),
                ("right_shoulder", (0.0, 0.0, 34.0)),
                ("right_elbow", (0.0, 35.0, 0.0)),
                ("head", (-18.0, 20.0, 0.0)),
                ("left_hip", (0.0, 0.0, 12.0)),
                ("right_hip", (-20.0, 0.0, 0.0)),
                ("right_knee", (40.0, 0.0, 0.0)),
            )
        ),
        "sitting": Pose(
            (
                ("spine", (6.0, 0.0, 0.0)),
                ("left_hip", (-80.0, 0.0, 6.0)),
                ("right_hip", (-80.0, 0.0, -6.0)),
                ("left_knee", (82.0, 0.0, 0.0)),
                ("right_knee", (82.0, 0.0, 0.0)),
                ("left_shoulder", (-28.0, 0.0, -38.0)),
                ("right_shoulder", (-28.0, 0.0, 38.0)),
                ("left_elbow", (-30.0, -30.0, 0.0)),
                ("right_elbow", (-30.0, 30.0, 0.0)),
            )
        ),
    }
)
"""Poses of :func:`human` by name."""
