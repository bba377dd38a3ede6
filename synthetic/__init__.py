"""Generated articulated shapes with known correspondence, for the demo, tests and bench."""

from synthetic.classes import CLASSES
from synthetic.human import ALIEN, ASYMMETRIC_HUMAN, HumanProportions, human_figure
from synthetic.objects import OBJECTS, individuals
from synthetic.pose import Pose
from synthetic.proportions import transferred
from synthetic.repertoire import HUMAN_POSES
from synthetic.shapes import SyntheticShape, articulated, correspondence, human
from synthetic.skull import SKULL_LENGTH, Skull, skull
from synthetic.texture import clothed, painted
from synthetic.topology import glued, near_in_space, punched, submesh, with_holes
from synthetic.transformations import Transformed, noisy, remeshed, scaled, subdivided

__all__ = [
    "ALIEN",
    "ASYMMETRIC_HUMAN",
    "CLASSES",
    "HUMAN_POSES",
    "OBJECTS",
    "SKULL_LENGTH",
    "HumanProportions",
    "Pose",
    "Skull",
    "SyntheticShape",
    "Transformed",
    "articulated",
    "clothed",
    "correspondence",
    "glued",
    "human",
    "human_figure",
    "individuals",
    "near_in_space",
    "noisy",
    "painted",
    "punched",
    "remeshed",
    "scaled",
    "skull",
    "subdivided",
    "submesh",
    "transferred",
    "with_holes",
]
