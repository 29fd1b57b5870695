"""Force control: compliance, bias force, and guarded moves (Ch. V)."""
