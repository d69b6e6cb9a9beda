"""What to do next: task file, network, planning, coordinator, journal."""
