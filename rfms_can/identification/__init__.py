"""The arm as it is, measured over the bus: experiments, the fit, and what it is good for."""
