"""Where a backend is tried."""
