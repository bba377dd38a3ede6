"""Prototypes as bytes: a NumPy archive that holds numbers and a description in JSON."""

import io
import json
import math
import zipfile
from typing import Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from solver.arrays import array_header, npz_bytes
from solver.errors import OptionError, PrototypeError
from solver.matching import MAX_POINTS, MIN_POINTS
from solver.prototype.mixtures import GaussianMixtures
from solver.prototype.options import MAX_COMPONENTS
from solver.prototype.prototype import LearnedDescriptors, LearnedDistances, Prototype
from solver.prototype.surfaces import (
    EIGENVALUES,
    MOST_FACES,
    MOST_SURFACES,
    MOST_VERTICES,
    ExampleSurface,
)
from solver.shape.choices import (
    DESCRIPTORS,
    METRICS,
    DescriptorChoice,
    MetricChoice,
    NoDescriptor,
    Structure,
)
from solver.shape.geodesics import GEODESIC_METHODS

FORMAT = "isomatch-prototype"
VERSION = 1
"""Version of the format; archives of other versions are refused."""

_MAX_BYTES = 256 * 1024**2
"""Greatest size of the unpacked arrays. This and the following bound what an archive can make a
worker allocate; they are far above what learning makes."""

_ZIP = b"PK\x03\x04"

_MAX_LEVELS = 8
_MAX_DIMENSIONS = 1024
_MAX_ENERGIES = 1024


def prototype_to_bytes(prototype: Prototype) -> bytes:
    """Return a prototype as the bytes of an ``.npz`` file, exact to the last bit.

    Parameters
    ----------
    prototype
        The prototype. Equal ones give equal bytes.
    """
    about: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "components": prototype.components,
        "examples": prototype.examples,
        "normalise": prototype.normalise,
        "eigenpairs": prototype.eigenpairs,
        "geodesic_method": prototype.geodesic_method,
        "warnings": list(prototype.warnings),
        "sampling": [_described(one) for one in prototype.sampling],
        "metrics": [_described(one.metric) for one in prototype.distances],
        "descriptors": [
            _described(NoDescriptor() if one is None else one.descriptor)
            for one in prototype.descriptors
        ],
        "distance_backgrounds": [one.log_background for one in prototype.distances],
        "descriptor_backgrounds": [
            0.0 if one is None else one.log_background for one in prototype.descriptors
        ],
    }
    if prototype.surfaces:  # older archives lack this key
        about["surfaces"] = len(prototype.surfaces)
    arrays: dict[str, NDArray[Any]] = {
        "about": np.frombuffer(json.dumps(about, sort_keys=True).encode(), dtype=np.uint8),
        "positions": prototype.positions,
        "vertices": prototype.vertices,
    }
    for level, distances in enumerate(prototype.distances):
        arrays |= _mixture_arrays(f"distances{level}", distances.mixtures)
    for level, descriptors in enumerate(prototype.descriptors):
        if descriptors is not None:
            name = f"descriptors{level}"
            arrays |= _mixture_arrays(name, descriptors.mixtures)
            arrays |= {f"{name}_centre": descriptors.centre, f"{name}_axes": descriptors.axes}
    if len(prototype.left_out_energies):  # older archives lack this array
        arrays["left_out_energies"] = prototype.left_out_energies
    for place, surface in enumerate(prototype.surfaces):
        arrays |= _surface_arrays(f"surface{place}", surface)
    return npz_bytes(arrays)


def prototype_from_bytes(data: bytes) -> Prototype:
    """Read the bytes of :func:`prototype_to_bytes`. Nothing in them is executed.

    Raises
    ------
    PrototypeError
        The bytes are not an archive of a sound prototype.
    """
    if not data.startswith(_ZIP):  # NumPy would suspect a pickle
        raise PrototypeError("not a prototype: this is no archive of arrays (.npz)")
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            size = sum(entry.file_size for entry in archive.zip.infolist())
            if size > _MAX_BYTES:
                raise PrototypeError("not a prototype: the archive is too large")
            _check_promises(archive.zip)
            arrays = {name: archive[name] for name in archive.files}
        about = json.loads(arrays["about"].tobytes().decode())
        return _prototype(about, arrays)
    except (PrototypeError, MemoryError):
        raise
    except KeyError as error:
        raise PrototypeError(f"not a prototype: the archive lacks {error}") from error
    except Exception as error:  # readers of damaged archives raise anything
        raise PrototypeError(f"not a prototype: {error or type(error).__name__}") from error


