"""What can be known of a network before anything moves."""
