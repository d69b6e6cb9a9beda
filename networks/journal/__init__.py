"""What is decided, written first; and reading it back."""
