"""read_labels.py FILE.tif: prints its numbers row by row, as tifffile reads them, which Cellpose and StarDist use, as JSON."""
import json
import sys

import tifffile

print(json.dumps(tifffile.imread(sys.argv[1]).ravel().tolist()))
