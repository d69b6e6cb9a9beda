"""Units in the keys of files: `width_mm` is in millimetres."""

# Longer suffixes first: `speed_m_s` is in m/s, not in s.
_UNITS = {
    "_deg_s_rt_s": "deg/s/√s",
    "_deg_rt_s": "deg/√s",
    "_m_rt_s": "m/√s",
    "_deg_s2": "deg/s²",
    "_rad_s2": "rad/s²",
    "_m_s2": "m/s²",
    "_mm_s": "mm/s",
    "_m_s": "m/s",
    "_deg_s": "deg/s",
    "_rad_s": "rad/s",
    "_percent": "%",
    "_deg": "deg",
    "_rad": "rad",
    "_mm": "mm",
    "_cm": "cm",
    "_km": "km",
    "_ms": "ms",
    "_us": "µs",
    "_hz": "Hz",
    "_kg": "kg",
    "_nm": "N m",
    "_px": "px",
    "_min": "min",
    "_m": "m",
    "_s": "s",
    "_g": "g",
    "_n": "N",
    "_v": "V",
    "_a": "A",
}


def unit_of(key: str) -> str:
    """Return the unit that a key's ending names, such as "mm" for `width_mm`; "" if it names none."""
    for suffix, unit in _UNITS.items():
        if key.endswith(suffix):
            return unit
    return ""