def _check_promises(archive: zipfile.ZipFile) -> None:
    """Refuse arrays whose headers promise more than their members hold, which would be allocated.

    Raises
    ------
    PrototypeError
        An array is cut off.
    ValueError, TypeError, SyntaxError, RecursionError
        A header is damaged.
    """
    for entry in archive.infolist():
        with archive.open(entry) as member:
            shape, kind = array_header(cast(BinaryIO, member))
        # NumPy would advise to allow pickle.
        _require(not kind.hasobject, entry.filename)
        _require(kind.itemsize * math.prod(shape) <= entry.file_size, entry.filename)


def _described(choice: Structure) -> dict[str, Any]:
    return {"name": choice.name} | {name: getattr(choice, name) for name in choice.parameters()}


def _mixture_arrays(name: str, mixtures: GaussianMixtures) -> dict[str, NDArray[Any]]:
    return {
        f"{name}_weights": mixtures.weights,
        f"{name}_means": mixtures.means,
        f"{name}_covariances": mixtures.covariances,
    }


def _surface_arrays(name: str, surface: ExampleSurface) -> dict[str, NDArray[Any]]:
    return {
        f"{name}_vertices": surface.vertices.astype(np.float32),
        f"{name}_faces": surface.faces.astype(np.int32),
        f"{name}_points": surface.points.astype(np.int32),
        f"{name}_eigenvalues": surface.eigenvalues,
    }


