"""Run a shipped task in simulation, and read what happened."""

import handcart


def main() -> None:
    result = handcart.run("drive_map", robot="cart", seed=3, set={"tour": ["desk", "workshop"]})
    print(result.outcome, "in", result.situation)
    for action in result.actions:
        print(f"  {action.number}. {action.do}: {action.outcome}, {action.end - action.start:.1f} s")
    print(f"driven: {result.metrics['path_length_m']:.1f} m")
    print(f"outcomes that the ground truth contradicts: {len(result.metrics['untrue'])}")


if __name__ == "__main__":
    main()
