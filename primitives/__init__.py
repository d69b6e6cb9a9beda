"""What a robot can do: one file, one primitive."""
