"""Generated articulated shapes with ground truth."""

from solver.synthetic.classes import CLASSES
from solver.synthetic.human import ASYMMETRIC_HUMAN, HumanProportions
from solver.synthetic.pose import Pose
from solver.synthetic.repertoire import HUMAN_POSES
from solver.synthetic.shapes import SyntheticShape, articulated, correspondence, human

__all__ = [
    "ASYMMETRIC_HUMAN",
    "CLASSES",
    "HUMAN_POSES",
    "HumanProportions",
    "Pose",
    "SyntheticShape",
    "articulated",
    "correspondence",
    "human",
]
