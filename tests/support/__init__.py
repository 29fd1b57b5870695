"""What the tests share: benches, rigs, programs, golden data."""
