"""How an action ends: outcomes, discrepancies, causes and their evidence."""
