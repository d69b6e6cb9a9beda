"""Knowledge of plants."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.knowledge.section import Section

Positive = Annotated[float, Field(gt=0.0)]


class Can(LevelPose):
    """The can on the robot's own table, in the base frame: the middle of its foot."""

    size_m: tuple[Positive, Positive, Positive] = (0.04, 0.04, 0.06)


class Plant(Can):
    """A plant's pot, on the map."""

    size_m: tuple[Positive, Positive, Positive] = (0.12, 0.12, 0.1)
    needs_ml: Positive


class PlantsFile(FileModel):
    """Plants and the can."""

    format: Literal["handcart-plants/1"]
    can: Can
    plants: dict[str, Plant]


@dataclass
class Plants(Section):
    """Knowledge of a robot that waters plants."""

    FILES: ClassVar = {"garden": PlantsFile}
    LEARNED: ClassVar = ("watered",)

    garden: PlantsFile | None = None
    watered: Mapping[str, float] = field(default_factory=dict)  # [ml], by the scale in the hand

    def names(self) -> Mapping[str, Collection[object]]:
        return {"plants": list(self.garden.plants)} if self.garden else {}
