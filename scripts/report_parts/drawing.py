"""numpy and matplotlib, where they are installed."""
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # no linear algebra here, and a pool of threads costs address space
try:
    import numpy as np
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    CAN_DRAW = True
except ImportError:  # numbers are kept; only the pictures are missing
    np = matplotlib = plt = None
    CAN_DRAW = False
