"""A human figure of given proportions: arms and legs apart, facing along z."""

import math
from dataclasses import dataclass

from synthetic.skeleton import Figure, Flesh, Joint, Point, mirror_image

_SIDES = (1.0, -1.0)


@dataclass(frozen=True)
class HumanProportions:
    """Factors on the measures of the standard figure, which is 1.75 m tall.

    Parameters
    ----------
    head
        Size of the head.
    arm, leg
        Lengths of the limbs.
    torso
        Height of the trunk.
    shoulders
        Distance between the shoulders.
    girth
        Thickness of the trunk.
    limbs
        Thickness of the limbs.
    left_arm, left_leg
        Size of the left limb against the right one; 1 for a figure with a plane of symmetry.
    left_hand
        Size of the left hand against the right one, beyond that of the arm.
    """

    head: float = 1.0
    arm: float = 1.0
    leg: float = 1.0
    torso: float = 1.0
    shoulders: float = 1.0
    girth: float = 1.0
    limbs: float = 1.0
    left_arm: float = 1.0
    left_leg: float = 1.0
    left_hand: float = 1.0

    @property
    def symmetric(self) -> bool:
        """Whether the figure is its own mirror image."""
        return self.left_arm == self.left_leg == self.left_hand == 1.0


ASYMMETRIC_HUMAN = HumanProportions(left_arm=1.3, left_leg=0.8, left_hand=1.5)
"""One long arm with a heavy hand and one short leg: no intrinsic symmetry is left."""

ALIEN = HumanProportions(
    head=2.2, arm=1.45, leg=0.75, torso=0.8, shoulders=0.8, girth=0.6, limbs=0.6
)
"""A humanoid outside the range of humans: a great head on a thin body with long arms."""


def human_figure(proportions: HumanProportions) -> Figure:
    """Joints and flesh of a human in the rest pose.

    Parameters
    ----------
    proportions
        Factors on the standard measures.

    Returns
    -------
    figure
        The figure, its pelvis at the origin.
    """
    p = proportions
    joints, flesh = _trunk(p)
    head_flesh, landmarks = _head(p)
    flesh += head_flesh
    for side in ("left", "right"):
        left = side == "left"
        arm, hand = (p.left_arm, p.left_hand) if left else (1.0, 1.0)
        limb_joints, limb_flesh = _arm(p, arm, hand)
        fingertip = limb_flesh[-3].end
        leg_joints, leg_flesh = _leg(p, p.left_leg if left else 1.0)
        toes, heel = leg_flesh[-1].end, leg_flesh[-4].start
        parts = [*limb_joints, *leg_joints], [*limb_flesh, *leg_flesh]
        sign = 1.0 if left else -1.0
        for name, (x, y, z) in (("hand", fingertip), ("foot", toes), ("heel", heel)):
            landmarks.append((f"{side}_{name}", (sign * x, y, z)))
        side_joints, side_flesh = parts if left else mirror_image(*parts)
        joints += side_joints
        flesh += side_flesh
    return Figure(tuple(joints), tuple(flesh), blend=0.01, landmarks=tuple(landmarks))


def _neck_height(p: HumanProportions) -> float:
    return 0.50 * p.torso


