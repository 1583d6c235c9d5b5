"""Studies: a matrix of scenes, each run in its own folder, their metrics in one table, figures and a report."""
