"""Scenes: schema, loading and checks, and what they are built into."""
