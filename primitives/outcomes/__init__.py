"""Outcomes of actions, discrepancies, causes and their evidence."""

from . import causes as causes
