"""Recorded logs of wheels, inertial units and satellite fixes, from CSV and NMEA."""
