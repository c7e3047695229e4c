"""What `snakemake everything` leaves as it is committed is what the paper says that it leaves."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[3]
STAYS = {
    "stratified": "the sealed exams of scanners",
    "real_arm_trials": "of effects of real arms",
    "tracked_trials": "and of trackers and probes",
    "measured_rivals": "the errors of measured halves",
    "measured_published": "those on the splits of their authors",
    "benchmark": "the comparison with rivals",
}
"""``{part of the numbers: the words of the paper}``."""


def test_the_paper_names_every_part_that_stays_as_committed():
    """Of the parts of the table of versions, those without a fresh summary are in the sentence of what stays, and no others are."""
    text = (ROOT / "paper/sections/reproducing.typ").read_text(encoding="utf-8")
    rule = (ROOT / "workflow/rules/everything.smk").read_text(encoding="utf-8")
    fresh = rule[rule.index("FRESH_SUMMARIES") : rule.index("FRESH_FIGURES")]
    committed = {key.split(".")[0] for key in re.findall(r'"(\w+\.(?:code\.commit|commits\.1))"\),', text)}
    assert len(committed) >= 12
    assert committed - set(re.findall(r'^ +"(\w+)":', fresh, re.MULTILINE)) == set(STAYS)
    sentence = text[text.index("stay as they are committed:") : text.index("Of these it runs")]
    for words in STAYS.values():
        assert words in sentence
