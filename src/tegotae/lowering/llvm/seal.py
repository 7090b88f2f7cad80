"""Machine code with a checksum, so that what was truncated or altered is never run."""

from __future__ import annotations

import hashlib
import json

from tegotae._support.errors import TegotaeError
from tegotae.lowering.layout import MemoryLayout

_BYTES = hashlib.sha256().digest_size


def sealed(code: bytes, *layouts: MemoryLayout) -> bytes:
    """Code and, after it, a checksum over it and the layouts of its memory.

    Args:
        code: an object file, which stays one.
        layouts: of the memory that it reads and writes, in its order.

    Example:
        >>> unsealed(sealed(b"code"))
        b'code'
    """
    return code + _checksum(code, layouts)


def unsealed(kept: bytes, *layouts: MemoryLayout) -> bytes:
    """The code that was sealed with these layouts.

    Args:
        kept: what `sealed` gave.
        layouts: the same as then.

    Raises:
        TegotaeError: where a byte differs, is missing or was added, or a layout differs.
    """
    code, checksum = kept[:-_BYTES], kept[-_BYTES:]
    if checksum != _checksum(code, layouts):
        raise TegotaeError(
            "the machine code is truncated or altered, or of another layout of its memory; "
            "compile it again"
        )
    return code


def _checksum(code: bytes, layouts: tuple[MemoryLayout, ...]) -> bytes:
    described = json.dumps([layout.document() for layout in layouts])
    return hashlib.sha256(described.encode() + code).digest()
