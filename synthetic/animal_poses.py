"""Named poses of quadrupeds, of centaurs and of gorillas."""

from types import MappingProxyType

from synthetic.pose import REST, Pose

QUADRUPED_POSES = MappingProxyType(
    {
        "standing": REST,
        "walking": Pose(
            (
                ("neck", (10.0, 0.0, 0.0)),
                ("head", (-8.0, 15.0, 0.0)),
                ("left_foreleg", (-26.0, 0.0, 0.0)),
                ("left_foreknee", (6.0, 0.0, 0.0)),
                ("right_foreleg", (18.0, 0.0, 0.0)),
                ("right_foreknee", (28.0, 0.0, 0.0)),
                ("left_thigh", (22.0, 0.0, 0.0)),
                ("left_stifle", (8.0, 0.0, 0.0)),
                ("right_thigh", (-26.0, 0.0, 0.0)),
                ("right_hock", (12.0, 0.0, 0.0)),
                ("tail_1", (0.0, 15.0, 0.0)),
                ("tail_2", (10.0, 15.0, 0.0)),
            )
        ),
        "galloping": Pose(
            (
                ("loin", (-6.0, 0.0, 0.0)),
                ("withers", (-8.0, 0.0, 0.0)),
                ("neck", (20.0, 0.0, 0.0)),
                ("head", (-12.0, 0.0, 0.0)),
                ("left_foreleg", (-44.0, 0.0, 4.0)),
                ("left_foreknee", (12.0, 0.0, 0.0)),
                ("right_foreleg", (-32.0, 0.0, -4.0)),
                ("right_foreknee", (24.0, 0.0, 0.0)),
                ("left_thigh", (28.0, 0.0, 4.0)),
                ("left_hock", (20.0, 0.0, 0.0)),
                ("right_thigh", (40.0, 0.0, -4.0)),
                ("right_hock", (16.0, 0.0, 0.0)),
                ("tail_1", (12.0, 0.0, 0.0)),
                ("tail_2", (14.0, 0.0, 0.0)),
            )
        ),
        "turning": Pose(
            (
                ("loin", (0.0, 16.0, 0.0)),
                ("withers", (4.0, 18.0, 0.0)),
                ("neck", (16.0, 24.0, 0.0)),
                ("head", (6.0, 20.0, 0.0)),
                ("left_foreleg", (-44.0, 0.0, 6.0)),
                ("left_foreknee", (70.0, 0.0, 0.0)),
                ("left_forefoot", (24.0, 0.0, 0.0)),
                ("right_thigh", (12.0, 0.0, -8.0)),
                ("tail_1", (0.0, -24.0, 0.0)),
                ("tail_2", (0.0, -24.0, 0.0)),
                ("tail_3", (0.0, -24.0, 0.0)),
            )
        ),
        "sitting": Pose(
            (
                ("rump", (-34.0, 0.0, 0.0)),
                ("loin", (6.0, 0.0, 0.0)),
                ("withers", (10.0, 0.0, 0.0)),
                ("neck", (4.0, -18.0, 0.0)),
                ("head", (12.0, -14.0, 0.0)),
                ("left_foreleg", (16.0, 0.0, 0.0)),
                ("right_foreleg", (20.0, 0.0, 0.0)),
                ("left_thigh", (-44.0, 0.0, 8.0)),
                ("right_thigh", (-44.0, 0.0, -8.0)),
                ("left_stifle", (52.0, 0.0, 0.0)),
                ("right_stifle", (52.0, 0.0, 0.0)),
                ("left_hock", (-58.0, 0.0, 0.0)),
                ("right_hock", (-58.0, 0.0, 0.0)),
                ("left_hindfoot", (44.0, 0.0, 0.0)),
                ("right_hindfoot", (44.0, 0.0, 0.0)),
                ("tail_1", (30.0, 20.0, 0.0)),
            )
        ),
    }
)
"""Poses of a quadruped by name."""

_ARMS = MappingProxyType(
    {
        "standing": (
            ("left_shoulder", (0.0, 0.0, -36.0)),
            ("right_shoulder", (0.0, 0.0, 36.0)),
        ),
        "walking": (
            ("chest", (4.0, 12.0, 0.0)),
            ("left_shoulder", (36.0, 0.0, -30.0)),
            ("right_shoulder", (-30.0, 0.0, 30.0)),
            ("right_elbow", (-40.0, 20.0, 0.0)),
        ),
        "galloping": (
            ("spine", (12.0, 0.0, 0.0)),
            ("chest", (12.0, 0.0, 0.0)),
            ("left_shoulder", (0.0, -50.0, 0.0)),
            ("right_shoulder", (0.0, 50.0, 0.0)),
            ("head", (-16.0, 0.0, 0.0)),
        ),
        "turning": (
            ("spine", (0.0, 14.0, 0.0)),
            ("chest", (0.0, 16.0, 0.0)),
            ("left_shoulder", (0.0, 0.0, 80.0)),
            ("right_shoulder", (0.0, 30.0, 20.0)),
            ("right_elbow", (0.0, 60.0, 0.0)),
        ),
    }
)

CENTAUR_POSES = MappingProxyType(
    {
        name: Pose(
            tuple(turn for turn in QUADRUPED_POSES[name].turns if turn[0] not in ("neck", "head"))
            + arms
        )
        for name, arms in _ARMS.items()
    }
)
"""Poses of a centaur by name: those of a quadruped, and its arms."""

GORILLA_POSES = MappingProxyType(
    {
        "standing": Pose(
            (
                ("left_shoulder", (0.0, 0.0, -30.0)),
                ("right_shoulder", (0.0, 0.0, 30.0)),
            )
        ),
        "knuckles": Pose(
            (
                ("pelvis", (35.0, 0.0, 0.0)),
                ("chest", (12.0, 0.0, 0.0)),
                ("head", (-36.0, 0.0, 0.0)),
                ("left_shoulder", (-48.0, 0.0, -40.0)),
                ("right_shoulder", (-62.0, 0.0, 40.0)),
                ("left_hip", (-50.0, 0.0, 6.0)),
                ("right_hip", (-38.0, 0.0, -6.0)),
                ("left_knee", (34.0, 0.0, 0.0)),
                ("right_knee", (30.0, 0.0, 0.0)),
            )
        ),
        "beating": Pose(
            (
                ("chest", (-6.0, 0.0, 0.0)),
                ("left_shoulder", (0.0, -30.0, -10.0)),
                ("left_elbow", (0.0, -80.0, 0.0)),
                ("right_shoulder", (0.0, 30.0, 40.0)),
                ("right_elbow", (0.0, 30.0, 0.0)),
                ("head", (-14.0, 12.0, 0.0)),
                ("left_hip", (0.0, 0.0, 10.0)),
            )
        ),
        "climbing": Pose(
            (
                ("chest", (0.0, 10.0, -8.0)),
                ("left_collar", (0.0, 0.0, 20.0)),
                ("left_shoulder", (0.0, 0.0, 70.0)),
                ("right_shoulder", (0.0, 40.0, 0.0)),
                ("right_elbow", (0.0, 40.0, 0.0)),
                ("head", (-20.0, 0.0, 0.0)),
                ("right_hip", (-50.0, 0.0, -8.0)),
                ("right_knee", (60.0, 0.0, 0.0)),
            )
        ),
    }
)
"""Poses of a gorilla by name."""
