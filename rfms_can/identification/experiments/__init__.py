"""Experiments on the bus, before a servo may close and after, and the data they leave."""
