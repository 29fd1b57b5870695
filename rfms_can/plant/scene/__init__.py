"""Scenes: what the arm holds and meets."""

from rfms_can.plant.scene.shape import FREE, ROUNDING, STEEL, Contact, Kind, Scene, Shape, Tool

__all__ = ["FREE", "ROUNDING", "STEEL", "Contact", "Kind", "Scene", "Shape", "Tool"]
