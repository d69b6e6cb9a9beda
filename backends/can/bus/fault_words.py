"""Error codes of drives in words."""

from __future__ import annotations

from canopen.emcy import EmcyError

# CiA 402-2, table of error codes; those that wheels meet.
_WORDS = {
    0x2310: "continuous over-current",
    0x2320: "short circuit",
    0x3110: "mains over-voltage",
    0x3120: "mains under-voltage",
    0x3210: "DC link over-voltage",
    0x3220: "DC link under-voltage",
    0x4210: "excess temperature of the device",
    0x4310: "excess temperature of the drive",
    0x5441: "contact fault of an input",
    0x7121: "motor blocked",
    0x7305: "incremental encoder 1",
    0x7306: "incremental encoder 2",
    0x8110: "CAN overrun: frames lost",
    0x8120: "CAN error passive",
    0x8130: "heartbeat missing",
    0x8140: "recovered from bus off",
    0x8210: "a PDO of a wrong length",
    0x8400: "velocity controller",
    0x8611: "following error",
}


def fault_words(code: int) -> str:
    """Return an error code (603Fh, or of an EMCY) in words, such as "error 8611h, following error".

    "" for the code 0, which means no error.
    """
    if code == 0:
        return ""
    # The library knows the groups of codes (CiA 301).
    words = _WORDS.get(code) or EmcyError(code, 0, b"", 0.0).get_desc().lower()
    return f"error {code:04X}h" + (f", {words}" if words else "")
