"""Classes that represent props in a physics engine."""

from __future__ import annotations

from typing import Any

from handcart.tasks import domain


class Bodies:
    """Table from classes of simulated objects to the classes that represent them in a physics engine, for all
    domains.
    """

    def __init__(self) -> None:
        """Collect the classes that all domains declare."""
        self._by_class: dict[type, Any] = {}
        for domain_ in domain.domains():
            if domain_.physics is not None:
                self._by_class |= domain.imported(domain_.physics)

    def of(self, what: object, default: Any) -> Any:
        """Return the class whose instances represent an object of the scene in a physics engine.

        Args:
            what: a movable thing, or the props (all things of an application domain). If the table has no
                entry for the object's own class, the entry of the nearest base class is used.
            default: result if no class represents the object.
        """
        found = (self._by_class[kind] for kind in type(what).__mro__ if kind in self._by_class)
        return next(found, default)
