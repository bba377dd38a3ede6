"""A four-legged animal of given proportions: standing along z, its head to the front."""

import math
from dataclasses import dataclass

from synthetic.skeleton import Figure, Flesh, Joint, Point, mirror_image


@dataclass(frozen=True)
class QuadrupedProportions:
    """Factors on the measures of a standard figure, and how its parts are held.

    Whatever the animal, the trunk is about 0.7 m long: grid cells, edges and the width of joints
    then mean the same on every figure.

    Parameters
    ----------
    trunk
        Length of the trunk.
    girth
        Thickness of the trunk.
    neck
        Length of the neck.
    throat
        Thickness of the neck.
    neck_rise
        Angle of the neck above the horizontal, in degrees.
    head
        Size of the head.
    muzzle
        Length of the muzzle against the head.
    muzzle_drop
        Angle of the muzzle below the horizontal, in degrees.
    ears
        Length of the ears against the head.
    ear_rise
        Angle of the ears above the horizontal, in degrees: upright or hanging.
    tail
        Length of the tail.
    tail_girth
        Thickness of the tail.
    tail_rise
        Angle of the tail above the horizontal, in degrees.
    leg
        Length of the legs.
    limbs
        Thickness of the legs.
    paws
        Size of the feet.
    """

    trunk: float = 1.0
    girth: float = 1.0
    neck: float = 1.0
    throat: float = 1.0
    neck_rise: float = 40.0
    head: float = 1.0
    muzzle: float = 1.0
    muzzle_drop: float = 20.0
    ears: float = 1.0
    ear_rise: float = 70.0
    tail: float = 1.0
    tail_girth: float = 1.0
    tail_rise: float = 20.0
    leg: float = 1.0
    limbs: float = 1.0
    paws: float = 1.0


CAT = QuadrupedProportions(
    girth=0.85, neck=0.55, head=1.1, muzzle=0.45, ear_rise=75.0, tail=1.9, tail_rise=35.0,
    leg=0.85, limbs=0.85,
)  # fmt: skip
DOG = QuadrupedProportions(
    trunk=0.95, neck=0.8, neck_rise=50.0, head=1.1, muzzle=1.3, ears=1.5, ear_rise=-50.0, tail=0.9,
    tail_rise=50.0, leg=1.15,
)  # fmt: skip
HORSE = QuadrupedProportions(
    trunk=1.05, girth=1.1, neck=1.7, throat=1.25, neck_rise=48.0, muzzle=2.0, muzzle_drop=45.0,
    ears=0.7, tail=1.2, tail_girth=1.5, tail_rise=-50.0, leg=1.55, limbs=1.05, paws=0.9,
)  # fmt: skip


def quadruped_figure(proportions: QuadrupedProportions) -> Figure:
    """Joints and flesh of a quadruped in the rest pose.

    Parameters
    ----------
    proportions
        Factors on the standard measures.

    Returns
    -------
    figure
        The figure, the middle of its trunk at the origin.
    """
    joints, flesh, landmarks = hindmost(proportions)
    for part in (_neck(proportions), _head(proportions)):
        joints += part[0]
        flesh += part[1]
    nose = flesh[-1].end
    return Figure(tuple(joints), tuple(flesh), blend=0.01, landmarks=(("nose", nose), *landmarks))


def hindmost(
    p: QuadrupedProportions,
) -> tuple[list[Joint], list[Flesh], list[tuple[str, Point]]]:
    """Trunk, tail and legs: what a quadruped shares with a centaur.

    Returns
    -------
    joints, flesh, landmarks
        The trunk's three joints come first: "rump", "loin" and "withers", front-most last.
    """
    joints, flesh = _trunk(p)
    tail_joints, tail_flesh = _tail(p)
    joints += tail_joints
    flesh += tail_flesh
    landmarks = [("tail", tail_flesh[-1].end)]
    for limb_joints, limb_flesh in (_foreleg(p), _hindleg(p)):
        right_joints, right_flesh = mirror_image(limb_joints, limb_flesh)
        joints += limb_joints + right_joints
        flesh += limb_flesh + right_flesh
        landmarks += [(part.joint, part.end) for part in (limb_flesh[-1], right_flesh[-1])]
    return joints, flesh, landmarks


def _half_length(p: QuadrupedProportions) -> float:
    return 0.36 * p.trunk


def _trunk(p: QuadrupedProportions) -> tuple[list[Joint], list[Flesh]]:
    z, g = _half_length(p), p.girth
    joints = [
        Joint("rump", None, (0.0, 0.0, -0.6 * z)),
        Joint("loin", "rump", (0.0, 0.02, -0.3 * z)),
        Joint("withers", "loin", (0.0, 0.02, 0.3 * z)),
    ]
    flesh = [
        Flesh("rump", (0.0, 0.0, -z), 0.12 * g, (0.0, 0.01, -0.45 * z), 0.12 * g),
        Flesh("loin", (0.0, 0.01, -0.45 * z), 0.12 * g, (0.0, -0.01, 0.2 * z), 0.13 * g),
        Flesh("withers", (0.0, 0.0, 0.3 * z), 0.135 * g, (0.0, 0.01, 0.95 * z), 0.12 * g),
        Flesh("withers", (0.0, -0.05, 0.3 * z), 0.12 * g, (0.0, -0.04, 0.9 * z), 0.11 * g),
    ]
    return joints, flesh


