"""Many runs of one task: side by side, each on disk when it has ended."""
