"""Six classes of articulated shapes, each in four near-isometric poses or more."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from synthetic.animal_poses import CENTAUR_POSES, GORILLA_POSES, QUADRUPED_POSES
from synthetic.centaur import centaur_figure
from synthetic.human import HumanProportions, human_figure
from synthetic.pose import Pose
from synthetic.quadruped import CAT, DOG, HORSE, quadruped_figure
from synthetic.repertoire import HUMAN_POSES
from synthetic.skeleton import Figure

GORILLA = HumanProportions(
    head=1.15, arm=1.4, leg=0.68, torso=1.05, shoulders=1.35, girth=1.4, limbs=1.45
)
"""Long heavy arms, short legs and a broad trunk."""


@dataclass(frozen=True)
class ArticulatedClass:
    """One figure and its poses.

    Attributes
    ----------
    figure
        In its rest pose, symmetric under x to -x.
    poses
        By name.
    """

    figure: Figure
    poses: Mapping[str, Pose]


def _quadruped_class(figure: Figure, *poses: str) -> ArticulatedClass:
    return ArticulatedClass(
        figure, MappingProxyType({name: QUADRUPED_POSES[name] for name in poses})
    )


_UPRIGHT = ("standing", "walking", "reaching", "sitting")

CLASSES: Mapping[str, ArticulatedClass] = MappingProxyType(
    {
        "human": ArticulatedClass(
            human_figure(HumanProportions()),
            MappingProxyType({name: HUMAN_POSES[name] for name in _UPRIGHT}),
        ),
        "cat": _quadruped_class(quadruped_figure(CAT), "standing", "walking", "turning", "sitting"),
        "horse": _quadruped_class(
            quadruped_figure(HORSE), "standing", "walking", "galloping", "turning"
        ),
        "centaur": ArticulatedClass(
            centaur_figure(HORSE, HumanProportions()),
            CENTAUR_POSES,
        ),
        "gorilla": ArticulatedClass(human_figure(GORILLA), GORILLA_POSES),
        "dog": _quadruped_class(
            quadruped_figure(DOG), "standing", "walking", "galloping", "sitting"
        ),
    }
)
"""The classes by name, those of the TOSCA shapes."""
