"""World model section of a seam."""

from __future__ import annotations

from dataclasses import dataclass
from dataclasses import field as dataclass_field
from typing import Any, ClassVar, Self

from typing_extensions import override

from handcart.files.models.loading import load
from handcart.primitives.knowledge.section import NamedFiles, Section
from handcart.primitives.seam.seam_file import load_seam
from handcart.primitives.seam.seam_work import SeamWork
from handcart.primitives.seam.work_piece import WorkPiece
from handcart.robotics.manipulation.paths.tool_path import ToolPath


@dataclass
class Seam(Section):
    """Section of a world model with a seam, its work piece and the progress of tracking it."""

    LEARNED: ClassVar = ("seam_work",)

    seam: ToolPath | None = None
    """The path of the tool, on the map."""
    work_piece: WorkPiece | None = None
    """Work piece with the seam."""
    seam_work: SeamWork = dataclass_field(default_factory=SeamWork)
    """Progress on the seam, and the places of the remaining parts."""

    @classmethod
    @override
    def load(cls, files: NamedFiles) -> Self:
        seam = files.read("seam", load_seam)
        return cls(seam, files.read("work_piece", lambda path: load(path, WorkPiece)))

    @override
    def noted(self) -> dict[str, Any]:
        return {
            "seam_tracked": self.seam_work.tracked,
            "seam_rest": [list(item) for item in self.seam_work.rest],
        }
