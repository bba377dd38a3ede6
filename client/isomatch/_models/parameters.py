"""The parameters of jobs: one list for the SDK, the command line and the answers."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any, TypeAlias

# Pydantic reads a TypedDict of the standard library only from Python 3.12 on.
from typing_extensions import TypedDict

StructureChoice: TypeAlias = str | dict[str, Any]
"""A metric or a descriptor: its name, or that as ``"name"`` and its parameters."""


class MatchParameters(TypedDict, total=False):
    """Keyword arguments of :meth:`isomatch.Client.match`; all may be left out.

    What is left out takes the service's default (in brackets). Section and equation numbers are
    those of Wang, Bronstein and Paragios, INRIA RR-7333, 2010.

    Attributes
    ----------
    points
        Points of the source that are matched at the finest level, 3 to 256 [32].
    coarse_points
        Points of the coarsest level, which is solved to proven optimality (N_1 of section 4.1),
        3 to 10 [8].
    level_factor
        How many times more points each level has than the one before (q of section 4.1),
        2 to 4 [2].
    oversampling
        Target samples for each source sample on the finer levels, 1 to 8 [4].
    rho
        Radius of the neighbourhood in which a match may move from one level to the next, in
        covering radii of the level (section 4.1), over 1 and at most 4 [1.5].
    metric
        Distance that is to be preserved: one for all levels, or one for each from the coarsest
        on, of which the last is repeated. Each is a name, or a dictionary of its ``"name"`` and
        its parameters, such as ``{"name": "diffusion", "time": 0.02}``; see
        :meth:`isomatch.Client.structures` [``["commute_time", "geodesic"]``].
    descriptor
        Local descriptor that is to be preserved, given like `metric`; ``"none"`` switches the
        first-order term off [``"si_hks"``].
    beta
        Weight of the second-order (metric) term of (5), 0 to 1e6 [1.0].
    first_order_weight
        Weight of the first-order (descriptor) term of (5), 0 to 1e6 [0.05].
    occlusion_cost
        Cost of leaving a source point unmatched, gamma of (5); None makes it large enough that
        every point is matched [None].
    eigenpairs
        Eigenpairs of the Laplace-Beltrami operator, 10 to 300 [100].
    geodesic_method
        How geodesic distances are computed: ``"fast_marching"``, ``"graph"`` (faster, errs by
        2 %) or ``"heat"`` (smooth, errs by 1 to 5 %) [``"fast_marching"``].
    alternatives
        How many of the best solutions of the coarse level are kept and refined, 1 to 32 [8].
    objective
        What is minimised: ``"l2"``, the energy (5), or ``"linf"``, the greatest distortion of a
        distance, half of which is the Gromov-Hausdorff distance of the matched samples. The
        latter is solved exactly, for at most 10 points, all of which are matched [``"l2"``].
    refine
        ``"gmds"`` to find where the matched points lie on the target between its vertices, by
        generalized multidimensional scaling (section 7.1), which :attr:`Match.refinement` then
        has; None not to [None].
    orientation
        Whether to tell left from right, of which the energy says nothing, by extending the
        hypotheses to all vertices; takes some seconds, and alternatives may then have less energy.
        `dense` and `refine` include it. With a prototype that keeps surfaces of its examples it
        is the default, and tells too which front leg goes with which hind leg [False].
    dense
        Whether to extend the match to all vertices, which :attr:`Match.dense` then has [False].
    landmarks
        Pairs of vertices known to correspond, in the files of the source and of the target, at
        most 32; they are matched with one another and decide between symmetric solutions [[]].
    normalise
        Scale both shapes to unit area first. If False, distances and the parameters of structures
        are in the files' unit of length, and parameters left out suit the geometric mean of both
        areas [True].
    largest_component
        Match the largest component of a shape that has several, which is refused otherwise
        [False].
    simplify
        Vertices to which a shape that has more is simplified before it is matched, 100 to
        1,000,000; points are named by vertices of the file. None for no simplification [None].
    time_limit
        Seconds after which the best answer so far is returned with its gap; None for no limit
        [None].
    """

    points: int
    coarse_points: int
    level_factor: int
    oversampling: int
    rho: float
    metric: StructureChoice | list[StructureChoice]
    descriptor: StructureChoice | list[StructureChoice]
    beta: float
    first_order_weight: float
    occlusion_cost: float | None
    eigenpairs: int
    geodesic_method: str
    alternatives: int
    objective: str
    refine: str | None
    orientation: bool
    dense: bool
    landmarks: list[tuple[int, int]]
    normalise: bool
    largest_component: bool
    simplify: int | None
    time_limit: float | None


class DissimilarityParameters(TypedDict, total=False):
    """Keyword arguments of :meth:`isomatch.Client.dissimilarities`; all may be left out.

    What is left out takes the service's default (in brackets).

    Attributes
    ----------
    points
        Points of each shape, all of which are matched, to proven optimality, 3 to 10 [6].
    metric
        Distance whose distortion is measured: a name, or a dictionary of its ``"name"`` and its
        parameters, such as ``{"name": "diffusion", "time": 0.02}`` [``"commute_time"``].
    descriptor
        Local descriptor of the first-order term, given likewise; it is not looked at without a
        `first_order_weight` [``"si_hks"``].
    first_order_weight
        Weight of the first-order (descriptor) term, 0 to 1e6 [0.0].
    objective
        What the dissimilarity of two shapes is: ``"l2"``, the least energy (5) of a matched point,
        or ``"linf"``, the least greatest distortion of a distance, twice the Gromov-Hausdorff
        distance of the matched points [``"l2"``].
    eigenpairs
        Eigenpairs of the Laplace-Beltrami operator, 10 to 300 [100].
    largest_component
        Compare the largest component of a shape that has several, which is refused otherwise
        [False].
    simplify
        Vertices to which a shape that has more is simplified first; None for no simplification
        [None].
    """

    points: int
    metric: StructureChoice
    descriptor: StructureChoice
    first_order_weight: float
    objective: str
    eigenpairs: int
    largest_component: bool
    simplify: int | None


class PrototypeParameters(TypedDict, total=False):
    """Keyword arguments of :meth:`isomatch.Client.learn_prototype`; all may be left out.

    What is left out takes the service's default (in brackets).

    Attributes
    ----------
    points
        Points of the prototype, 3 to 256. Of those in `correspondences` so many are taken, the
        farthest from one another; all of them if this is left out [32].
    components
        Gaussians of each mixture (K of section 6.4), 1 to 16; no more than half the number of
        examples are used [5].
    select_components
        Choose the number of Gaussians by the Bayesian information criterion, up to `components`
        [False].
    correspondence
        Which points of the shapes correspond: ``"matches"`` has the reference matched to every
        other shape, ``"shared_connectivity"`` takes the same vertex of every file, which must all
        have the same faces [``"matches"``].
    metric
        Distance of every two points, whose distribution is learned, given as for a match: one for
        all levels, or a list from the coarsest on [``"geodesic"``].
    descriptor
        Local descriptor of every point, likewise; ``"none"`` for distances alone [``"si_hks"``].
    sampling
        Metrics, given like `metric`, in which points of a shape are sampled, farthest first and by
        turns [``["commute_time", "geodesic"]``].
    eigenpairs
        Eigenpairs of the Laplace-Beltrami operator, 10 to 300 [100].
    geodesic_method
        How geodesic distances are computed, as for a match [``"fast_marching"``].
    normalise
        Scale all shapes to unit area first; if False, sizes belong to the class [True].
    simplify
        Vertices to which larger shapes are simplified first, if they are matched; None for no
        simplification [None].
    seed
        Of what is random in learning [0].
    """

    points: int
    components: int
    select_components: bool
    correspondence: str
    metric: StructureChoice | list[StructureChoice]
    descriptor: StructureChoice | list[StructureChoice]
    sampling: StructureChoice | list[StructureChoice]
    eigenpairs: int
    geodesic_method: str
    normalise: bool
    simplify: int | None
    seed: int


def check_names(
    given: Mapping[str, object], known: Mapping[str, object], method: str = "match"
) -> None:
    """Refuse a misspelt parameter before anything is sent, as Python refuses a misspelt argument.

    Parameters
    ----------
    given
        The parameters.
    known
        Those there are, such as ``MatchParameters.__annotations__``.
    method
        Who takes them.

    Raises
    ------
    TypeError
        A name is not a parameter.
    """
    unknown = sorted(set(given) - set(known))
    if unknown:
        raise TypeError(
            f"{method}() got unexpected parameter {', '.join(map(repr, unknown))}; "
            f"it takes {', '.join(sorted(known))}"
        )


def structure_choice(text: str) -> StructureChoice:
    """Return the structure that a line of text names, as in ``hks:times=0.1,1``.

    Parameters
    ----------
    text
        A name, and after colons its parameters; several values of one are separated by commas.

    Raises
    ------
    ValueError
        A parameter has no value.
    """
    name, *given = text.split(":")
    parameters: dict[str, Any] = {}
    for one in given:
        key, separator, value = one.partition("=")
        if not (key and separator and value):
            raise ValueError(f"{one!r} in {text!r} is not of the form parameter=value")
        parameters[key] = _values(value)
    return {"name": name, **parameters} if parameters else name


def _values(text: str) -> Any:
    if "," in text:
        return [_number(part) for part in text.split(",") if part]
    return _number(text)


def _number(text: str) -> int | float | str:
    # What is no number is left to the service, which says what it should be.
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text
