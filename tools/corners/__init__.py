"""Corners drawn at random, planned with a deviation they must keep, and run; and what came out."""
