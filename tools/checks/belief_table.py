"""What the beliefs of a task say before its first action, as a line of `handcart check`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from handcart.networks.graph.network import ActionNetwork


def belief_facts(network: ActionNetwork) -> tuple[dict[str, Any], list[str]]:
    """Return how probably a task's policy is better than the rule, as fields and as lines of text.

    The rule is the policy that always starts the first action of the cheapest plan to the goal. The
    probability is that at the task's start, by the task's beliefs about the probabilities of outcomes. Fields
    and lines are empty for a task without beliefs, and for a task that starts at its goal.
    """
    from handcart.networks.deciding.planners import planner_of

    if network.belief is None:
        return {}, []
    judged = planner_of(network).plan(network.start).judged
    if judged is None:  # it starts at its goal
        return {}, []
    fields = {"attempts": network.belief.attempts, **judged.fields()}
    found = f"better in {judged.better:.1%} of draws, by {judged.saved_s:.1f} s in the mean"
    counts = f"p counts for {network.belief.attempts:g} attempts"
    line = f"beliefs ({counts}): at the start {network.policy} is {found}, needed 95 %; the run begins by"
    return {"belief": fields}, [f"{line} {judged.follows}"]
