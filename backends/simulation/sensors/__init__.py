"""What a simulated robot's sensors read."""
