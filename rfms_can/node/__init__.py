"""What a node is: the protocol a bus drives it by, and what all of ours are built on."""
