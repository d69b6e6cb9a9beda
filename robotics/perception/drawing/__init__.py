"""Pictures of what perception has found."""
