"""Classes that represent props in a physics engine."""

from __future__ import annotations

from typing import Any

from handcart.tasks import domain


class Bodies:
    """Classes of bodies in physics, by the class of the represented thing or props."""

    def __init__(self) -> None:
        """Collect the classes that all domains declare."""
        self._by_class: dict[type, Any] = {}
        for domain_ in domain.domains():
            if domain_.physics is not None:
                self._by_class |= domain.imported(domain_.physics)

    def of(self, what: object, default: Any) -> Any:
        """Return the class in physics that represents an object.

        Args:
            what: a thing or props; a class that represents one of its base classes counts, too.
            default: returned if no class represents it.
        """
        found = (self._by_class[kind] for kind in type(what).__mro__ if kind in self._by_class)
        return next(found, default)
