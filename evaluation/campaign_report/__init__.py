"""Statistics of a campaign."""
