"""The blocks of a simulated world."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar, Self

from pydantic import model_validator
from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.props import Props
from handcart.backends.simulation.world.world_file import each_once
from handcart.files.models.model import FileModel

from .block import Block, BlockSpec


class BlocksSection(FileModel):
    """Section of a world's file with the blocks that a person puts down before a run."""

    blocks: tuple[BlockSpec, ...] = ()

    @model_validator(mode="after")
    def _each_block_once(self) -> Self:
        each_once("block", (block.name for block in self.blocks))
        return self


class BlockProps(Props[BlocksSection]):
    """Blocks of a simulated world that a person puts down before the run, and that the robot stacks."""

    section = BlocksSection
    STATE: ClassVar[Kinds] = {"blocks": dict[str, Block]}

    @override
    def set_up(self) -> None:
        self.blocks = {spec.name: Block.set_down(self.scene, spec, self.seed) for spec in self.spec.blocks}

    @override
    def things(self) -> Iterable[Block]:
        return self.blocks.values()
