"""A centaur: from the waist up a human, where a horse has its neck."""

from dataclasses import replace

from synthetic.human import HumanProportions, human_figure
from synthetic.quadruped import QuadrupedProportions, hindmost
from synthetic.skeleton import Figure, Point

_LEGS = ("hip", "knee", "ankle", "toes")


def centaur_figure(horse: QuadrupedProportions, human: HumanProportions) -> Figure:
    """Joints and flesh of a centaur in the rest pose.

    Parameters
    ----------
    horse
        Proportions of trunk, legs and tail; its neck and head are not used.
    human
        Proportions of torso, arms and head; its legs are not used.

    Returns
    -------
    figure
        The figure, the middle of its trunk at the origin. The human's pelvis is called "waist",
        all other joints as on a human and on a quadruped.
    """
    joints, flesh, landmarks = hindmost(horse)
    rider = human_figure(human)
    front = flesh[3].end
    waist = (0.0, 0.12 * horse.girth, front[2] - 0.05)

    def lifted(point: Point) -> Point:
        return (point[0], point[1] + waist[1], point[2] + waist[2])

    for joint in rider.joints:
        if not joint.name.endswith(_LEGS):
            own = "waist" if joint.name == "pelvis" else joint.name
            up = {None: "withers", "pelvis": "waist"}.get(joint.parent, joint.parent)
            joints.append(replace(joint, name=own, parent=up, position=lifted(joint.position)))
    for cone in rider.flesh:
        if not cone.joint.endswith(_LEGS):
            own = "waist" if cone.joint == "pelvis" else cone.joint
            flesh.append(replace(cone, joint=own, start=lifted(cone.start), end=lifted(cone.end)))
    landmarks += [
        (name, lifted(point))
        for name, point in rider.landmarks
        if not name.endswith(("foot", "heel"))
    ]
    return Figure(tuple(joints), tuple(flesh), rider.blend, tuple(landmarks))