def _trunk(p: HumanProportions) -> tuple[list[Joint], list[Flesh]]:
    t, g, w = p.torso, p.girth, p.shoulders
    joints = [
        Joint("pelvis", None, (0.0, 0.0, 0.0)),
        Joint("spine", "pelvis", (0.0, 0.11 * t, 0.0)),
        Joint("chest", "spine", (0.0, 0.25 * t, 0.0)),
        Joint("neck", "chest", (0.0, 0.47 * t, -0.01)),
        Joint("head", "neck", (0.0, _neck_height(p) + 0.07, 0.0)),
    ]
    flesh = []
    for s in _SIDES:
        x = s * w
        flesh += [
            Flesh(
                "pelvis", (0.055 * s, -0.03, 0.0), 0.09 * g, (0.045 * s, 0.08 * t, 0.0), 0.08 * g
            ),
            Flesh(
                "pelvis", (0.065 * s, -0.06, -0.05), 0.065 * g, (0.065 * s, -0.03, -0.045), 0.06 * g
            ),
            Flesh(
                "spine", (0.04 * s, 0.1 * t, 0.005), 0.078 * g, (0.045 * s, 0.2 * t, 0.0), 0.08 * g
            ),
            Flesh(
                "chest",
                (0.055 * s, 0.24 * t, 0.0),
                0.083 * g,
                (0.065 * x, 0.37 * t, 0.0),
                0.085 * g,
            ),
            Flesh(
                "chest",
                (0.05 * x, 0.41 * t, -0.015),
                0.065 * g,
                (0.11 * x, 0.42 * t, -0.015),
                0.055 * g,
            ),
            Flesh(
                "chest",
                (0.06 * x, 0.335 * t, 0.055),
                0.045 * g,
                (0.09 * x, 0.365 * t, 0.045),
                0.04 * g,
            ),
            Flesh("chest", (0.02 * s, 0.485 * t, -0.025), 0.04, (0.11 * x, 0.45 * t, -0.02), 0.04),
        ]
    return joints, flesh


def _head(p: HumanProportions) -> tuple[list[Flesh], list[tuple[str, Point]]]:
    h, y = p.head, _neck_height(p) + 0.07
    flesh = [
        Flesh("neck", (0.0, 0.45 * p.torso, -0.015), 0.052, (0.0, y + 0.02, 0.0), 0.047),
        Flesh(
            "head",
            (0.0, y + 0.1 * h, -0.02 * h),
            0.08 * h,
            (0.0, y + 0.11 * h, 0.02 * h),
            0.074 * h,
        ),
        Flesh(
            "head",
            (0.0, y + 0.03 * h, 0.035 * h),
            0.045 * h,
            (0.0, y + 0.09 * h, 0.03 * h),
            0.06 * h,
        ),
        Flesh(
            "head",
            (0.0, y + 0.005 * h, 0.065 * h),
            0.018 * h,
            (0.0, y + 0.03 * h, 0.06 * h),
            0.03 * h,
        ),
        Flesh(
            "head",
            (0.0, y + 0.08 * h, 0.085 * h),
            0.008 * h,
            (0.0, y + 0.05 * h, 0.105 * h),
            0.011 * h,
        ),
    ]
    for s in _SIDES:
        low, high = (0.074 * s * h, y + 0.06 * h, 0.0), (0.081 * s * h, y + 0.088 * h, -0.012 * h)
        flesh.append(Flesh("head", low, 0.006 * h, high, 0.01 * h))
    landmarks = [("head", (0.0, y + 0.19 * h, 0.0)), ("nose", (0.0, y + 0.05 * h, 0.12 * h))]
    return flesh, landmarks


