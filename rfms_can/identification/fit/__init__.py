"""From the data of experiments to the constants of the arm."""
