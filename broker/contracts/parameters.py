"""The parameters of jobs: the solver's options, and those of the service.

Options of the solver are declared in `solver` and generated here; parameters that the service adds
are declared in this module. Section and equation numbers are those of Wang, Bronstein and Paragios,
INRIA RR-7333, 2010.
"""

import hashlib
from collections.abc import Iterable, Iterator
from typing import Annotated, Final, Literal, Self

from pydantic import Field

from broker.contracts import solver_options as solver
from broker.contracts.catalogue import choice, choices
from broker.contracts.spectra import SpectrumKey
from broker.contracts.strict import Topic
from broker.contracts.structure_choices import Eigenfunctions
from broker.contracts.structures import Choice

SIGNATURE_VERSION: Final = 1
"""Raised whenever the solver's signatures change, so that no stale one is taken from a cache."""

Eigenpairs = Annotated[
    int,
    Field(ge=10, le=300, description="Eigenpairs of the Laplace-Beltrami operator."),
    Topic("Structures"),
]
GeodesicMethod = Annotated[
    solver.GeodesicMethodName,
    Field(
        description='Method of computing geodesic distances. "fast_marching" has a mean error of'
        ' 0.2 %; "graph", shortest paths over edges and lines across them, of 1.3 %, in two thirds'
        ' of the time; "heat", which gives smooth distances, of 1.7 %.'
    ),
    Topic("Structures"),
]
Normalise = Annotated[
    bool,
    Field(
        description="Scale all shapes to unit area first, so that size does not count. If false,"
        " distances and the parameters of structures are in the unit of length of the files;"
        " parameters that are left out are derived from the geometric mean of the areas."
    ),
    Topic("Shapes"),
]
LargestComponent = Annotated[
    bool,
    Field(
        description="Match only the largest component of a shape that has several. If false,"
        " components are linked where they are nearest, and matched as one surface."
    ),
    Topic("Shapes"),
]
Simplify = Annotated[
    int | None,
    Field(
        ge=100,
        le=1_000_000,
        description="Number of vertices to which larger shapes are simplified first. No"
        " simplification if left out. Results still use the vertex numbers of the file, and the"
        " remaining vertices keep their positions.",
    ),
    Topic("Shapes"),
]
CorrespondenceSource = Annotated[
    Literal["matches", "shared_connectivity"],
    Field(
        description="Source of the correspondence between the examples."
        ' "matches" matches the reference to every other shape. "shared_connectivity" takes the'
        " same vertex of every file; all files must have the same faces, and `simplify` is not"
        " possible. Not used if `correspondences` are given."
    ),
    Topic(""),
]


_PARTS = "source", "target", "both"
"""Values of `partial` that say which shape is a part."""

_MOST_LINF_POINTS: Final = 32


class MatchParameters(solver.MatchOptions):
    """Parameters of a match; all have defaults that suit most shapes.

    Section and equation numbers are those of Wang, Bronstein and Paragios, INRIA RR-7333, 2010.
    Distances are taken on shapes of unit area unless `normalise` is false.
    """

    eigenpairs: Eigenpairs = solver.DEFAULT_EIGENPAIRS
    geodesic_method: GeodesicMethod = solver.DEFAULT_GEODESIC_METHOD
    normalise: Normalise = True
    largest_component: LargestComponent = False
    simplify: Simplify = None

    @classmethod
    def of_whole_surfaces(cls, largest_component: bool) -> Self:
        """Return the parameters of the dense matches of a collection."""
        # The proof over all samples takes time, and concerns the sparse match alone.
        return cls(
            dense=True, partial="none", proof="candidates", largest_component=largest_component
        )

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """What is wrong with fields given the others: their names, and messages."""
        if self.objective == "linf":
            yield from self._against_linf()
        if self.partial in _PARTS and self.refine is not None:
            yield "partial", "parts are not refined; leave it out, or `refine`"
        count = len(self.landmarks)
        if count > self.points:
            message = f"{count} landmarks are more than `points`, which is {self.points}"
            yield "landmarks", message
        if any(len(set(side)) < count for side in zip(*self.landmarks, strict=True)):
            yield "landmarks", "a vertex is in two pairs; leave one of them out"

    def _against_linf(self) -> Iterator[tuple[str, str]]:
        if self.points > _MOST_LINF_POINTS:
            message = f'"linf" takes at most {_MOST_LINF_POINTS} points; give `points`, from 3 to'
            yield "objective", f"{message} {_MOST_LINF_POINTS}"
        if self.occlusion_cost is not None:
            yield "objective", '"linf" matches every point; leave `occlusion_cost` out'
        if self.third_order > 0.0:
            yield "third_order", '"linf" has no third-order term; leave it out, or `objective`'
        if self.partial in _PARTS:
            yield "partial", '"linf" matches every point; leave it out, or `objective`'
        if self.landmarks:
            yield "landmarks", '"linf" takes no landmarks; leave them out, or `objective`'

    @property
    def metrics(self) -> tuple[Choice, ...]:
        """The metrics by level, coarsest first; the last holds for all further levels."""
        return choices(self.metric)

    @property
    def descriptors(self) -> tuple[Choice, ...]:
        """The descriptors by level, coarsest first; the last holds for all further levels."""
        return choices(self.descriptor)

    @property
    def needs_spectrum(self) -> bool:
        """Whether any level, or the extension of the match, uses the spectrum of the shapes."""
        described = any(one.about.spectral for one in self.descriptors)
        spectral = any(one.about.spectral for one in self.metrics)
        compared = (described and self.first_order_weight > 0) or self.third_order > 0
        return self.registered or spectral or compared

    @property
    def registered(self) -> bool:
        """Whether the surfaces are registered: to choose, to map all vertices, or to refine."""
        oriented = self.orientation and self.objective != "linf"
        plain = self.refine is None and self.partial not in _PARTS
        return oriented or self.dense or not plain

    @property
    def spectrum_size(self) -> int:
        """Eigenpairs that are computed of each shape, and kept: no less than any part needs."""
        registered = solver.REGISTRATION_EIGENPAIRS if self.registered else 0
        described = _eigenpairs(self.descriptors) if self.first_order_weight > 0.0 else 0
        return max(self.eigenpairs, registered, described)


