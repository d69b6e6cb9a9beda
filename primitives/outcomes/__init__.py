"""How an action ends: outcomes, discrepancies, causes and their evidence."""

from . import causes as causes
