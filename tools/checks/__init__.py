"""What `handcart check` and `--dry-run` tell."""
