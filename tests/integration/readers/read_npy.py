"""read_npy.py FILE.npy: prints shape, type and values, with the first index fastest, as JSON."""
import json
import sys

import numpy

a = numpy.load(sys.argv[1])
print(json.dumps({"shape": a.shape, "type": str(a.dtype), "values": a.ravel(order="F").tolist()}))
