"""The wire contract: frames, the compiled DBC, typed records, end-to-end protection."""
