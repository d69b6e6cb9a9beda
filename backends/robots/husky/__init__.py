"""A Husky: four wheels steered by their sides; arms of other makers are put onto it."""
