"""World model section of an activity: which definition a task was made from. Only its judge reads it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.primitives.knowledge.section import Section

Name = Annotated[str, Field(min_length=1, max_length=120)]


class ActivityFile(FileModel):
    """File that maps the terms in an activity's definition (BEHAVIOR-1K) to names in the task's world."""

    format: Literal["handcart-activity/1"]
    activity: Name
    """Name of the activity in BEHAVIOR-1K."""
    definition: Annotated[int, Field(ge=0)] = 0
    """Number of its definition."""
    furniture: dict[Name, tuple[Name, ...]]
    """Furniture of the world that makes up each piece, by the term in the definition."""
    objects: dict[Name, Name]
    """Names of objects in the world, by the term in the definition."""
    floors: dict[Name, tuple[float, float, float, float]] = Field(default_factory=dict)
    """Part of the floor by its term in the definition, as least x, least y, greatest x and greatest y on the
    map, in [m] (default: the complete floor).
    """
    beside: dict[Name, Name] = Field(default_factory=dict)
    """Term in the definition of what a moved object has to be next to, by the name of the object."""
    goal: dict[Name, tuple[Name, ...]] = Field(default_factory=dict)
    """Surfaces that each moved object may be on in the end, by the name of the object."""


@dataclass
class Activity(Section):
    """World model section with the household activity (goal of BEHAVIOR-1K) that the task has to achieve."""

    FILES: ClassVar = {"activity": ActivityFile}

    activity: ActivityFile | None = None
    """Definition and names; None for a task of another kind."""
