"""Objects of a simulated drive."""

from __future__ import annotations

from collections.abc import Mapping

from canopen.objectdictionary import ObjectDictionary, ODVariable

from handcart.backends.can.drives.drive_dictionary import drive_dictionary

_OWN: Mapping[int, int] = {0x6085: 2_000_000, 0x607F: 2**32 - 1}
"""Fixed objects that cannot be written: braking in counts/s², and no limit of the speed."""


class DriveObjects:
    """Values of a simulated drive's objects by index and sub-index; the defaults of its EDS until written.

    An object that a maker's EDS lacks cannot be read by SDO, but the simulated drive uses its value.
    """

    def __init__(self, node: int, dictionary: ObjectDictionary | None = None) -> None:
        """Create the objects of a node, by a maker's EDS, or by our own."""
        self._plain = drive_dictionary(node)
        self.dictionary = self._plain if dictionary is None else dictionary
        """Objects that can be read by SDO."""
        self._values: dict[tuple[int, int], int] = {}

    def __call__(self, index: int, subindex: int = 0) -> int:
        """Return the value of an object."""
        key = (index, subindex)
        if key not in self._values:
            if index == 0x6084 and not self.described(index):
                return self(0x6083)
            self._values[key] = self._default(index, subindex)
        return self._values[key]

    def __setitem__(self, index: int | tuple[int, int], value: int) -> None:
        self._values[(index, 0) if isinstance(index, int) else index] = value

    def reset(self) -> None:
        """Reset the values of all objects to their defaults, as when the drive is switched on."""
        self._values.clear()

    def described(self, index: int, subindex: int = 0) -> bool:
        """Return True if the drive's EDS describes the object, so that it can be read by SDO."""
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
