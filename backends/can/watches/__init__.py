"""What is looked out for on a bus."""
