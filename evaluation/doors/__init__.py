"""Ground truth of opening and closing doors and drawers."""