class DissimilarityParameters(solver.SimilarityOptions):
    """Parameters of a comparison; all have defaults that suit most shapes.

    Section and equation numbers are those of Wang, Bronstein and Paragios, INRIA RR-7333, 2010.
    Distances are taken on shapes of unit area.
    """

    eigenpairs: Eigenpairs = solver.DEFAULT_EIGENPAIRS
    largest_component: LargestComponent = False
    simplify: Simplify = None

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """What is wrong with fields given the others: their names, and messages."""
        if self.objective == "linf" and self.first_order_weight > 0.0:
            yield "objective", '"linf" has no first-order term; leave `first_order_weight` out'

    @property
    def metrics(self) -> tuple[Choice]:
        """The metric with its parameters."""
        return (choice(self.metric),)

    @property
    def descriptors(self) -> tuple[Choice]:
        """The descriptor with its parameters."""
        return (choice(self.descriptor),)

    @property
    def spectrum_size(self) -> int:
        """Eigenpairs that are computed of each shape."""
        described = _eigenpairs(self.descriptors) if self.first_order_weight > 0.0 else 0
        return max(self.eigenpairs, described)

    def signature_name(self, key: SpectrumKey) -> str:
        """Return the name of a signature in the cache: all that it depends on, without `points`.

        Parameters
        ----------
        key
            Name of the shape's spectrum.
        """
        described = self.descriptors if self.first_order_weight > 0.0 else ()
        texts = [one.model_dump_json() for one in (*self.metrics, *described)]
        digest = hashlib.sha256("|".join(texts).encode()).hexdigest()[:16]
        return f"{key}:signature:{digest}:v{SIGNATURE_VERSION}"


class PrototypeStructures(solver.PrototypeStructures):
    """Structures of shapes that are compared with a prototype."""

    eigenpairs: Eigenpairs = solver.DEFAULT_EIGENPAIRS
    geodesic_method: GeodesicMethod = solver.DEFAULT_GEODESIC_METHOD
    normalise: Normalise = True

    @property
    def metrics(self) -> tuple[Choice, ...]:
        """The metrics by level, coarsest first; the last holds for all further levels."""
        return choices(self.metric)

    @property
    def descriptors(self) -> tuple[Choice, ...]:
        """The descriptors by level, coarsest first; the last holds for all further levels."""
        return choices(self.descriptor)

    @property
    def spectral(self) -> bool:
        """Whether Laplace-Beltrami eigenpairs are used, if only to sample points."""
        used = (*self.metrics, *self.descriptors, *choices(self.sampling))
        return any(one.about.spectral for one in used)


class PrototypeParameters(PrototypeStructures, solver.PrototypeOptions):
    """Parameters of learning a prototype; all have defaults that suit most classes.

    Section and equation numbers are those of Wang, Bronstein and Paragios, INRIA RR-7333, 2010.
    """

    correspondence: CorrespondenceSource = "matches"
    simplify: Simplify = None

    @property
    def needs_spectrum(self) -> bool:
        """Whether learning uses the spectrum of the shapes, if only to match them."""
        return self.spectral or self.correspondence == "matches"

    @property
    def spectrum_size(self) -> int:
        """Eigenpairs that are computed of each shape."""
        return max(self.eigenpairs, _eigenpairs(self.descriptors))

    @property
    def largest_component(self) -> bool:
        """Whether the largest of several components is meant: examples are taken whole."""
        return False


def _eigenpairs(descriptors: Iterable[Choice]) -> int:
    """Eigenpairs that descriptors need, beside those that every shape has."""
    return max((1 + one.count for one in descriptors if isinstance(one, Eigenfunctions)), default=0)
