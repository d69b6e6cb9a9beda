"""What a simulated drive keeps in its objects."""

from __future__ import annotations

import canopen

from backends.can.drive_dictionary import drive_dictionary


class DriveObjects:
    """Values by index and sub-index: those of the EDS until something else is written."""

    def __init__(self, node: int) -> None:
        """Those of a node."""
        self.dictionary = drive_dictionary(node)
        self._values: dict[tuple[int, int], int] = {}

    def __call__(self, index: int, subindex: int = 0) -> int:
        """The value of an object."""
        key = (index, subindex)
        if key not in self._values:
            self._values[key] = int(self._entry(index, subindex).default or 0)
        return self._values[key]

    def __setitem__(self, index: int | tuple[int, int], value: int) -> None:
        self._values[(index, 0) if isinstance(index, int) else index] = value

    def reset(self) -> None:
        """As after power on."""
        self._values.clear()

    def _entry(self, index: int, subindex: int) -> canopen.objectdictionary.ODVariable:
        found = self.dictionary[index]
        return found if isinstance(found, canopen.objectdictionary.ODVariable) else found[subindex]
