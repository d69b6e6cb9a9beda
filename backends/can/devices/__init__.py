"""What makers say of their drives, and what drives lack."""
