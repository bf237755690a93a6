"""Analyses that belong to the quadrotor alone: pure functions on arrays."""
