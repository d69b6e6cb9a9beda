"""What a backend may be able to do."""
