"""Run the diagnosis and its rivals on the same sets and print how they score: ``python -m benchmarks.diagnosis --repetitions 1``."""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "workflow")]

from study.blind_trials.cases import Set, load_study  # noqa: E402
from study.blind_trials.run import MatchedControl, injected_config, make_control  # noqa: E402
from study.blind_trials.score import outcome, same  # noqa: E402
from study.common.in_memory import dataset_in_memory  # noqa: E402

from benchmarks.diagnosis.rivals import lasso, stepwise  # noqa: E402
from scalar.diagnosis.diagnose import diagnose  # noqa: E402
from scalar.simulation.scene import simulate  # noqa: E402

DIAGNOSIS = "diagnosis"
CONTESTANTS = (DIAGNOSIS, "stepwise", "lasso")


def answers(
    wanted: Set, control: MatchedControl
) -> tuple[list[dict], dict[str, tuple[list[dict], list[dict]]]]:
    """Return what was injected, and of each contestant what it found and what it calls unobservable."""
    simulated = simulate(injected_config(wanted, control), base_dir=control.base_dir, plan=control.plan)
    injected = [{key: e.get(key) for key in ("name", "target", "size")} for e in simulated.truth["effects"]]
    diagnosis = diagnose(dataset_in_memory(simulated))
    said = json.loads(json.dumps(diagnosis.to_mapping()))
    rivals = {"stepwise": stepwise(diagnosis.before), "lasso": lasso(diagnosis.before)}
    return injected, {DIAGNOSIS: (said["effects"], said["unobservable"])} | {
        name: (json.loads(json.dumps(found)), []) for name, found in rivals.items()
    }


def main() -> None:
    """Print a line for each set, then the counts of outcomes of each contestant and how many further names each gave."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", default=str(ROOT / "configs/blind_trials.yaml"))
    parser.add_argument("--repetitions", type=int, default=1, help="scenes of each workcell")
    parser.add_argument("--size", type=float, default=1.0, help="of the effects, times the natural size")
    parser.add_argument("--workcell", action="append", help="only these")
    options = parser.parse_args()
    study = load_study(options.config)
    names = [case.name for case in study.cases.values() if case.kind == "single"]
    outcomes = {name: Counter() for name in CONTESTANTS}
    more = Counter()
    for workcell in options.workcell or study.workcells:
        controls: dict[int, MatchedControl] = {}
        for case in names:
            if workcell not in study.cases[case].choices[0].workcells:
                continue
            for wanted in study.sets(case, workcell, f"001-{options.repetitions:03d}"):
                if wanted.size != options.size:
                    continue
                if wanted.seed not in controls:
                    controls[wanted.seed] = make_control(study, workcell, wanted.seed, ROOT)
                injected, said = answers(wanted, controls[wanted.seed])
                ends = {name: outcome(injected[0], *answer) for name, answer in said.items()}
                for name, (found, _) in said.items():
                    outcomes[name][ends[name]] += 1
                    more[name] += sum(not same(entry, injected[0]) for entry in found)
                print(f"{case} {workcell} seed {wanted.seed}: {ends}", flush=True)
    for name in CONTESTANTS:
        print(f"{name}: {dict(outcomes[name])}, names of what was not injected: {more[name]}")


if __name__ == "__main__":
    main()
