"""EDS files of CANopen devices, and objects that a device may lack."""
