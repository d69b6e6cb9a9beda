"""Run a task with several seeds, and see the success rate and the spread of a metric."""

import handcart


def main() -> None:
    report = handcart.campaign("drive_map", robot="cart", set={"tour": ["desk"]}, trials=3, jobs=1)
    low, high = report.wilson
    print(f"{report.successes} of {len(report.trials)}; 95 % interval {low:.2f} to {high:.2f}")
    spread = report.spreads()["localisation_mm_max"]
    print(
        f"largest error of the estimated position: median {spread.median:.0f} mm, most {spread.most:.0f} mm"
    )


if __name__ == "__main__":  # with more jobs each process imports this file
    main()
