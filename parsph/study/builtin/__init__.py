"""Built-in studies: one module each, with ``study(quick)`` and, where it has its own, a report."""
