"""A robot whose wheels are CANopen drives."""
