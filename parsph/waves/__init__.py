from .basins import *
from .linear import *
from .paddles import *
from .shallow import *
from .solitary import *
from .spectra import *
try:
    from .regular import *
except ImportError:
    pass
from .basins import Seiche
from .shallow import DamBreak, layer_reflection, pulse
from .solitary import SOLITARY_THEORIES, Solitary
from .spectra import SPECTRA, components, focused
REGULAR_THEORIES = {"airy": 1, "stokes": 1, "fenton": 1}
from .limits import *
from .limits import HIGHEST_SOLITARY, breaking_height, miche
