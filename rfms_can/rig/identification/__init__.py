"""Excitation programs, and the data they bring: what an identification is made from."""
