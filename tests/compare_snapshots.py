"""Compare two runs to the bit: python tests/compare_snapshots.py RUN_A RUN_B"""

import sys

from parsph.io.comparison import differences

if __name__ == "__main__":
    found = differences(*sys.argv[1:3])
    print("\n".join(found) or f"equal to the bit: {sys.argv[1]} and {sys.argv[2]}")
    sys.exit(bool(found))
