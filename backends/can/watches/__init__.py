"""Watches over a bus."""
