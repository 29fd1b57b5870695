"""From power-up to a referenced arm: who is on the bus, and what each of them holds."""
