"""What goes wrong on purpose, and whether outcomes stay true."""
