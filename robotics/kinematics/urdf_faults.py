"""Faults of a URDF, found before a kinematics library reads it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches

from handcart.robotics.kinematics.urdf_doubts import joint_doubts
from handcart.robotics.kinematics.urdf_pruning import prune
from handcart.robotics.kinematics.urdf_reading import UrdfElement, UrdfFault, read_urdf

JOINT_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_BOUNDED = ("revolute", "prismatic")
_UNDRIVEN = ("floating", "planar")
_TURNED = (*_BOUNDED, "continuous", "planar")  # they have an axis
_SOLIDS: dict[str, tuple[str, ...]] = {
    "box": (),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "mesh": (),
}
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_LARGEST = 1e6  # of any number: [m], [rad], [kg], [N]; makers write 1e5 for "as strong as you like"
_NO_LIMIT = 1e18  # makers write 1e16 for it
_NO_AXIS = 1e-6
_SHOWN = 6


def urdf_faults(text: str, without: Sequence[str] = ()) -> list[UrdfFault]:
    """Return all faults of a URDF, in the order of its lines; empty if it has none.

    Only what kinematics needs is checked: names, references, joint kinds, limits, numbers, the tree and
    collision bodies, but not whether mesh files exist.

    Args:
        text: the URDF.
        without: joints that are ignored, with everything that they carry.

    Raises:
        UnknownJoint: the URDF has no such joint.
    """
    try:
        robot = read_urdf(text)
    except ValueError as error:
        return list(getattr(error, "faults", ()))
    prune(robot, without)
    if expression := _expression(robot):
        return [expression]
    links, joints = _children(robot, "link"), _children(robot, "joint")
    found = [*_names(links, "link"), *_names(joints, "joint")]
    if not links:
        found.append(robot.fault("the URDF has no link; allowed: at least one"))
    known = {item.get("name", ""): item for item in links}
    for link in links:
        found += _link_faults(link)
    by_name = {item.get("name", ""): item for item in joints}
    for joint in joints:
        found += _joint_faults(joint, known, by_name)
    # A tree of links is asked for only where all references lead somewhere.
    grave = any(not item.mild for item in found)
    return sorted(found if grave else [*found, *_tree_faults(robot, joints, known), *joint_doubts(by_name)])


def _expression(robot: UrdfElement) -> UrdfFault | None:
    """Return a fault if the file is a xacro file, or holds unexpanded xacro expressions."""
    how = "allowed: what `xacro FILE > robot.urdf` makes of it"
    for element in _elements(robot):
        if "xacro" in str(element.tag):
            name = str(element.tag).rpartition("}")[2].removeprefix("xacro:")
            return element.fault(f"<xacro:{name}> is xacro, not yet URDF; {how}")
        for key, value in element.attrib.items():
            if "$(" in value or "${" in value:
                words = f"{element.tag} {key} is {value[:60]!r}, an expression of xacro"
                return element.fault(f"{_within(robot, element)}{words}; {how}")
    return None


def _within(robot: UrdfElement, element: UrdfElement) -> str:
    """Return the link or joint that holds an element, as the head of a message."""
    for kind in ("link", "joint"):
        for child in _children(robot, kind):
            if any(element is part for part in child.iter()):
                return f"{_title(child)}: "
    return ""


def _names(elements: Sequence[UrdfElement], kind: str) -> Iterator[UrdfFault]:
    seen: dict[str, int] = {}
    for element in elements:
        name = element.get("name", "")
        if not name.strip():
            yield element.fault(f"a {kind} has no name; allowed: one of its own")
        elif name in seen:
            yield element.fault(
                f"{kind} {name!r}: line {seen[name]} has one of that name; allowed: another name"
            )
        seen.setdefault(name, element.line)


def _link_faults(link: UrdfElement) -> Iterator[UrdfFault]:
    title = _title(link)
    for inertial in _children(link, "inertial"):
        yield from _inertial_faults(title, inertial)
    for collision in _children(link, "collision"):
        yield from _origin_faults(title, collision)
        yield from _geometry_faults(title, collision)
    for visual in _children(link, "visual"):
        yield from _origin_faults(title, visual)
        for colour in visual.iter("color"):
            assert isinstance(colour, UrdfElement)
            yield from _colour_fault(title, colour)
        for mesh in visual.iter("mesh"):
            if not mesh.get("filename", "").strip():
                yield UrdfFault(*_place(mesh), f"{title}: a mesh names no file; allowed: filename=...")


def _inertial_faults(title: str, inertial: UrdfElement) -> Iterator[UrdfFault]:
    yield from _origin_faults(title, inertial)
    for tag, keys in (("mass", ("value",)), ("inertia", _MOMENTS)):
        each = _child(inertial, tag)
        if each is None:
            yield inertial.fault(f"{title}: its inertial has no <{tag}>; allowed: one, or no inertial")
            continue
        for key in keys:
            yield from _number_fault(title, each, key, needed=True)


def _geometry_faults(title: str, collision: UrdfElement) -> Iterator[UrdfFault]:
    geometry = _child(collision, "geometry")
    solids = [] if geometry is None else [item for item in geometry if isinstance(item, UrdfElement)]
    if not solids:
        yield collision.fault(f"{title}: a collision body has no geometry; allowed: {_listed(_SOLIDS)}")
        return
    solid = solids[0]
    if solid.tag not in _SOLIDS:
        yield solid.fault(f"{title}: unknown geometry <{solid.tag}>{_suggested(str(solid.tag), _SOLIDS)}")
        return
    for key in _SOLIDS[solid.tag]:
        yield from _number_fault(title, solid, key, needed=True, positive=True)
    if solid.tag == "box":
        yield from _triple_fault(title, solid, "size", needed=True, positive=True)
    if solid.tag == "mesh":
        if not solid.get("filename", "").strip():
            yield solid.fault(f"{title}: a mesh names no file; allowed: filename=...")
        yield from _triple_fault(title, solid, "scale", nonzero=True)


def _joint_faults(
    joint: UrdfElement, links: Mapping[str, UrdfElement], joints: Mapping[str, UrdfElement]
) -> Iterator[UrdfFault]:
    title, kind = _title(joint), joint.get("type", "")
    if kind not in JOINT_KINDS:
        yield joint.fault(f"{title}: unknown type {kind[:40]!r}{_suggested(kind, JOINT_KINDS)}")
    for tag in ("parent", "child"):
        yield from _end_faults(title, joint, tag, links)
    yield from _origin_faults(title, joint)
    for dynamics in _children(joint, "dynamics"):
        for key in ("damping", "friction"):
            yield from _number_fault(title, dynamics, key, largest=_NO_LIMIT)
    if kind in _UNDRIVEN:
        words = f"{title}: a {kind} joint is not driven: what it carries is taken as fixed; allowed: "
        yield joint.fault(f"{words}{', '.join((*_BOUNDED, 'continuous', 'fixed'))}")._replace(mild=True)
    axis = _child(joint, "axis")
    if axis is not None and kind in _TURNED:
        yield from _axis_faults(title, axis)
    limit = _child(joint, "limit")
    if limit is None and kind in _BOUNDED:
        yield joint.fault(
            f"{title}: a {kind} joint without limits; needed: <limit> with lower, upper, effort, velocity"
        )
    elif limit is not None:
        yield from _limit_faults(title, limit, kind)
    mimic = _child(joint, "mimic")
    if mimic is not None:
        yield from _mimic_faults(title, joint, mimic, joints)


def _end_faults(
    title: str, joint: UrdfElement, tag: str, links: Mapping[str, UrdfElement]
) -> Iterator[UrdfFault]:
    end = _child(joint, tag)
    name = "" if end is None else end.get("link", "")
    if end is None or not name:
        yield (joint if end is None else end).fault(
            f"{title}: it has no {tag} link; needed: <{tag} link=...>"
        )
    elif name not in links:
        yield end.fault(f"{title}: its {tag} {name!r} is not a link{_suggested(name, links)}")


def _axis_faults(title: str, axis: UrdfElement) -> Iterator[UrdfFault]:
    faults = list(_triple_fault(title, axis, "xyz"))
    yield from faults
    if not faults and max(map(abs, _triple(axis, "xyz", (1.0, 0.0, 0.0)))) < _NO_AXIS:
        yield axis.fault(f"{title}: its axis has no direction; allowed: three numbers, not all 0")


def _limit_faults(title: str, limit: UrdfElement, kind: str) -> Iterator[UrdfFault]:
    needed = ("effort", "velocity") if kind in _BOUNDED else ()
    faults = [
        fault
        for key in ("lower", "upper", "effort", "velocity")
        for fault in _number_fault(title, limit, key, needed=key in needed, largest=_NO_LIMIT)
    ]
    yield from faults
    if faults:
        return
    for key in ("effort", "velocity"):
        if _number(limit, key) < 0.0:
            words = f"{title}: its {key} limit is {_number(limit, key):g} and counts as none"
            yield limit.fault(f"{words}; allowed: 0 or more")._replace(mild=True)
    if kind not in _BOUNDED:
        return
    lower, upper = (_number(limit, key) for key in ("lower", "upper"))
    if lower > upper:
        yield limit.fault(f"{title}: its lower limit {lower:g} is above its upper, {upper:g}; allowed: below")


def _mimic_faults(
    title: str, joint: UrdfElement, mimic: UrdfElement, joints: Mapping[str, UrdfElement]
) -> Iterator[UrdfFault]:
    for key in ("multiplier", "offset"):
        yield from _number_fault(title, mimic, key)
    led = mimic.get("joint", "")
    if led not in joints:
        words = f"{title}: it mimics {led!r}, which is no joint, and counts as free{_suggested(led, joints)}"
        yield mimic.fault(words)._replace(mild=True)
        return
    seen = {joint.get("name", "")}
    while led and led in joints:
        if led in seen:
            yield mimic.fault(
                f"{title}: it mimics itself, by way of {led!r}; allowed: a joint that moves freely"
            )
            return
        seen.add(led)
        other = _child(joints[led], "mimic")
        led = "" if other is None else other.get("joint", "")
    if joints[mimic.get("joint", "")].get("type") in ("fixed", "floating", "planar"):
        yield mimic.fault(
            f"{title}: it mimics {mimic.get('joint')!r}, which doesn't turn or slide; allowed: one that does"
        )


def _tree_faults(
    robot: UrdfElement, joints: Sequence[UrdfElement], links: Mapping[str, UrdfElement]
) -> Iterator[UrdfFault]:
    """Yield a fault for each link that two joints move, for several root links, and for each cycle."""
    parent: dict[str, str] = {}
    moved: dict[str, UrdfElement] = {}
    for joint in joints:
        above, child = (_child(joint, tag) for tag in ("parent", "child"))
        assert above is not None
        assert child is not None
        name = child.get("link", "")
        if name in moved:
            other = moved[name].get("name")
            yield joint.fault(
                f"{_title(joint)}: joint {other!r} moves the link {name!r} too; allowed: one joint"
            )
        moved.setdefault(name, joint)
        parent.setdefault(name, above.get("link", ""))
    roots = [name for name in links if name not in parent]
    if len(roots) > 1:
        element = links[roots[1]]
        words = (
            f"it hangs on no joint, and neither does {_listed(root for root in roots if root != roots[1])}"
        )
        yield element.fault(f"{_title(element)}: {words}; allowed: one root link")
    yield from _rings(parent, moved)


def _rings(parent: Mapping[str, str], moved: Mapping[str, UrdfElement]) -> Iterator[UrdfFault]:
    sound: set[str] = set()
    for start in parent:
        way, name = [start], start
        while name in parent and name not in sound:
            name = parent[name]
            if name in way:
                joint = moved[name]
                yield joint.fault(
                    f"{_title(joint)}: the link {name!r} hangs on itself; allowed: a tree of links"
                )
                sound.update(way)
                break
            way.append(name)
        sound.update(way)


def _origin_faults(title: str, element: UrdfElement) -> Iterator[UrdfFault]:
    origin = _child(element, "origin")
    if origin is not None:
        for key in ("xyz", "rpy"):
            yield from _triple_fault(title, origin, key)


def _number_fault(
    title: str,
    element: UrdfElement,
    key: str,
    needed: bool = False,
    positive: bool = False,
    largest: float = _LARGEST,
) -> Iterator[UrdfFault]:
    text = element.get(key)
    if text is None:
        if needed:
            yield element.fault(f"{title}: <{element.tag}> has no {key}; needed: {key}=NUMBER")
        return
    value = _float(text)
    if value is None or abs(value) > largest or (positive and value <= 0.0):
        allowed = "a number above 0" if positive else "a finite number"
        most = f" up to {largest:g}" if value is not None and abs(value) > largest else ""
        yield element.fault(f"{title}: {element.tag} {key} is {text[:60]!r}; allowed: {allowed}{most}")


def _triple_fault(
    title: str,
    element: UrdfElement,
    key: str,
    needed: bool = False,
    positive: bool = False,
    nonzero: bool = False,
) -> Iterator[UrdfFault]:
    text = element.get(key)
    if text is None:
        if needed:
            yield element.fault(f"{title}: <{element.tag}> has no {key}; needed: {key}='X Y Z'")
        return
    values = [_float(word) for word in text.split()]
    numbers = [value for value in values if value is not None and abs(value) <= _LARGEST]
    bad = len(values) != 3 or len(numbers) != 3
    bad = bad or (positive and min(numbers) <= 0.0) or (nonzero and 0.0 in numbers)
    if bad:
        kind = " above 0" if positive else ", none of them 0" if nonzero else ""
        large = len(values) == 3 and None not in values and len(numbers) != 3
        allowed = f"3 finite numbers{kind}{f', up to {_LARGEST:g}' if large else ''}"
        yield element.fault(f"{title}: {element.tag} {key} is {text[:60]!r}; allowed: {allowed}")


def _colour_fault(title: str, colour: UrdfElement) -> Iterator[UrdfFault]:
    words = colour.get("rgba", "0 0 0 1").split()
    if len(words) != 4 or any(_float(word) is None for word in words):
        wrong = f"{title}: color rgba is {colour.get('rgba', '')[:60]!r}"
        yield colour.fault(f"{wrong}; allowed: 4 finite numbers")


def _float(text: str) -> float | None:
    """Return a finite number as C's `strtod` reads it; None if it is not one."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text and text.isascii() else None


