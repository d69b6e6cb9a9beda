"""What a simulated drive keeps in its objects."""

from __future__ import annotations

from collections.abc import Mapping

from canopen.objectdictionary import ObjectDictionary, ODVariable

from handcart.backends.can.drives.drive_dictionary import drive_dictionary

_OWN: Mapping[int, int] = {0x6085: 2_000_000, 0x607F: 2**32 - 1}
"""What a drive does by itself that can't be told: how it brakes, in counts/s², and no limit of its speed."""


class DriveObjects:
    """Values by index and sub-index: those of the EDS until something else is written.

    What a maker's EDS doesn't describe, or has no default for, the drive has for itself alone.
    """

    def __init__(self, node: int, dictionary: ObjectDictionary | None = None) -> None:
        """Those of a node, by a maker's EDS, or by our own."""
        self._plain = drive_dictionary(node)
        self.dictionary = self._plain if dictionary is None else dictionary
        """What it can be asked for."""
        self._values: dict[tuple[int, int], int] = {}

    def __call__(self, index: int, subindex: int = 0) -> int:
        """The value of an object."""
        key = (index, subindex)
        if key not in self._values:
            if index == 0x6084 and not self.described(index):
                return self(0x6083)
            self._values[key] = self._default(index, subindex)
        return self._values[key]

    def __setitem__(self, index: int | tuple[int, int], value: int) -> None:
        self._values[(index, 0) if isinstance(index, int) else index] = value

    def reset(self) -> None:
        """As after power on."""
        self._values.clear()

    def described(self, index: int, subindex: int = 0) -> bool:
        """Whether it can be asked for."""
        return _entry(self.dictionary, index, subindex) is not None

    def _default(self, index: int, subindex: int) -> int:
        if not self.described(index, subindex) and index in _OWN:
            return _OWN[index]
        for dictionary in (self.dictionary, self._plain):
            entry = _entry(dictionary, index, subindex)
            if entry is not None and isinstance(entry.default, int):
                return int(entry.default)
        return 0


def _entry(dictionary: ObjectDictionary, index: int, subindex: int) -> ODVariable | None:
    found = dictionary.get(index)
    if isinstance(found, ODVariable):
        return found if subindex == 0 else None
    return found.get(subindex) if found is not None else None
