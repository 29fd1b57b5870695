"""Campaigns: one task many times over, with drawn misalignments, under every law."""
