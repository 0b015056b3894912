"""Simulated people. Results made with them are always marked as simulated."""
