"""What a figure calls the thresholds that it shows: words of the paper instead of the names that the code uses."""

LABELS = {
    "selection.least_improvement": "least gain on held-out poses [standard errors]",
    "naming.least_confidence": "least confidence of a name",
    "hold_out.folds": "folds of poses",
    "hold_out.blocks_per_fold": "blocks of poses in a fold",
    "estimation.gross_errors.point_sigmas": "distance of a gross error from its line",
    "estimation.gross_errors.pose_sigmas": "distance of a gross error from the fit",
    "spectrum.rows_per_column": "measurements per order of a joint's error",
    "estimation.identifiability.typical_link": "usual error of a length or a twist",
    "estimation.identifiability.typical_count": "weight of these usual errors",
    "estimation.identifiability.typical_zero": "usual error of a joint's zero",
    "estimation.identifiability.prior_matters": "precision that needs no prior",
    "shipped_fit.worth_correcting": "error that a correction may leave",
    "shipped_fit.beyond_chance": "significant difference of predictions",
    "shipped_fit.clearly_smaller_std": "clearly smaller standard error",
    "shipped_fit.clearly_smaller_error": "clearly smaller expected error",
    "estimation.within_scan_noise.winsorised_sigmas": "clipping of residuals of a scan",
    "flexible_terms.replacement_margin": "lead of a flexible term over a name",
    "estimation.fit.misfit_p_value": "probability of a misfit by chance",
    "hold_out.most_gain_of_block": "largest weight of one block",
    "hold_out.most_of_pose": "largest weight of one pose",
    "selection.change_margin": "least number of poses beside a change",
    "selection.swap_margin": "lead of an effect that replaces another",
    "selection.confounded_margin": "lead below which names are listed together",
    "shipped_fit.least_f_statistic": "significance of a correction without a sure name",
    "selection.most_candidates_tried": "candidates that are refitted",
    "observability.unobservable": "share of a column that is unobservable",
}


def label_of(setting: str) -> str:
    """Return what a figure calls a threshold; one without a label is called by its name in words."""
    name = setting.removeprefix("estimation.").replace("_", " ").replace(".", ": ")
    return LABELS.get(setting, name)
