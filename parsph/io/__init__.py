"""Files: snapshots, gauge tables, the output folder."""