def _number(element: UrdfElement, key: str) -> float:
    return _float(element.get(key, "0")) or 0.0


def _triple(element: UrdfElement, key: str, default: tuple[float, float, float]) -> Sequence[float]:
    text = element.get(key)
    return default if text is None else [float(word) for word in text.split()]


def _title(element: UrdfElement) -> str:
    return f"{element.tag} {element.get('name', '')!r}"


def _place(element: object) -> tuple[int, int]:
    assert isinstance(element, UrdfElement)
    return element.line, element.column


def _child(element: UrdfElement, tag: str) -> UrdfElement | None:
    found = element.find(tag)
    return found if isinstance(found, UrdfElement) else None


def _children(element: UrdfElement, tag: str) -> list[UrdfElement]:
    return [match for match in element.findall(tag) if isinstance(match, UrdfElement)]


def _elements(element: UrdfElement) -> Iterator[UrdfElement]:
    return (item for item in element.iter() if isinstance(item, UrdfElement))


def _suggested(name: str, allowed: Iterable[str]) -> str:
    """Return the second half of a message about an unknown name, with the nearest of those that are known."""
    names = list(allowed)
    near = get_close_matches(name[:100], names, n=1, cutoff=0.6)
    question = f"did you mean {near[0]!r}? " if near else ""
    return f"; {question}allowed: {_listed(names)}"


def _listed(names: Iterable[str]) -> str:
    every = list(names)
    more = f" and {len(every) - _SHOWN} more" if len(every) > _SHOWN else ""
    return (", ".join(every[:_SHOWN]) or "none") + more
