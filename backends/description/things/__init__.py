"""What stands in a world, as files of several kinds describe it: doors, tags and calibration boards."""
