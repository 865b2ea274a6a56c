"""Writes small images with nothing but Python's standard library."""
import gzip
import struct


def ball(size, radius, label=1):
    """Voxels of a ball in the middle of a cube, i fastest."""
    middle = (size - 1) / 2
    return [label if (i - middle) ** 2 + (j - middle) ** 2 + (k - middle) ** 2 <= radius ** 2 else 0
            for k in range(size) for j in range(size) for i in range(size)]


def write(path, sizes, voxels, spacing=None, kind="uint8", encoding="raw", header=None):
    """A NRRD file. `header` replaces lines of the usual header: {"sizes": "1 2 3"}; None as a value leaves one out."""
    dimension = len(sizes)
    spacing = spacing or [1.0] * dimension
    lines = {
        "type": kind,
        "dimension": str(dimension),
        "space": "left-posterior-superior" if dimension == 3 else None,
        "sizes": " ".join(map(str, sizes)),
        "space directions": " ".join("(" + ",".join(str(spacing[a] if a == b else 0) for b in range(3)) + ")"
                                     for a in range(3)) if dimension == 3 else None,
        "endian": "little",
        "encoding": encoding,
        "space origin": "(0,0,0)" if dimension == 3 else None,
    }
    lines.update(header or {})
    code = {"uint8": "B", "int16": "h", "float": "f", "double": "d"}[kind]
    data = struct.pack(f"<{len(voxels)}{code}", *voxels)
    if encoding == "gzip":
        data = gzip.compress(data)
    text = "NRRD0004\n" + "".join(f"{key}: {value}\n" for key, value in lines.items() if value is not None)
    path.write_bytes(text.encode() + b"\n" + data)
    return path
