"""Scenes: what the arm holds and meets."""

from rfms_can.plant.scene.shape import FREE, STEEL, Contact, Kind, Scene, Shape, Tool

__all__ = ["FREE", "STEEL", "Contact", "Kind", "Scene", "Shape", "Tool"]
