"""Chapter IV as a procedure: torque laws, gravity, inertia from the data of experiments."""
