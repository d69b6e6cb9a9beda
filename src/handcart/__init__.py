"""Action primitives for mobile manipulators that never stop where they should.

All that scripts, notebooks and authors of primitives and backends need, each imported when it is first
used; see docs/reference/api.md.
"""

import os
from importlib import import_module

TYPE_CHECKING = False  # type checkers take it for true; importing `typing` would cost more than all the rest
if TYPE_CHECKING:
    from handcart.backends.backend import Backend
    from handcart.backends.capabilities.arm import Arm
    from handcart.backends.capabilities.base import Base
    from handcart.backends.capabilities.beacons import Beacons
    from handcart.backends.capabilities.camera import Camera
    from handcart.backends.capabilities.gps import Gps
    from handcart.backends.capabilities.gripper import Gripper
    from handcart.backends.capabilities.imu import Imu
    from handcart.backends.capabilities.positioning import Positioning
    from handcart.backends.capabilities.range_sensor import RangeSensor
    from handcart.networks.past_runs.past_run import read_run as load_run
    from handcart.primitives.contract.action_primitive import ActionPrimitive
    from handcart.primitives.outcomes import causes
    from handcart.primitives.outcomes.cause_kind import CauseKind
    from handcart.primitives.outcomes.discrepancy import Discrepancy, NeedsPerson
    from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
    from handcart.tools.api import Result, campaign, check, conformance, load_task, run

# In a checkout the rooms are at its top, and `handcart/` holds links to them for tools that look for files.
_TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
if os.path.isfile(os.path.join(_TOP, "src", "handcart", "__init__.py")):
    __path__.insert(0, _TOP)  # first: tracebacks and breakpoints then have the rooms' own paths

_FROM = {
    "ActionPrimitive": "primitives.contract.action_primitive:ActionPrimitive",
    "Arm": "backends.capabilities.arm:Arm",
    "Backend": "backends.backend:Backend",
    "Base": "backends.capabilities.base:Base",
    "Beacons": "backends.capabilities.beacons:Beacons",
    "Camera": "backends.capabilities.camera:Camera",
    "CauseKind": "primitives.outcomes.cause_kind:CauseKind",
    "Discrepancy": "primitives.outcomes.discrepancy:Discrepancy",
    "Fail": "primitives.outcomes.outcome:Fail",
    "GiveUp": "primitives.outcomes.outcome:GiveUp",
    "Gps": "backends.capabilities.gps:Gps",
    "Gripper": "backends.capabilities.gripper:Gripper",
    "Imu": "backends.capabilities.imu:Imu",
    "NeedsPerson": "primitives.outcomes.discrepancy:NeedsPerson",
    "Positioning": "backends.capabilities.positioning:Positioning",
    "RangeSensor": "backends.capabilities.range_sensor:RangeSensor",
    "Result": "tools.api:Result",
    "Success": "primitives.outcomes.outcome:Success",
    "campaign": "tools.api:campaign",
    "causes": "primitives.outcomes:causes",
    "check": "tools.api:check",
    "conformance": "tools.api:conformance",
    "load_run": "networks.past_runs.past_run:read_run",
    "load_task": "tools.api:load_task",
    "run": "tools.api:run",
}
__all__ = [
    "ActionPrimitive",
    "Arm",
    "Backend",
    "Base",
    "Beacons",
    "Camera",
    "CauseKind",
    "Discrepancy",
    "Fail",
    "GiveUp",
    "Gps",
    "Gripper",
    "Imu",
    "NeedsPerson",
    "Positioning",
    "RangeSensor",
    "Result",
    "Success",
    "campaign",
    "causes",
    "check",
    "conformance",
    "load_run",
    "load_task",
    "run",
]

if not TYPE_CHECKING:  # else type checkers would take every name

    def __getattr__(name):
        if name not in _FROM:
            raise AttributeError(f"module 'handcart' has no attribute {name!r}")
        module, _, attribute = _FROM[name].partition(":")
        found = globals()[name] = getattr(import_module(f"handcart.{module}"), attribute)
        return found

    def __dir__():
        return sorted({*globals(), *__all__})
