"""The plant: a MuJoCo arm behind one emulated iSBX board per joint."""
