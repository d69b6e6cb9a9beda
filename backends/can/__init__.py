"""A robot whose wheels are CANopen drives."""

import logging

# The backend's own errors report bus faults; add a handler to get the libraries' log lines as well.
for _library in ("can", "canopen"):
    logging.getLogger(_library).addHandler(logging.NullHandler())
