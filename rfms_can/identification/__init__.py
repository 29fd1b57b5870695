"""Parameter identification over the bus: experiments, the fit, and its validation."""
