"""Write a primitive, run it on a simulated robot, and see how a Fail is restored."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from handcart import ActionPrimitive, Base, Discrepancy, RangeSensor, causes
from handcart.evaluation.trials.rig import build_rig


class ApproachWall(ActionPrimitive):
    """Drive straight ahead until the lidar measures a given distance."""

    distance_m: Annotated[float, Field(ge=0.5)]
    """Distance from the lidar to what is ahead."""
    limit_m: float = 3.0
    """Longest way to drive."""
    needs: ClassVar = (Base, RangeSensor)

    def motion(self, robot, model):
        start = robot.pose
        while (ahead := range_ahead(robot)) > self.distance_m:
            if robot.pose.distance(start) > self.limit_m:
                raise Discrepancy(f"no wall within {self.limit_m} m", cause=causes.NOT_SEEN)
            robot.base.drive(min(0.2, ahead - self.distance_m + 0.02), 0.0)
            yield
        self.found(distance_m=round(ahead, 3))


def range_ahead(robot):
    """Return the median range of the beams within 3 degrees of straight ahead, in [m]."""
    scan = robot.range_sensor.scan()
    return float(np.median(scan.ranges[np.abs(scan.angles) < np.radians(3.0)]))


def main() -> None:
    with build_rig(robot="cart", seed=1) as rig:
        start = rig.robot.pose
        print("no wall near:", rig.do(ApproachWall(distance_m=1.0, limit_m=0.5)))
        print(f"back to {1e3 * rig.robot.pose.distance(start):.1f} mm of where it began")
        print("with a wall:", rig.do(ApproachWall(distance_m=1.0, limit_m=10.0)))


if __name__ == "__main__":
    main()
