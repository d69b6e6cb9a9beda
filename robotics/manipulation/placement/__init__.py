"""Base placements for a path of the arm's tool."""
