"""What docs/node.md and the pages beside it print: frames, tables and test vectors of a joint."""
