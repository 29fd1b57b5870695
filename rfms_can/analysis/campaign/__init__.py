"""Campaigns: one task repeated with random misalignments under every control law."""