def _tail(p: QuadrupedProportions) -> tuple[list[Joint], list[Flesh]]:
    rise = math.radians(p.tail_rise)
    root, length = (0.0, 0.06 * p.girth, -_half_length(p) - 0.09 * p.girth), 0.13 * p.tail

    def at(segments: float) -> Point:
        distance = segments * length
        return (0.0, root[1] + distance * math.sin(rise), root[2] - distance * math.cos(rise))

    joints, flesh, parent = [], [], "rump"
    for k, (start, end) in enumerate(((0.036, 0.031), (0.031, 0.027), (0.027, 0.02))):
        name = f"tail_{k + 1}"
        joints.append(Joint(name, parent, at(k)))
        r = p.tail_girth
        flesh.append(Flesh(name, at(k), start * r, at(k + 1.0), end * r))
        parent = name
    return joints, flesh


def _neck_ends(p: QuadrupedProportions) -> tuple[Point, Point]:
    rise, length = math.radians(p.neck_rise), 0.12 * p.girth + 0.2 * p.neck
    y, z = 0.02, 0.85 * _half_length(p)
    return (0.0, y, z), (0.0, y + length * math.sin(rise), z + length * math.cos(rise))


def _neck(p: QuadrupedProportions) -> tuple[list[Joint], list[Flesh]]:
    start, end = _neck_ends(p)
    joints = [Joint("neck", "withers", start), Joint("head", "neck", end)]
    return joints, [Flesh("neck", start, 0.095 * p.throat, end, 0.062 * p.throat)]


def _head(p: QuadrupedProportions) -> tuple[list[Joint], list[Flesh]]:
    """Skull, ears, jaw and, last, the muzzle."""
    h = p.head
    _, (_, y, z) = _neck_ends(p)
    drop, rise = math.radians(p.muzzle_drop), math.radians(p.ear_rise)
    forward, down = h * math.cos(drop), h * math.sin(drop)

    def at(distance: float, right: float = 0.0, under: float = 0.0) -> Point:
        below = under * math.cos(drop)
        return (right * h, y + 0.02 * h - distance * down - below * h, z + distance * forward)

    flesh = [Flesh("head", at(-0.005), 0.078 * h, at(0.045), 0.07 * h)]
    reach = 0.09 * p.ears * h
    for s in (1.0, -1.0):
        root = (0.05 * s * h, y + 0.06 * h, z - 0.01 * h)
        tip = (root[0] + s * reach * math.cos(rise), root[1] + reach * math.sin(rise), root[2])
        flesh.append(Flesh("head", root, 0.028 * h, tip, 0.015 * h))
    length = 0.05 + 0.12 * p.muzzle
    flesh += [
        Flesh("head", at(0.03, under=0.03), 0.045 * h, at(0.8 * length, under=0.025), 0.026 * h),
        Flesh("head", at(0.03), 0.056 * h, at(length), 0.034 * h),
    ]
    return [], flesh


def _foreleg(p: QuadrupedProportions) -> tuple[list[Joint], list[Flesh]]:
    """The left foreleg; the last cone is the foot."""
    r, f, g, z = p.limbs, p.paws, p.girth, 0.78 * _half_length(p)
    top = (0.075 * g, -0.04, z)
    elbow = (0.1 * g, -0.04 - 0.24 * p.leg, z - 0.03)
    wrist = (0.105 * g, -0.04 - 0.46 * p.leg, z)
    toes = (wrist[0], wrist[1] - 0.035 * f, wrist[2] + 0.065 * f)
    joints = [
        Joint("left_foreleg", "withers", top),
        Joint("left_foreknee", "left_foreleg", elbow),
        Joint("left_forefoot", "left_foreknee", wrist),
    ]
    flesh = [
        Flesh("left_foreleg", top, 0.075 * r, elbow, 0.042 * r),
        Flesh("left_foreknee", elbow, 0.041 * r, wrist, 0.026 * r),
        Flesh("left_forefoot", wrist, 0.03 * f, toes, 0.028 * f),
    ]
    return joints, flesh


def _hindleg(p: QuadrupedProportions) -> tuple[list[Joint], list[Flesh]]:
    """The left hind leg, its hock behind; the last cone is the foot."""
    r, f, g, z = p.limbs, p.paws, p.girth, -0.85 * _half_length(p)
    top = (0.07 * g, -0.02, z)
    knee = (0.1 * g, -0.03 - 0.21 * p.leg, z + 0.05)
    hock = (0.105 * g, -0.03 - 0.36 * p.leg, z - 0.07)
    heel = (0.11 * g, -0.04 - 0.47 * p.leg, z - 0.05)
    toes = (heel[0], heel[1] - 0.025 * f, heel[2] + 0.075 * f)
    joints = [
        Joint("left_thigh", "rump", top),
        Joint("left_stifle", "left_thigh", knee),
        Joint("left_hock", "left_stifle", hock),
        Joint("left_hindfoot", "left_hock", heel),
    ]
    flesh = [
        Flesh("left_thigh", top, 0.095 * r, knee, 0.056 * r),
        Flesh("left_stifle", knee, 0.055 * r, hock, 0.03 * r),
        Flesh("left_hock", hock, 0.03 * r, heel, 0.026 * r),
        Flesh("left_hindfoot", heel, 0.03 * f, toes, 0.027 * f),
    ]
    return joints, flesh
