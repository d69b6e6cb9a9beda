"""CANopen frames and objects over one bus."""
