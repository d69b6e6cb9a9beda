"""The robot in physics."""