def _arm(p: HumanProportions, size: float, hand: float) -> tuple[list[Joint], list[Flesh]]:
    """The left arm, 35 degrees below the horizontal; the last three cones are the fingers."""
    r = p.limbs * math.sqrt(size)
    across, down = math.cos(math.radians(35.0)), -math.sin(math.radians(35.0))
    shoulder = (0.165 * p.shoulders, 0.435 * p.torso, -0.015)

    def at(distance: float, up: float = 0.0, front: float = 0.0) -> Point:
        return (
            shoulder[0] + distance * across - up * down,
            shoulder[1] + distance * down + up * across,
            shoulder[2] + front,
        )

    elbow = 0.28 * p.arm * size
    wrist = elbow + 0.25 * p.arm * size
    m = hand * size
    joints = [
        Joint("left_collar", "chest", (0.03 * p.shoulders, 0.45 * p.torso, -0.01)),
        Joint("left_shoulder", "left_collar", shoulder),
        Joint("left_elbow", "left_shoulder", at(elbow)),
        Joint("left_wrist", "left_elbow", at(wrist)),
    ]
    flesh = [
        Flesh("left_shoulder", at(-0.01), 0.05 * r, at(0.05), 0.048 * r),
        Flesh("left_shoulder", at(0.0), 0.044 * r, at(elbow), 0.03 * r),
        Flesh(
            "left_shoulder",
            at(0.4 * elbow, front=0.012),
            0.036 * r,
            at(0.65 * elbow, front=0.01),
            0.034 * r,
        ),
        Flesh("left_elbow", at(elbow), 0.03 * r, at(wrist), 0.02 * r),
        Flesh("left_elbow", at(elbow + 0.04 * size), 0.037 * r, at(elbow + 0.1 * size), 0.034 * r),
        Flesh(
            "left_wrist", at(wrist), 0.021 * r, at(wrist + 0.08 * m, front=-0.018 * m), 0.017 * m
        ),
        Flesh("left_wrist", at(wrist), 0.021 * r, at(wrist + 0.08 * m, front=0.02 * m), 0.017 * m),
        Flesh(
            "left_wrist",
            at(wrist + 0.08 * m, front=0.01 * m),
            0.014 * m,
            at(wrist + 0.17 * m, -0.005 * m, 0.012 * m),
            0.01 * m,
        ),
        Flesh(
            "left_wrist",
            at(wrist + 0.08 * m, front=-0.015 * m),
            0.014 * m,
            at(wrist + 0.16 * m, -0.005 * m, -0.014 * m),
            0.01 * m,
        ),
        Flesh(
            "left_wrist",
            at(wrist + 0.025 * m, front=0.02 * m),
            0.016 * m,
            at(wrist + 0.095 * m, -0.01 * m, 0.068 * m),
            0.01 * m,
        ),
    ]
    return joints, flesh


def _leg(p: HumanProportions, size: float) -> tuple[list[Joint], list[Flesh]]:
    """The left leg; the last four cones are the heel and the front of the foot."""
    r = p.limbs * math.sqrt(size)
    length = p.leg * size
    hip = (0.09, -0.04, 0.0)
    knee = (0.125, -0.04 - 0.42 * length, 0.012)
    ankle = (0.15, -0.04 - 0.83 * length, -0.02)
    ball = (0.165, ankle[1] - 0.05 * size, ankle[2] + 0.11 * size)

    def shin(share: float, back: float = 0.0) -> Point:
        x, y, z = (a + share * (b - a) for a, b in zip(knee, ankle, strict=True))
        return (x, y, z - back)

    def foot(right: float, up: float, front: float) -> Point:
        return (ankle[0] - right * size, ankle[1] + up * size, ankle[2] + front * size)

    joints = [
        Joint("left_hip", "pelvis", hip),
        Joint("left_knee", "left_hip", knee),
        Joint("left_ankle", "left_knee", ankle),
        Joint("left_toes", "left_ankle", ball),
    ]
    flesh = [
        Flesh("left_hip", (0.092, -0.08, 0.0), 0.08 * r, knee, 0.042 * r),
        Flesh(
            "left_hip",
            (0.1, -0.04 - 0.1 * length, 0.012),
            0.072 * r,
            (0.112, -0.04 - 0.24 * length, 0.012),
            0.06 * r,
        ),
        Flesh("left_knee", knee, 0.041 * r, ankle, 0.026 * r),
        Flesh("left_knee", shin(0.15, 0.012), 0.046 * r, shin(0.4, 0.018), 0.042 * r),
        Flesh(
            "left_ankle",
            foot(0.0, -0.045, -0.028),
            0.028 * size,
            foot(0.0, -0.02, -0.01),
            0.028 * r,
        ),
        Flesh(
            "left_ankle",
            foot(0.0, -0.015, 0.015),
            0.03 * size,
            foot(-0.008, -0.045, 0.1),
            0.024 * size,
        ),
        Flesh(
            "left_toes",
            foot(0.004, -0.055, 0.1),
            0.02 * size,
            foot(0.004, -0.06, 0.165),
            0.014 * size,
        ),
        Flesh(
            "left_toes",
            foot(-0.024, -0.057, 0.09),
            0.018 * size,
            foot(-0.024, -0.061, 0.15),
            0.013 * size,
        ),
    ]
    return joints, flesh
