"""Reports of `handcart check` and `--dry-run`."""
