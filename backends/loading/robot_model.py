"""The model of a robot's file with the sections of all kinds of sensors."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import Field, create_model

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_spec import SensorName
from handcart.backends.description.sensor_table import TABLE_KEY
from handcart.backends.sensors.sensor_kind import sensor_specs
from handcart.files.models.field_docstrings import field_docstrings

if TYPE_CHECKING:
    from handcart.backends.description.sensor_spec import SensorSpec
    from handcart.files.yaml.yaml_document import Document


def model_for(document: Document) -> type[RobotFile]:
    """Return the pydantic model that validates a robot's file.

    The installed kinds of sensors are imported only for a file with the table `sensors`.
    """
    content = document.root.content
    return robot_model() if isinstance(content, dict) and TABLE_KEY in content else RobotFile


def robot_model() -> type[RobotFile]:
    """Return the pydantic model of a robot's file in which a sensor's `kind` determines its other keys.

    Raises:
        BrokenPlugin: a kind of sensor from another package cannot be used.
    """
    return _composed(tuple(sensor_specs().values()))


@cache
def _composed(specs: tuple[type[SensorSpec], ...]) -> type[RobotFile]:
    kinds: Any = Union[specs]  # noqa: UP007  computed
    sensor: Any = Annotated[kinds, Field(discriminator="kind")]
    table: Any = (dict[SensorName, sensor], Field(default_factory=dict, description=_description()))
    fields = {TABLE_KEY: table}
    return create_model("RobotFile", __base__=RobotFile, __doc__=RobotFile.__doc__, **fields)


def _description() -> str | None:
    return field_docstrings(RobotFile).get(TABLE_KEY)
