"""Bringing a real robot up, rung by rung."""
