"""Pictures of a world without physics."""