def _prototype(about: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Prototype:
    if about["format"] != FORMAT:
        raise PrototypeError("not a prototype: the archive holds something else")
    if about["version"] != VERSION:
        raise PrototypeError(
            f"the prototype is of format version {about['version']}, and only {VERSION} is read"
        )
    positions = _numbers(arrays, "positions", 2)
    vertices = arrays["vertices"]
    points = len(vertices)
    _require(MIN_POINTS <= points <= MAX_POINTS, "number of points")
    _require(positions.shape == (points, 3), "positions")
    whole = np.issubdtype(vertices.dtype, np.integer) and vertices.shape == (points,)
    _require(whole and bool((vertices >= 0).all()), "vertices")
    components = _whole(about, "components", 1, MAX_COMPONENTS)
    _require(about["geodesic_method"] in GEODESIC_METHODS, "geodesic_method")
    _require(isinstance(about["normalise"], bool), "normalise")
    warnings = about["warnings"]
    _require(all(isinstance(one, str) for one in warnings), "warnings")
    for kind in ("metrics", "descriptors", "sampling"):
        _require(1 <= len(about[kind]) <= _MAX_LEVELS, kind)
    return Prototype(
        distances=tuple(
            _distances(about, arrays, level, points) for level in range(len(about["metrics"]))
        ),
        descriptors=tuple(
            _descriptors(about, arrays, level, points) for level in range(len(about["descriptors"]))
        ),
        sampling=tuple(map(_metric, about["sampling"])),
        positions=positions,
        vertices=vertices.astype(np.int64),
        components=components,
        examples=_whole(about, "examples", 1, 10**9),
        normalise=about["normalise"],
        eigenpairs=_whole(about, "eigenpairs", 2, 10**6),
        geodesic_method=about["geodesic_method"],
        warnings=tuple(warnings),
        surfaces=_surfaces(about, arrays, points),
        left_out_energies=_energies(arrays),
    )


def _energies(arrays: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    if "left_out_energies" not in arrays:
        return np.zeros(0)
    energies = _numbers(arrays, "left_out_energies", 1)
    _require(1 <= len(energies) <= _MAX_ENERGIES, "left_out_energies")
    _require(energies[0] >= 0.0 and bool((np.diff(energies) >= 0.0).all()), "left_out_energies")
    return energies


def _surfaces(
    about: dict[str, Any], arrays: dict[str, NDArray[Any]], points: int
) -> tuple[ExampleSurface, ...]:
    """Read surfaces; their soundness is checked when meshes are made of them."""
    if "surfaces" not in about:
        return ()
    count = _whole(about, "surfaces", 1, MOST_SURFACES)
    return tuple(_surface(arrays, f"surface{place}", points) for place in range(count))


def _surface(arrays: dict[str, NDArray[Any]], name: str, points: int) -> ExampleSurface:
    vertices, faces = arrays[f"{name}_vertices"], arrays[f"{name}_faces"]
    places, eigenvalues = arrays[f"{name}_points"], _numbers(arrays, f"{name}_eigenvalues", 1)
    single = vertices.dtype == np.float32 and vertices.ndim == 2 and vertices.shape[1] == 3
    _require(single and bool(np.isfinite(vertices).all()), f"{name}_vertices")
    _require(len(vertices) <= MOST_VERTICES, f"{name}_vertices")
    whole = faces.dtype == np.int32 and faces.ndim == 2 and faces.shape[1] == 3
    _require(whole and _name_vertices(faces, len(vertices)), f"{name}_faces")
    _require(len(faces) <= MOST_FACES, f"{name}_faces")
    named = places.dtype == np.int32 and places.shape == (points,)
    _require(named and _name_vertices(places, len(vertices)), f"{name}_points")
    rising = eigenvalues.shape == (EIGENVALUES,) and bool((np.diff(eigenvalues) >= 0.0).all())
    _require(rising and eigenvalues[0] > 0.0, f"{name}_eigenvalues")
    return ExampleSurface(
        vertices.astype(np.float64), faces.astype(np.int64), places.astype(np.int64), eigenvalues
    )


def _name_vertices(numbers: NDArray[np.int32], count: int) -> bool:
    return len(numbers) > 0 and bool((numbers >= 0).all() and (numbers < count).all())


def _distances(
    about: dict[str, Any], arrays: dict[str, NDArray[Any]], level: int, points: int
) -> LearnedDistances:
    metric = _metric(about["metrics"][level])
    mixtures = _mixtures(arrays, f"distances{level}", points * (points - 1) // 2)
    _require(mixtures.dimension == 1, "dimension of distances")
    return LearnedDistances(metric, mixtures, _finite(about["distance_backgrounds"][level]))


def _descriptors(
    about: dict[str, Any], arrays: dict[str, NDArray[Any]], level: int, points: int
) -> LearnedDescriptors | None:
    descriptor = _choice(about["descriptors"][level], DESCRIPTORS)
    assert isinstance(descriptor, DescriptorChoice)
    if isinstance(descriptor, NoDescriptor):
        return None
    name = f"descriptors{level}"
    centre, axes = _numbers(arrays, f"{name}_centre", 1), _numbers(arrays, f"{name}_axes", 2)
    mixtures = _mixtures(arrays, name, points)
    _require(len(centre) <= _MAX_DIMENSIONS, "dimension of descriptors")
    _require(axes.shape == (len(centre), mixtures.dimension), "axes of descriptors")
    background = _finite(about["descriptor_backgrounds"][level])
    return LearnedDescriptors(descriptor, centre, axes, mixtures, background)


def _metric(given: dict[str, Any]) -> MetricChoice:
    choice = _choice(given, METRICS)
    assert isinstance(choice, MetricChoice)
    return choice


def _choice(
    given: dict[str, Any],
    known: "dict[str, type[MetricChoice]] | dict[str, type[DescriptorChoice]]",
) -> Structure:
    parameters = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in given.items()
        if name != "name"
    }
    try:
        choice: Structure = known[given["name"]](**parameters)
    except OptionError as error:
        raise PrototypeError(f"not a sound prototype: {error}") from error
    _require(choice == choice.settled(), "parameters of structures")
    return choice


def _mixtures(arrays: dict[str, NDArray[Any]], name: str, count: int) -> GaussianMixtures:
    weights = _numbers(arrays, f"{name}_weights", 2)
    means = _numbers(arrays, f"{name}_means", 3)
    covariances = _numbers(arrays, f"{name}_covariances", 4)
    _require(len(weights) == count and 1 <= weights.shape[1] <= MAX_COMPONENTS, f"{name}_weights")
    _require(1 <= means.shape[2] <= _MAX_DIMENSIONS, f"{name}_means")
    try:
        return GaussianMixtures(weights, means, covariances)
    except ValueError as error:
        raise PrototypeError(f"not a sound prototype: {name}: {error}") from error


def _numbers(arrays: dict[str, NDArray[Any]], name: str, dimensions: int) -> NDArray[np.float64]:
    array = arrays[name]
    _require(array.dtype == np.float64 and array.ndim == dimensions, name)
    _require(bool(np.isfinite(array).all()), name)
    return array


def _whole(about: dict[str, Any], name: str, least: int, most: int) -> int:
    value = about[name]
    _require(type(value) is int and least <= value <= most, name)
    return int(value)


def _finite(value: Any) -> float:
    _require(isinstance(value, float) and bool(np.isfinite(value)), "background")
    return float(value)


def _require(condition: bool, what: str) -> None:
    if not condition:
        raise PrototypeError(f"not a sound prototype: wrong {what}")
