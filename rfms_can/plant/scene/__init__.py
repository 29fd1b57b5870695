"""Scenes: the tool in the hand and the fixtures around the arm."""

from rfms_can.plant.scene.shape import EDGE_RADIUS, FREE, STEEL, Contact, Kind, Scene, Shape, Tool

__all__ = ["EDGE_RADIUS", "FREE", "STEEL", "Contact", "Kind", "Scene", "Shape", "Tool"]
