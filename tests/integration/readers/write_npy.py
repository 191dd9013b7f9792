"""write_npy.py FILE.npy TYPE ORDER: writes a[x, y, z] = x + 10 y + 100 z of shape (4, 3, 2) and prints true."""
import sys

import numpy

x, y, z = numpy.indices((4, 3, 2))
numpy.save(sys.argv[1], (x + 10 * y + 100 * z).astype(sys.argv[2]).copy(order=sys.argv[3]))
print("true")
