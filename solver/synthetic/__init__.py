"""Generated articulated shapes with ground truth."""

from solver.synthetic.classes import CLASSES
from solver.synthetic.human import ALIEN, ASYMMETRIC_HUMAN, HumanProportions, human_figure
from solver.synthetic.pose import Pose
from solver.synthetic.proportions import carried
from solver.synthetic.repertoire import HUMAN_POSES
from solver.synthetic.shapes import SyntheticShape, articulated, correspondence, human
from solver.synthetic.texture import clothed, painted
from solver.synthetic.topology import glued, near_in_space, punched
from solver.synthetic.transformations import Transformed, noisy, remeshed, scaled

__all__ = [
    "ALIEN",
    "ASYMMETRIC_HUMAN",
    "CLASSES",
    "HUMAN_POSES",
    "HumanProportions",
    "Pose",
    "SyntheticShape",
    "Transformed",
    "articulated",
    "carried",
    "clothed",
    "correspondence",
    "glued",
    "human",
    "human_figure",
    "near_in_space",
    "noisy",
    "painted",
    "punched",
    "remeshed",
    "scaled",
]
