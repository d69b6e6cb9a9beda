"""The whole of a world's file: general keys, and those of all domains."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from pydantic import create_model

from handcart.backends.simulation.world.world_file import WorldFile
from handcart.tasks import domain

if TYPE_CHECKING:
    from handcart.backends.simulation.world.props import Props
    from handcart.files.models.model import FileModel


def kinds_of_props() -> Mapping[str, type[Props[Any]]]:
    """Return the class that simulates the things of each application domain, by the domain's name.

    The domains are always in the same order.
    """
    declared = domain.domains()
    return {domain_.name: domain.imported(domain_.props) for domain_ in declared if domain_.props is not None}


def world_model() -> type[WorldFile]:
    """Return the pydantic model of a world's file, composed of `WorldFile` and each domain's `Props.section`.

    Raises:
        ValueError: two domains define the same key or a validator of the same name, or a domain's key has no
            default.
    """
    return _composed(tuple(prop.section for prop in kinds_of_props().values()))


@cache
def _composed(sections: tuple[type[FileModel], ...]) -> type[WorldFile]:
    general: type[FileModel] = WorldFile
    names = Counter(name for section in (general, *sections) for name in _names(section))
    if twice := sorted(name for name, times in names.items() if times > 1):
        raise ValueError(f"two domains have the same name in their sections of a world: {', '.join(twice)}")
    needed = [
        key for section in sections for key, field in section.model_fields.items() if field.is_required()
    ]
    if needed:
        raise ValueError(f"a world can't be made to have {', '.join(needed)}; needed: a default")
    bases: Any = (*reversed(sections), WorldFile)
    model: type[WorldFile] = create_model(
        "WorldFile", __base__=bases, __doc__="What stands around the robot."
    )
    return model


def _names(section: type[FileModel]) -> set[str]:
    """Return the names of keys and validators: a common subclass would lose one of two that are alike."""
    found = section.__pydantic_decorators__
    return {*section.model_fields, *found.model_validators, *found.field_validators}
