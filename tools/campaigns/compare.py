"""`handcart campaign compare`: whether a second campaign is better or worse than a first one, and why."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from handcart.files.printable import counted

if TYPE_CHECKING:
    from handcart.evaluation.campaigns.statistics.comparison import Comparison


def compare(
    one: Annotated[Path, typer.Argument(help="a campaign's folder: how it was")],
    other: Annotated[Path, typer.Argument(help="another's: how it is now")],
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
) -> None:
    """Compare two campaigns, paired by seed, and print the differences.

    The exit status is 3 if the success rate of the second campaign is significantly lower: its adjusted
    p-value is at most `SIGNIFICANCE_LEVEL`.
    """
    import orjson

    from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
    from handcart.evaluation.campaigns.statistics.comparison import compare as compared
    from handcart.tools.terminal.skipped_trial import with_note

    found = compared(*(with_note(CampaignFolder.read_runs(item).trials(), item) for item in (one, other)))
    if as_json:
        facts = {**asdict(found), "changes": [{**asdict(e), "proven": e.proven} for e in found.changes]}
        print(orjson.dumps({**facts, "worse": found.worse}, default=list).decode())
    else:
        print("\n".join(_lines(found)))
    sys.exit(3 if found.worse else 0)


def _lines(found: Comparison) -> Iterator[str]:
    left = f"; skipped without a partner: {counted(found.unpaired, 'trial')}" if found.unpaired else ""
    yield f"{counted(found.pairs, 'pair')} of the same seed{left}"
    yield f"A alone succeeded in {found.only_one}, B alone in {found.only_other}"
    verdict = "no difference is proven"
    if found.success.proven:
        verdict = f"B is {'worse' if found.worse else 'better'}: not by chance"
    yield f"success rate, B less A: {100 * found.success.mean:+.2f} %; {verdict}"
    sure = "" if found.sure_at is None else f"; it was sure after {counted(found.sure_at, 'pair')}"
    yield f"e-value {found.e_value:.3g} (20 is sure, whenever it is looked at){sure}"
    least = "none, with so few pairs" if found.smallest is None else f"{100 * found.smallest:.2f} %"
    yield f"smallest difference that would have been seen (power 80 %): {least}"
    yield f"\n{'metric':<24}{'pairs':>8}{'B less A':>14}{'p':>11}{'by Holm':>11}"
    for change in found.changes:
        end = "  proven" if change.proven else ""
        figures = f"{change.mean:>+14.4g}{change.p_value:>11.3g}{change.adjusted:>11.3g}"
        yield f"{change.name:<24}{change.pairs:>8}{figures}{end}"
    if found.partings:
        yield "\nwhere pairs part of which one alone succeeded"
    for kind, parting in found.partings.items():
        yield f"{parting.times:>6} x {kind}; seeds {', '.join(map(str, parting.seeds))}"
        if parting.example is not None:
            yield f"         {parting.example.words('A', 'B')}"
