"""Analysis of runs and models: tables, plots, comparisons."""
