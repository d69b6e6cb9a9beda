"""Motions of arm and hand that any primitive may use."""
