"""A registration of two shapes: the chosen candidate, with its maps and its confidence."""

from dataclasses import dataclass, replace

from solver.arrays import IntArray
from solver.control import Control
from solver.registration.choice import Candidate, distinct
from solver.registration.confidence import EXACT, Confidence, confidence_of
from solver.registration.dense_correspondence import DenseCorrespondence, in_numbers_of_files
from solver.registration.glued import OpenedCandidate
from solver.registration.lacking import share_lacking
from solver.registration.opening import Opening
from solver.registration.surface import smooth_surface
from solver.shape import Shape


@dataclass(frozen=True, eq=False)
class Registration:
    """A source registered to a target.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    opened
        The chosen candidate, on what is left of both where they were opened, as parts of them
        touch, and else on the whole shapes.
    confidence
        That it is right.
    """

    source: Shape
    target: Shape
    opened: OpenedCandidate
    confidence: Confidence

    @classmethod
    def of(
        cls,
        source: Shape,
        target: Shape,
        candidate: Candidate,
        confidence: Confidence,
        *,
        reflected: bool = False,
    ) -> "Registration":
        """Return the registration of whole shapes.

        Parameters
        ----------
        source, target
            The shapes X and Y.
        candidate
            The chosen one.
        confidence
            That it is right.
        reflected
            Whether the source is reflected in space.
        """
        whole = Opening.nowhere(source), Opening.nowhere(target)
        return cls(source, target, OpenedCandidate(whole, candidate, reflected), confidence)

    @property
    def candidate(self) -> Candidate:
        """The chosen one."""
        return self.opened.candidate

    @property
    def reflected(self) -> bool:
        """Whether the source is reflected in space."""
        return self.opened.reflected

    @property
    def glued(self) -> bool:
        """Whether a shape was opened, as parts of it touch."""
        ours, theirs = self.opened.openings
        return ours.shape is not self.source or theirs.shape is not self.target

    @property
    def score(self) -> float:
        """Score of the chosen candidate's fit; the less, the better."""
        return self.candidate.fit.score

    @property
    def is_exact(self) -> bool:
        """Whether the surfaces are equal but for their sampling."""
        return self.score < EXACT

    def among(self, other: "Registration") -> "Registration":
        """Return the registration as one of two: the confidence is less if it fits no better.

        Parameters
        ----------
        other
            Of the same shapes; both of :func:`.register_map`.
        """
        margin = other.score - self.score
        complete = not self.confidence.is_unfinished
        return replace(self, confidence=confidence_of(self.candidate.fit, margin, complete))

    def differs_from(self, other: "Registration") -> bool:
        """Return whether another registration is another map.

        Parameters
        ----------
        other
            As for :meth:`among`.
        """
        positions = smooth_surface(self.target).mesh.vertices
        return len(distinct(positions[one.candidate.images] for one in (self, other))) > 1

    def images(self, vertices: IntArray, control: Control) -> IntArray:
        """(S,) target vertices that S source vertices go to, refined where they are torn.

        Parameters
        ----------
        vertices
            (S,) of the source.
        control
            May cancel; past its deadline, less is refined. Only the first call refines.

        Raises
        ------
        Cancelled
            Through `control`.
        """
        return self.opened.images(vertices, control)

    def share_lacking(self, control: Control, *, of_source: bool) -> float:
        """Share of the area of X that Y lacks, or of Y that X lacks, by this registration.

        Parameters
        ----------
        control
            May cancel; past its deadline, less is refined.
        of_source
            Whether it is that of X.

        Raises
        ------
        Cancelled
            Through `control`.
        MeshError
            The Laplacian of the shape cannot be factored.
        """
        return share_lacking((self.source, self.target), self.opened, of_source, control)

    def dense(self, control: Control) -> DenseCorrespondence:
        """Map all vertices of both surfaces, refined beyond the eigenfunctions.

        Parameters
        ----------
        control
            May cancel; past its deadline, less is refined.

        Raises
        ------
        Cancelled
            Through `control`.
        MeshError
            The source's Laplacian cannot be factored.
        """
        source, target = self.source.mesh, self.target.mesh
        forward, back = self.opened.refined(control)
        return replace(
            in_numbers_of_files(source, target, *forward),
            inverse=in_numbers_of_files(target, source, *back),
        )
