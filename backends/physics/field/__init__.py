"""What lays sensors in physics."""
