"""What is made from runs and models: tables, plots, comparisons."""
