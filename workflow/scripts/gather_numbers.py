"""Gather the numbers that the paper quotes."""

from job import logged

with logged(snakemake.log):
    import json
    from pathlib import Path

    from scalar.data.io.atomic import write_json
    from study.common.tables import read_table
    from study.paper import committed
    from study.paper.measured_published import beside
    from study.paper.measured_rivals import counts
    from study.paper.numbers import gather
    from study.paper.parts import compared, conventions, measured_later, settings, setup, stated
    from study.paper.trials import reported_stratified, reported_trials, with_ratios

    WORST = "worst_after_over_before"
    given = snakemake.input
    parts = {
        name: json.loads(Path(place).read_text(encoding="utf-8"))
        for name, place in snakemake.params.parts.items()
    }
    parts["setup"] = setup(Path(given.scene), Path(given.tilted), snakemake.params.seeds)
    parts["settings"] = settings()
    parts["conventions"] = conventions()
    parts["published"] = stated(
        *map(read_table, (given.headline, given.planes, given.curves, given.claims, given.judged))
    )
    parts["followup"] = measured_later(read_table(given.followup))
    if given.trials:
        names = snakemake.params.trials
        parts["trials"] = reported_trials(dict(zip(names, map(read_table, given.trials), strict=True)))
    if given.stratified:
        now, *earlier = map(read_table, given.stratified)
        parts["stratified"] |= with_ratios(reported_stratified(now), read_table(given.ratios))
        exams = [json.loads(Path(path).read_text(encoding="utf-8")) for path in given.exams]
        parts["stratified"]["earlier"] = [
            {"all": reported_stratified(table)["all"], WORST: exam[WORST]}
            for table, exam in zip(earlier, exams, strict=True)
        ]
        parts["stratified"]["conditions"] = committed.conditions(read_table(given.conditions))
        parts["stratified"]["confidence"] = committed.confidence(read_table(given.confidence))
        parts["stratified"]["earlier_larger"] = committed.larger_as_printed(
            [exam[WORST] for exam in exams], parts["stratified"][WORST], 2
        )
    if given.separation:
        pairs = read_table(given.separation)
        parts["separation"]["separable"] |= committed.separated(pairs)
        parts["separation"]["causes"] = committed.confounded_pairs(pairs)
    if given.correlation:
        parts["correlations"] = committed.strong_correlations(read_table(given.correlation))
    if given.workspace:
        parts["workspace"] = committed.over_workspace(read_table(given.workspace))
    if given.rivals:
        rivals = read_table(given.rivals)
        parts["benchmark"]["with_moment"] = committed.with_moment(rivals)
        parts["benchmark"]["by_names"] = committed.by_names(rivals)
        parts["benchmark"]["not_run_before"] = committed.not_run_before(rivals)
    if "measured_rivals" in parts:
        parts["measured_rivals"] |= counts(parts["measured_rivals"]["sets"])
    if "measured_published" in parts:
        parts["measured_published"] |= beside(
            parts["measured_published"]["sets"], read_table(given.published_measured)
        )
    parts["compared"] = compared(parts)
    write_json(snakemake.output[0], {"draft": snakemake.params.draft} | gather(parts))
