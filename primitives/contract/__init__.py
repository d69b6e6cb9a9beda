"""What every primitive promises, and the attempt that holds it to that."""
