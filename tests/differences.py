"""Where ours answers otherwise than a real ArduPlane, and means to.

By the sentence of docs/mavlink.md, "Differences from ArduPlane", that says so: the scenes, and the patterns of their steps.
"""

KNOWN = {}
