"""The handbook's formulas once more, plain and slow, as docs/node.md and its pages print them.

Written after the pages, line for line, not after the code: where the two disagree, a page is wrong.
"""
