"""The coordinator: plan, act, supervise, plan again."""
