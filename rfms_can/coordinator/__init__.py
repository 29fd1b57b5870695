"""The user's program API: transforms, position equations, modes, moves."""
