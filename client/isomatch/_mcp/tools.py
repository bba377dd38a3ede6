"""The tools: upload, match, compare, transfer and picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Final, Literal, cast

from mcp.server.mcpserver import Context, Image
from mcp.server.mcpserver.exceptions import ToolError
from pydantic import Field

from isomatch._clients import AsyncClient
from isomatch._errors import IsomatchError
from isomatch._mcp.answers import (
    CompareAnswer,
    MatchAnswer,
    TransferAnswer,
    UploadAnswer,
    compare_answer,
    match_answer,
    transfer_answer,
    upload_answer,
)
from isomatch._mcp.errors import message, tool_errors
from isomatch._mcp.folder import Folder
from isomatch._mcp.jobs import finished
from isomatch._models import (
    DissimilarityParameters,
    MatchParameters,
    Shape,
    is_prototype_id,
    is_shape_id,
)
from isomatch._operations.result_files import (
    COMPARE_FORMATS,
    MATCH_FORMATS,
    TRANSFER_FORMATS,
    check_format,
    shows_dense_map,
)
from isomatch._operations.results import View
from isomatch._results import Direction, Element, Result, TransferKind

SHAPE: Final = "Path of a mesh file in the folder of this server, or the id of an uploaded shape."
SAVE_TO: Final = (
    "New file for the whole result, in the folder of this server, in the format of its ending"
)

Mesh = Annotated[str, Field(description=SHAPE)]
MatchFile = Annotated[
    str | None,
    Field(
        description=f"{SAVE_TO}: json, npz (arrays) or csv (pairs); ply, obj or glb need `dense`."
    ),
]


@dataclass(frozen=True)
class Tools:
    """The tools, with what they share.

    Attributes
    ----------
    client
        Of the service.
    folder
        Folder of the files.
    """

    client: AsyncClient
    folder: Folder

    async def upload(
        self, path: Annotated[str, Field(description="Path of a mesh file in the folder.")]
    ) -> UploadAnswer:
        """Upload a mesh, or points.

        Formats are OFF, OBJ, PLY, STL, GLB, GLTF and ZIP, of points PLY, LAS, LAZ, XYZ, TXT and
        CSV. The answer has its size and what was repaired. Other tools take paths as well, so this
        is needed only to look at a mesh.
        """
        with tool_errors():
            return upload_answer(await self.client.upload(self.folder.readable(path)))

    async def match(
        self,
        source: Mesh,
        target: Mesh,
        context: Context[Any, Any],
        dense: Annotated[
            bool, Field(description="Map all vertices, not only points: `transfer` needs it.")
        ] = False,
        points: Annotated[
            int | None, Field(description="Points to match, 3 to 256; 32 if left out.")
        ] = None,
        orientation: Annotated[
            bool, Field(description="Match left with left; if false, a mirror image is as good.")
        ] = True,
        partial: Annotated[
            Literal["detected", "source", "target", "both", "none"],
            Field(
                description="Which shape is only a part of the other, as of a scan with holes;"
                " both, if each lacks points of the other."
            ),
        ] = "detected",
        landmarks: Annotated[
            list[tuple[int, int]] | None,
            Field(description="Known pairs of vertices, of source and target, up to 32."),
        ] = None,
        simplify: Annotated[
            int | None,
            Field(
                description="Simplify larger shapes to this many vertices first, 100 to 1,000,000:"
                " faster."
            ),
        ] = None,
        time_limit: Annotated[
            float | None,
            Field(
                description="Seconds, over 0, up to 86,400, after which the best answer is given."
            ),
        ] = None,
        save_to: MatchFile = None,
    ) -> MatchAnswer:
        """Find corresponding points on two surfaces, one of which is a deformation of the other.

        The answer has the energy (less is better), a certificate of what is proven of it, and the
        probability that the match is right, with the reasons for doubt. Tell the user when it is
        in doubt. Lasts seconds to minutes.
        """
        given = _given(
            dense=dense,
            points=points,
            orientation=orientation,
            partial=partial,
            landmarks=landmarks,
            simplify=simplify,
            time_limit=time_limit,
        )
        parameters = cast(MatchParameters, given)
        with tool_errors():
            file = self._new_file(save_to, MATCH_FORMATS)
            if file is not None and shows_dense_map(file) and not dense:
                raise ToolError(f"save_to: {file.suffix} shows a map of all vertices; set `dense`")
            first, second = await self._source(source), await self._shape(target)
            job, result = await finished(self.client.match(first, second, **parameters), context)
            return match_answer(job.id, result, await self._save(job, result, file))

    async def compare(
        self,
        shapes: Annotated[list[str], Field(description=f"Two or more of: {SHAPE}")],
        context: Context[Any, Any],
        labels: Annotated[
            list[str] | None,
            Field(description="Class of each shape, by which retrieval is scored in the file."),
        ] = None,
        points: Annotated[
            int | None, Field(description="Points of each shape, 3 to 10; 6 if left out.")
        ] = None,
        save_to: Annotated[
            str | None, Field(description=f"{SAVE_TO}: json, npz or csv (matrix).")
        ] = None,
    ) -> CompareAnswer:
        """Compare shapes, all with all: how dissimilar they are, and which are nearest to each."""
        with tool_errors():
            file = self._new_file(save_to, COMPARE_FORMATS)
            compared = [await self._shape(shape) for shape in shapes]
            parameters = cast(DissimilarityParameters, _given(points=points))
            starting = self.client.dissimilarities(compared, labels, **parameters)
            job, result = await finished(starting, context)
            return compare_answer(job.id, result, await self._save(job, result, file))

    async def transfer(
        self,
        match: Annotated[str, Field(description="`job` of a match with `dense`.")],
        what: Annotated[TransferKind, Field(description="Kind of the values.")],
        context: Context[Any, Any],
        values: Annotated[
            str | None,
            Field(
                description="Path of a file with a value for each vertex or face, in the folder:"
                " npz, csv, ply, obj, glb, or seg or txt of a label a line. If left out, those in"
                " the file of the shape itself."
            ),
        ] = None,
        landmarks: Annotated[
            list[int] | None, Field(description="Vertices to carry, with `what` landmarks.")
        ] = None,
        direction: Annotated[
            Direction, Field(description="From which shape of the match to which.")
        ] = "source_to_target",
        on: Annotated[
            Element | None, Field(description="What of the other shape takes the values.")
        ] = None,
        names: Annotated[
            list[str] | None, Field(description="Only these attributes; all if left out.")
        ] = None,
        save_to: Annotated[
            str | None,
            Field(
                description=f"{SAVE_TO}: npz or csv of the values, ply, obj or glb of the shape"
                " with them. Needed for all but landmarks."
            ),
        ] = None,
    ) -> TransferAnswer:
        """Transfer values or landmarks from one shape of a match to the other.

        Values are written to a file; the images of landmarks are in the answer.
        """
        with tool_errors():
            if what != "landmarks" and save_to is None:
                raise ToolError(f"save_to: {what} are too many to be shown; name a file for them")
            file = self._new_file(save_to, TRANSFER_FORMATS[what])
            source = None
            if values is not None:
                source = await self.client.upload_attributes(self.folder.readable(values))
            starting = self.client.transfer(
                match,
                source,
                what=what,
                direction=direction,
                on=on,
                names=names or (),
                points=landmarks or (),
            )
            job, result = await finished(starting, context)
            return transfer_answer(job.id, result, await self._save(job, result, file))

    async def picture(
        self,
        job: Annotated[str, Field(description="`job` of a match or a comparison.")],
        view: Annotated[
            View | None, Field(description="Side from which a match is seen; front if left out.")
        ] = None,
        alternative: Annotated[
            int | None, Field(description="Which answer of a match: 0, or the number of another.")
        ] = None,
    ) -> Image:
        """Draw the result of a job: both shapes in corresponding colours, or the matrix."""
        with tool_errors():
            found = await self.client.job(job)
            return Image(data=await found.picture(alternative=alternative, view=view), format="png")

    def _new_file(self, name: str | None, formats: Sequence[str]) -> Path | None:
        """Return the file of a result, refused before the job runs if it cannot be written."""
        if name is None:
            return None
        file = self.folder.writable(name)
        check_format(file, formats)
        return file

    async def _save(self, job: Any, result: Result, file: Path | None) -> str | None:
        """Write the result of a job to a new file, and return the file's name in the folder."""
        if file is None:
            return None
        try:
            with TemporaryDirectory(prefix="isomatch-") as elsewhere:
                content = result.held(file.suffix.lower().removeprefix("."))
                if content is None:
                    saved = Path(elsewhere, file.name)
                    await job.save(saved)
                    content = saved.read_bytes()
                self.folder.write_new(file, content)
        except (IsomatchError, OSError, ValueError) as error:
            raise ToolError(f"job {job.id} has succeeded, but {message(error)}") from error
        return self.folder.name(file)

    async def _shape(self, given: str) -> Shape:
        if is_shape_id(given):
            return await self.client.shape(given)
        return await self.client.upload(self.folder.readable(given))

    async def _source(self, given: str) -> Shape | str:
        return given if is_prototype_id(given) else await self._shape(given)


def _given(**parameters: object) -> dict[str, object]:
    """Return the parameters that are not None; for others the service has defaults."""
    return {name: value for name, value in parameters.items() if value is not None}
