"""What ground truth says of books; libraries made at random."""
