"""A robot whose wheels are CANopen drives."""

import logging

# What they say of the bus is told in words by the backend's own errors; who wants it adds a handler.
for _library in ("can", "canopen"):
    logging.getLogger(_library).addHandler(logging.NullHandler())
