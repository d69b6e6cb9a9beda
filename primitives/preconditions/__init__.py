"""What must hold before a primitive starts, stated by its class and checked before anything moves."""
